//! `[simulate]`: the trajectory, how it is recorded, and the truth behind it.

use crate::problem_file::choices::SimulationMode;
use crate::problem_file::context::Context;
use crate::problem_file::document::Node;
use crate::problem_file::error::{NumberFault, ProblemFileError};
use crate::problem_file::key::{Form, Key, Range, words};
use crate::problem_file::located::{FilePath, Located, Named, PerJoint};
use crate::problem_file::reader::Reader;
use crate::problem_file::values;

/// Keys of `[simulate]`.
#[rustfmt::skip]
pub(crate) const KEYS: &[Key] = &[
    Key { name: "trajectory", form: Form::Text, unit: "", default: "\"random\"", example: "\"trajectory.csv\"", meaning: "\"random\", a feasible Fourier series; \"tones\", \"moves\" or \"sweeps\", which do not repeat; or a file with columns t, q_<joint>, dq_<joint>, ddq_<joint>" },
    Key { name: "mode", form: Form::Words(words::<SimulationMode>), unit: "", default: "\"inverse\"", example: "\"closed_loop\"", meaning: "The motion is the trajectory and the signal what it takes, or forward dynamics under a PD controller with feed-forward" },
    Key { name: "periods", form: Form::Count(1), unit: "", default: "6", example: "4", meaning: "Periods that are recorded" },
    Key { name: "warmup_periods", form: Form::Count(0), unit: "", default: "1", example: "0", meaning: "Periods before the recording" },
    Key { name: "rate", form: Form::Number(Range::Positive), unit: "Hz", default: "recordings.rate", example: "250.0", meaning: "Samples per second" },
    Key { name: "noise", form: Form::PerJoint(Range::NonNegative), unit: "the signal's", default: "none", example: "[0.5, 0.5]", meaning: "Standard deviation of the signal" },
    Key { name: "noise_correlation", form: Form::Number(Range::Correlation), unit: "", default: "0.0", example: "0.9", meaning: "Correlation of the noise of neighbouring samples" },
    Key { name: "encoder_counts", form: Form::PerJoint(Range::Positive), unit: "1 per turn (1/m)", default: "no quantisation", example: "524288", meaning: "Counts of the encoders" },
    Key { name: "values", form: Form::Named(&Form::Number(Range::Finite)), unit: "each parameter's own", default: "what the robot file has", example: "{ \"a3.transmission_efficiency.R\" = 0.84 }", meaning: "The truth: values of parameters by name" },
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
