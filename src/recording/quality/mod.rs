//! Data quality: spikes, signals that are cut off or stand still, upsampled channels, and rows that two recordings have in common.

pub mod copies;
pub mod lost_signal;
mod resolution;
pub mod spikes;
pub mod upsampling;
