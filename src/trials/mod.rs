//! Trials of the diagnosis: random robots are simulated with physics that the declared model lacks, or with none
//! lacking, and the diagnosis sees nothing but the recordings and the declared model.
//!
//! The robot, the physics, its size, the motion and the noise of a trial follow from the seed and the trial's number alone.
//! Motion and noise are drawn apart: the same trial of another motion has the same robot and the same physics.
//! The size of what is concealed is the held-out RMS of what the declared model, fitted to recordings without
//! noise, leaves of it, over the RMS noise of a row: what the fitted parameters absorb is no misfit.

pub mod bodies;
pub mod calibration;
pub mod concealed_effect;
pub mod error;
pub mod files;
pub mod forecast;
mod law_size;
pub mod longer_recording;
pub mod motion;
mod naming;
pub mod outside_law;
pub mod plan;
pub mod reference_fits;
pub mod robot;
pub mod run;
pub mod score;
pub mod tally;
pub mod unmodelled_physics;

#[cfg(test)]
mod tests;
