//! What all fits of a diagnosis share: the problem, the recordings, the way to a model with further physics.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::model::Model;
use crate::chain::prior::Prior;
use crate::diagnose::hypothesis::{Hypothesis, addition};
use crate::diagnose::memory::Memory;
use crate::problem::solution::Control;
use crate::problem_file::ProblemFile;
use crate::recording::split::Split;
use crate::setup::error::SetupError;
use crate::setup::robot::Robot;
use crate::setup::{model, prior};

/// The problem with its recordings.
pub struct Bench<'a> {
    pub problem: &'a ProblemFile,
    pub robot: &'a Robot,
    pub data: &'a Dataset,
    pub control: &'a Control<'a>,
    /// Rows are samples in the order of time, not averages over periods.
    pub in_time: bool,
    /// RMS noise of one row per channel, averages over periods where there are any; `None` where nothing repeats.
    pub noise: Option<Vec<f64>>,
    pub memory: Memory,
}

impl Bench<'_> {
    /// The declared model with the physics of hypotheses.
    pub fn model(&self, hypotheses: &[Hypothesis]) -> Result<(Model, Prior), SetupError> {
        let mut model =
            model::build_with_addition(self.problem, self.robot, &addition(hypotheses))?;
        let prior = prior::build(self.problem, &mut model)?;
        Ok((model, prior))
    }

    pub fn recordings(&self, split: Split) -> Vec<&Prepared> {
        self.data.of(split).collect()
    }
}
