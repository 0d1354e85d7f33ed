//! `predictions.csv`: what was recorded beside what the model predicts, sample by sample.
//!
//! Columns: `recording`, `split` (train or validation), `t` in s, then for each joint
//! `<joint>_recorded`, `<joint>_predicted` in the unit of the signal, or further [`Quantity`]s.

mod read;
mod write;

pub use crate::outcome::predictions::read::{Predictions, RecordingPredictions};
pub use crate::outcome::predictions::write::{Block, PredictionsWriter};

/// The columns before those of the joints.
const LEADING: [&str; 3] = ["recording", "split", "t"];

/// What a column of a joint holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// The signal as recorded, after preprocessing.
    Recorded,
    /// The signal as the model gives it.
    Predicted,
    /// As the model gives it before effects were added.
    Baseline,
    /// As the model gives it with all effects found.
    Final,
    /// Speed of the joint in rad/s or m/s.
    Velocity,
}

impl Quantity {
    pub const ALL: [Quantity; 5] = [
        Quantity::Recorded,
        Quantity::Predicted,
        Quantity::Baseline,
        Quantity::Final,
        Quantity::Velocity,
    ];

    /// The word after the joint's name in the header.
    pub fn as_str(self) -> &'static str {
        match self {
            Quantity::Recorded => "recorded",
            Quantity::Predicted => "predicted",
            Quantity::Baseline => "baseline",
            Quantity::Final => "final",
            Quantity::Velocity => "velocity",
        }
    }
}

#[cfg(test)]
mod tests;
