//! Data quality: spikes, upsampled channels, and rows that two recordings have in common.

pub mod copies;
mod resolution;
pub mod spikes;
pub mod upsampling;
