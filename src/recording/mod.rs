//! From files to motion and signal: tables, channels, time base, periods, derivatives, noise.
//!
//! # Files in the order of the work
//!
//! | step | files |
//! |---|---|
//! | a file becomes a table | `format` chooses among `csv`, `parquet`, `hdf5`, `mat`, `npz` and `bag/`; arrays of a program: `memory` |
//! | columns become channels in SI units | `columns`, by `column_map` and `column_names`; `join/` from several files |
//! | flaws of rows | `missing`, `upsampling`, `spikes`, `copies`; `separate_encoder` where positions are in another file |
//! | the time base | `timing`, `clock` |
//! | positions become velocities and accelerations | `preprocess` begins: `periodic` (by `fourier`) where the motion repeats, else `aperiodic` (`differentiate`, by `smoother` or `zero_phase`) |
//! | the noise | `periodic` from the scatter about the `period_average`, `noise_level` from differences of samples |
//! | single periods | `sample_by_sample`, `successive_periods` in place of the average |
//! | what comes out | `experiment` |

pub mod aperiodic;
mod arrays;
mod arrow_schema;
pub mod bag;
pub mod clock;
pub mod column_map;
mod column_names;
pub mod columns;
pub mod command;
pub mod copies;
pub mod csv;
mod cutoff;
mod differences;
mod differentiate;
mod encoding;
pub mod error;
pub mod experiment;
mod filter;
pub mod format;
mod fourier;
pub mod hdf5;
mod interpolation;
pub mod join;
pub mod mat;
mod mat4;
pub mod memory;
pub mod missing;
pub mod noise_level;
pub mod npz;
mod number_type;
pub mod parquet;
pub mod period;
mod period_average;
pub mod periodic;
pub mod preprocess;
pub mod reading;
mod resolution;
pub mod row_faults;
mod sample_by_sample;
pub mod samples;
pub mod separate_encoder;
pub mod settings;
mod smoother;
mod spectrum;
pub mod spikes;
mod spline;
pub mod split;
pub mod successive_periods;
pub mod survey;
pub mod table;
pub mod timing;
pub mod units;
pub mod upsampling;
pub mod zero_phase;

#[cfg(test)]
mod tests;
