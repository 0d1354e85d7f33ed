//! `predictions.csv`: what was recorded beside what the model predicts, sample by sample.
//!
//! Columns: `recording`, `split` (train or validation), `t` in s, then for each joint
//! `<joint>_recorded`, `<joint>_predicted` in the unit of the signal, or further [`Quantity`]s; of a joint without a motor,
//! which closed loops move, its motion alone.

mod quantity;
mod read;
mod write;

pub use crate::outcome::predictions::quantity::{Column, Quantity};
pub use crate::outcome::predictions::read::{Predictions, RecordingPredictions};
pub use crate::outcome::predictions::write::{Block, PredictionsWriter};

#[cfg(test)]
mod tests;
