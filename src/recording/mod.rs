//! From files to motion and signal: tables, channels, time base, periods, derivatives, noise.
//!
//! # Files in the order of the work
//!
//! | step | files |
//! |---|---|
//! | a file becomes a table | `formats/`, also arrays of a program |
//! | columns become channels in SI units | `channels/`, by `units` |
//! | flaws of rows | `quality/`, with `row_faults` |
//! | the time base | `time_base/` |
//! | one recording from several files | `join/` |
//! | motion with derivatives, signal with noise | `prepare/`, its `prepare/periods/` where the motion repeats, else its `prepare/derivatives/` |
//! | which recordings are fitted | `split` |
//!
//! Imports follow this order upwards; all may use `series/`, the mathematics of sampled series.

mod channels;
pub mod error;
mod formats;
pub mod join;
mod prepare;
mod quality;
pub mod row_faults;
mod series;
pub mod split;
mod time_base;
pub mod units;

pub use crate::recording::channels::{column_map, columns, lost, missing, samples, survey};
pub use crate::recording::formats::{format, memory, reading, table};
pub use crate::recording::prepare::periods::{clock_drift, period, successive_periods};
pub use crate::recording::prepare::{experiment, motion_error, noise_level, preprocess, settings};
pub use crate::recording::quality::{copies, filtered, jumps, lost_signal, spikes, upsampling};
pub use crate::recording::time_base::{clock, timing};

#[cfg(test)]
mod tests;
