//! Reuse of the score tests of a model that is poorer by one hypothesis, where they still hold.
//!
//! What a hypothesis explains of a joint does not move where the residual of that joint has not moved: its best point
//! stays the best, and only what it gains there is worked out anew.

use crate::chain::effect::Law;
use crate::diagnose::fit::candidate::{Candidate, Screening};
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::residuals::effect_size::HALF_OF_WHAT_MATTERS;

/// An earlier screening beside the model as it is now.
#[derive(Debug, Default)]
pub struct Reusable {
    screening: Screening,
    /// Of the channel of each joint: whether its residual has stayed.
    stayed: Vec<bool>,
}

impl Reusable {
    /// Of the model with one hypothesis less; of none where none was screened.
    pub fn of(context: &Context<'_>, fit: &ModelFit) -> Self {
        let Some((poorer, screening)) = context.cache.one_less(&fit.hypotheses) else {
            return Self::default();
        };
        let channels = fit.model.channels().iter().enumerate();
        let moved = channels.filter(|(c, _)| has_moved(&poorer.train[*c], &fit.train[*c]));
        let moved: Vec<Option<usize>> = moved.map(|(_, channel)| channel.joint).collect();
        let has_stayed = |joint: usize| !moved.contains(&None) && !moved.contains(&Some(joint));
        Self {
            screening,
            stayed: (0..fit.model.joints().len()).map(has_stayed).collect(),
        }
    }

    /// Whether what was found of a hypothesis still holds: it acts on the signals of its joints alone, or mostly, and
    /// none of these has moved.
    pub fn stands(&self, hypothesis: &Hypothesis) -> bool {
        let is_of_joints = !matches!(hypothesis.effect.law, Law::Body | Law::Tilt);
        let named = hypothesis.named_joints();
        let stayed = |joint: &usize| self.stayed.get(*joint).is_some_and(|stayed| *stayed);
        is_of_joints && named.iter().all(stayed) && self.screening.open.contains(hypothesis)
    }

    /// What was found of a hypothesis by a glance, if it promised something.
    pub fn candidate(&self, hypothesis: &Hypothesis) -> Option<Candidate> {
        let mut candidates = self.screening.glance.iter();
        candidates
            .find(|candidate| candidate.hypothesis == *hypothesis)
            .cloned()
    }
}

/// Whether residuals have changed by more than half of what matters.
fn has_moved(before: &[f64], after: &[f64]) -> bool {
    let squares = |x: f64| x * x;
    let change: f64 = before.iter().zip(after).map(|(a, b)| squares(a - b)).sum();
    let all: f64 = before.iter().map(|x| squares(*x)).sum();
    change > HALF_OF_WHAT_MATTERS * all
}
