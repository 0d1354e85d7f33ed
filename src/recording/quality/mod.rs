//! Data quality: spikes, jumps, signals that are cut off, stand still or were low-passed, upsampled channels, and rows that two
//! recordings have in common.

pub mod copies;
pub mod filtered;
pub mod jumps;
pub mod lost_signal;
mod resolution;
pub mod spikes;
pub mod upsampling;
