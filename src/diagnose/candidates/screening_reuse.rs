//! Reuse of the score tests of other models, where they still hold.
//!
//! What a hypothesis explains of a joint does not move where neither the residual of that joint nor what the model has there has
//! changed: its best point stays the best, and only what it gains there is worked out anew.

use crate::diagnose::fit::candidate::Screening;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::residuals::effect_size::HALF_OF_WHAT_MATTERS;

/// Earlier screenings beside the model as it is now.
#[derive(Debug)]
pub struct Reusable<'a> {
    fit: &'a ModelFit,
    /// The latest first.
    screened: Vec<Screened>,
}

/// The screening of one model.
#[derive(Debug)]
struct Screened {
    hypotheses: Vec<Hypothesis>,
    screening: Screening,
    /// Of the channel of each joint: whether its residual there is that of the model as it is now.
    alike: Vec<bool>,
}

impl<'a> Reusable<'a> {
    /// Of all models that were screened.
    pub fn of(context: &Context<'_>, fit: &'a ModelFit) -> Self {
        let beside = |other: &ModelFit, screening: &Screening| Screened {
            alike: alike(other, fit),
            hypotheses: other.hypotheses.clone(),
            screening: screening.clone(),
        };
        let mut screened = context.cache.of_screened(beside);
        screened.reverse();
        Self { fit, screened }
    }

    /// The latest screening in which what was found of a hypothesis still holds.
    pub fn screening(&self, hypothesis: &Hypothesis) -> Option<&Screening> {
        let mut screened = self.screened.iter();
        let latest = screened.find(|one| self.holds(one, hypothesis))?;
        Some(&latest.screening)
    }

    /// Whether what was found of a hypothesis beside a model with `others` still holds.
    pub fn stands(&self, others: &[Hypothesis], hypothesis: &Hypothesis) -> bool {
        let mut screened = self.screened.iter();
        screened.any(|one| one.hypotheses == others && self.holds(one, hypothesis))
    }

    /// Whether what a screening found of a hypothesis holds: it acts on the signals of its joints alone, or mostly, and none of these
    /// joints has another residual, or other physics, than it had there.
    fn holds(&self, screened: &Screened, hypothesis: &Hypothesis) -> bool {
        let named = hypothesis.named_joints();
        let is_alike = |joint: &usize| screened.alike.get(*joint).is_some_and(|alike| *alike);
        hypothesis.is_of_its_joints()
            && named.iter().all(is_alike)
            && screened.screening.open.contains(hypothesis)
            && on(&screened.hypotheses, &named) == on(&self.fit.hypotheses, &named)
    }
}

/// The hypotheses that act on one of some joints.
fn on<'h>(hypotheses: &'h [Hypothesis], joints: &[usize]) -> Vec<&'h Hypothesis> {
    let acts = |h: &&Hypothesis| h.named_joints().iter().any(|j| joints.contains(j));
    hypotheses.iter().filter(acts).collect()
}

/// Of each joint, whether two models leave the same of its channel, and of those that belong to no joint.
fn alike(other: &ModelFit, fit: &ModelFit) -> Vec<bool> {
    let channels = fit.model.channels().iter().enumerate();
    let moved = channels.filter(|(c, _)| has_moved(&other.train[*c], &fit.train[*c]));
    let moved: Vec<Option<usize>> = moved.map(|(_, channel)| channel.joint).collect();
    let is_alike = |joint: usize| !moved.contains(&None) && !moved.contains(&Some(joint));
    (0..fit.model.joints().len()).map(is_alike).collect()
}

/// Whether residuals have changed by more than half of what matters.
fn has_moved(before: &[f64], after: &[f64]) -> bool {
    let squares = |x: f64| x * x;
    let change: f64 = before.iter().zip(after).map(|(a, b)| squares(a - b)).sum();
    let all: f64 = before.iter().map(|x| squares(*x)).sum();
    change > HALF_OF_WHAT_MATTERS * all
}
