//! From files to motion and signal: tables, channels, time base, periods, derivatives, noise.

pub mod apart;
pub mod aperiodic;
mod arrays;
pub mod bag;
pub mod clock;
pub mod column_map;
mod column_names;
pub mod columns;
pub mod copies;
pub mod csv;
mod cutoff;
mod differences;
mod differentiate;
pub mod error;
pub mod experiment;
mod fill;
mod filter;
mod fourier;
pub mod held;
mod layout;
pub mod mat;
mod noise_level;
pub mod npz;
mod number_type;
pub mod parquet;
pub mod period;
pub mod periodic;
pub mod row_faults;
pub mod settings;
mod smoother;
mod spectrum;
pub mod split;
pub mod table;
pub mod timing;
mod unfold;
pub mod units;
pub mod unrolled;
mod written;
pub mod zero_phase;

#[cfg(test)]
mod tests;
