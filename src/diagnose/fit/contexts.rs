//! Contexts over the two halves of the held-out rows, one that chooses a model and one that tests it, and over both.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::effect::Lasts;
use crate::chain::transition_limits::TransitionLimits;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::held_out::{Purpose, apart, half};
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::problem::solution::Control;
use crate::recording::split::Split;
use crate::setup::model_spec::ModelSpec;

/// Recordings whose held-out rows are in two halves.
pub struct HeldOutHalves {
    /// All held-out rows.
    pub whole: Dataset,
    selection: Dataset,
    test: Dataset,
    /// Rows of the recordings that are held out to which parameters of one recording are fitted.
    between: Vec<Prepared>,
}

impl HeldOutHalves {
    /// Gives one half of the held-out rows to the choice and the other to the test of what was chosen; `between` are rows of
    /// held-out recordings to which their own parameters are fitted.
    pub fn of(whole: Dataset, between: Vec<Prepared>) -> Self {
        Self {
            selection: half(&whole, Purpose::Selection),
            test: half(&whole, Purpose::Test),
            whole,
            between,
        }
    }

    /// What is declared over either half and over both.
    pub fn contexts<'a>(
        &'a self,
        declared: &'a ModelSpec,
        control: &'a Control<'a>,
    ) -> Contexts<'a> {
        let of = |data| Context::new(declared, data, control);
        Contexts {
            selection: Context {
                between: self.between.clone(),
                ..of(&self.selection)
            },
            test: of(&self.test),
            whole: of(&self.whole),
        }
    }
}

/// The same fits, judged by different held-out rows.
pub struct Contexts<'a> {
    /// Rows by which models are chosen; all models are fitted here.
    pub selection: Context<'a>,
    /// Rows that no choice has seen.
    pub test: Context<'a>,
    /// All rows, of which the figures of the declared and of the final model are.
    pub whole: Context<'a>,
}

impl<'a> Contexts<'a> {
    /// The rows that test a hypothesis: what belongs to one recording may lie in either half, and its evidence knows that
    /// it was sought everywhere.
    pub fn testing(&self, hypothesis: &Hypothesis) -> &Context<'a> {
        match hypothesis.effect.needs.lasts {
            Lasts::OneRecording => &self.whole,
            _ => &self.test,
        }
    }

    /// The rows that were fitted and those by which models were chosen as rows to be fitted, but for those from which noise is remembered
    /// in rows that test; and these.
    pub fn with_selection_fitted(&self, memory: usize) -> Dataset {
        let chose = apart(self.selection.data, self.test.data, memory);
        let as_training = chose.into_iter().map(|mut recording| {
            recording.split = Split::Train;
            recording
        });
        let of = |split: Split| self.test.data.of(split).cloned();
        let recordings = of(Split::Train)
            .chain(as_training)
            .chain(of(Split::Validation));
        Dataset {
            recordings: recordings.collect(),
        }
    }

    /// What is known of these contexts over other rows.
    pub fn over<'b>(&'b self, data: &'b Dataset) -> Context<'b> {
        Context {
            noise: self.test.noise.clone(),
            limits: self.test.limits.clone(),
            ..Context::new(self.test.declared, data, self.test.control)
        }
    }

    /// Gives all contexts the limits of transition speeds and the RMS noise of one row per channel.
    pub fn set(&mut self, limits: &TransitionLimits, noise: Option<&[f64]>) {
        for context in [&mut self.selection, &mut self.test, &mut self.whole] {
            context.limits.clone_from(limits);
            context.noise = noise.map(<[f64]>::to_vec);
        }
    }
}
