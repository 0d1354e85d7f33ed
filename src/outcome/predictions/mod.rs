//! `predictions.csv`: what was recorded beside what the model predicts, sample by sample.
//!
//! Columns: `recording`, `split` (train or validation), `t` in s, then for each joint
//! `<joint>_recorded`, `<joint>_predicted` in the unit of the signal, or further [`Quantity`]s.

mod quantity;
mod read;
mod write;

pub use crate::outcome::predictions::quantity::Quantity;
pub use crate::outcome::predictions::read::{Predictions, RecordingPredictions};
pub use crate::outcome::predictions::write::{Block, PredictionsWriter};

#[cfg(test)]
mod tests;
