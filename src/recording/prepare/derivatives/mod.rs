//! Velocity and acceleration of a motion that does not repeat: its bandwidth, a fixed-interval Kalman smoother, or a low-pass
//! and central differences.

mod cutoff;
pub mod differentiate;
mod reversals;
mod smoother;
