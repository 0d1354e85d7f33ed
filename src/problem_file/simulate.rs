//! `[simulate]`: the trajectory, how it is recorded, and the truth behind it.

use crate::problem_file::choices::SimulationMode;
use crate::problem_file::document::Node;
use crate::problem_file::error::{NumberFault, ProblemFileError};
use crate::problem_file::located::{FilePath, Located, Named, PerJoint};
use crate::problem_file::reader::Reader;
use crate::problem_file::{Context, values};

pub(crate) const KEYS: &[&str] = &[
    "trajectory",
    "mode",
    "periods",
    "warmup_periods",
    "rate",
    "noise",
    "noise_correlation",
    "encoder_counts",
    "values",
];

/// Periods after the warm-up: enough to tell noise from what repeats.
const DEFAULT_PERIODS: usize = 6;
const DEFAULT_WARMUP_PERIODS: usize = 1;

/// The table `[simulate]`.
#[derive(Debug, Clone)]
pub struct SimulateTable {
    /// Default: [`Trajectory::Random`].
    pub trajectory: Located<Trajectory>,
    /// Default: [`SimulationMode::Inverse`].
    pub mode: Located<SimulationMode>,
    /// Recorded periods, at least 1. Default: 6. A motion that does not repeat is recorded for as many of
    /// `design.period`.
    pub periods: Located<usize>,
    /// Periods before the recording. Default: 1.
    pub warmup_periods: Located<usize>,
    /// Hz, positive. Default: `recordings.rate`.
    pub rate: Option<Located<f64>>,
    /// Standard deviation per joint in the signal's unit, not negative. Default: none.
    pub noise: Option<Located<PerJoint>>,
    /// Correlation of the noise of neighbouring samples, 0 ≤ ρ < 1. Default: 0, white noise.
    pub noise_correlation: Located<f64>,
    /// Per turn (per metre for a sliding joint), positive. Default: no quantisation.
    pub encoder_counts: Option<Located<PerJoint>>,
    /// The truth: parameters by name, in their own units. Default: what the robot file has.
    pub values: Vec<Named<f64>>,
}

/// The motion that is simulated.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Trajectory {
    /// A feasible Fourier trajectory, drawn with the seed.
    Random,
    /// Sines of frequencies that have no common period, drawn with the seed.
    Tones,
    /// From pose to pose with short rests, drawn with the seed.
    Moves,
    /// Sines of growing frequency, drawn with the seed.
    Sweeps,
    /// A file with columns `t`, `q_<joint>`, `dq_<joint>`, `ddq_<joint>`.
    File(FilePath),
}

impl SimulateTable {
    pub(super) fn from_node(node: &Node, context: &Context) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, KEYS)?;
        Ok(Self {
            trajectory: reader.or("trajectory", Trajectory::Random, |n| {
                let path = values::file_path(n, context)?;
                Ok(match path.written.as_str() {
                    "random" => Trajectory::Random,
                    "tones" => Trajectory::Tones,
                    "moves" => Trajectory::Moves,
                    "sweeps" => Trajectory::Sweeps,
                    _ => Trajectory::File(path),
                })
            })?,
            mode: reader.or("mode", SimulationMode::Inverse, values::choice)?,
            periods: reader.or("periods", DEFAULT_PERIODS, values::count)?,
            warmup_periods: reader.or(
                "warmup_periods",
                DEFAULT_WARMUP_PERIODS,
                values::count_or_zero,
            )?,
            rate: reader.optional("rate", values::positive)?,
            noise: reader.optional("noise", values::per_joint_non_negative)?,
            noise_correlation: reader.or("noise_correlation", 0.0, correlation)?,
            encoder_counts: reader.optional("encoder_counts", values::per_joint_positive)?,
            values: reader.named("values", values::finite)?,
        })
    }
}

fn correlation(node: &Node) -> Result<f64, ProblemFileError> {
    let value = values::finite(node)?;
    if (0.0..1.0).contains(&value) {
        return Ok(value);
    }
    Err(ProblemFileError::new(
        &node.place,
        NumberFault::OutOfRange {
            found: value.to_string(),
            range: "at least 0 and less than 1",
        },
    ))
}
