//! From files to motion and signal: tables, channels, time base, periods, derivatives, noise.

pub mod apart;
mod arrays;
pub mod bag;
pub mod columns;
pub mod csv;
mod cutoff;
mod differences;
pub mod error;
pub mod experiment;
mod fill;
mod fourier;
mod layout;
pub mod lowpass;
pub mod mat;
pub mod npz;
mod number_type;
pub mod parquet;
pub mod period;
pub mod periodic;
pub mod settings;
mod spectrum;
pub mod split;
pub mod table;
pub mod timing;
mod unfold;
pub mod unrolled;
pub mod zero_phase;

#[cfg(test)]
mod tests;
