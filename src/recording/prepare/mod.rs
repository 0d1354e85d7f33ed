//! Preprocessing: a recording becomes an experiment, motion with derivatives and signal with noise, averaged over periods
//! where the motion repeats.

pub mod aperiodic;
mod derivatives;
pub mod experiment;
pub mod filter;
pub mod motion_error;
pub mod noise_level;
pub mod periods;
pub mod preprocess;
pub mod settings;
