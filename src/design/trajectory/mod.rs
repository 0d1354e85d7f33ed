//! Trajectories: Fourier series of the joints, their motion sample by sample, closed kinematic loops, and the files of a robot.

pub mod finite_differences;
pub mod fourier_series;
pub mod motion;
pub mod sampled;
