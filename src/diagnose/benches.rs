//! One problem over the held-out rows that choose a model, over those that test what was chosen, and over both.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::effect::Lasts;
use crate::diagnose::bench::Bench;
use crate::diagnose::holdout::{Purpose, half};
use crate::diagnose::hypothesis::Hypothesis;
use crate::problem::solution::Control;
use crate::problem_file::ProblemFile;
use crate::setup::robot::Robot;

/// Recordings whose held-out rows are in two halves.
pub struct Halves {
    pub whole: Dataset,
    selection: Dataset,
    test: Dataset,
    /// Rows of the recordings that are held out to which parameters of one recording are fitted.
    between: Vec<Prepared>,
}

impl Halves {
    pub fn of(whole: Dataset, between: Vec<Prepared>) -> Self {
        Self {
            selection: half(&whole, Purpose::Selection),
            test: half(&whole, Purpose::Test),
            whole,
            between,
        }
    }

    pub fn benches<'a>(
        &'a self,
        problem: &'a ProblemFile,
        robot: &'a Robot,
        control: &'a Control<'a>,
    ) -> Benches<'a> {
        let of = |data| Bench::new((problem, robot), data, control);
        Benches {
            selection: Bench {
                between: self.between.clone(),
                ..of(&self.selection)
            },
            test: of(&self.test),
            whole: of(&self.whole),
        }
    }
}

/// The same fits, judged by different held-out rows.
pub struct Benches<'a> {
    /// Rows by which models are chosen; all models are fitted here.
    pub selection: Bench<'a>,
    /// Rows that no choice has seen.
    pub test: Bench<'a>,
    /// All rows, of which the figures of the declared and of the final model are.
    pub whole: Bench<'a>,
}

impl<'a> Benches<'a> {
    /// The rows that test a hypothesis: what belongs to one recording may lie in either half, and its evidence knows that
    /// it was sought everywhere.
    pub fn testing(&self, hypothesis: &Hypothesis) -> &Bench<'a> {
        match hypothesis.effect.needs.lasts {
            Lasts::OneRecording => &self.whole,
            _ => &self.test,
        }
    }

    /// The RMS noise of one row per channel.
    pub fn set_noise(&mut self, noise: Option<Vec<f64>>) {
        for bench in [&mut self.selection, &mut self.test, &mut self.whole] {
            bench.noise.clone_from(&noise);
        }
    }
}
