//! Confounding: names for a part of a law that the vocabulary does not have.
//!
//! Where something is left beside a finding, in the same channel, what is missing there may be one law of another joint's
//! motion: a channel that hears the current of another, friction that grows with a neighbour's position. Such a law has shapes
//! in common with many names, its mean with a torque offset, its slope over the load with a gain, and the name that it resembles
//! most takes a large part of it. In the place of the name there is put a smooth correction, beside all parameters of the model:
//!
//! ```text
//! ‖e_k − c_k‖² ≤ (1 + IN_DOUBT) ‖e − c‖²    in every channel, e_k without the name and e with it
//! ```
//!
//! If that leaves hardly more of recordings that were not fitted than the name and a correction beside it, the name is not that
//! of the physics, and is withdrawn. A correction by the joint's own motion and load is another wording of the name, and says
//! nothing against it.

use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::hypothesis::channels_of;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::residuals::additive_model::{self, AdditiveModel};
use crate::diagnose::selection::rival_models::{IN_DOUBT, RivalComparison};
use crate::stats::deviation::rms;

/// The first finding of a model that is superfluous beside a smooth correction, if there is one, where such a correction is
/// needed beside the model at `significance`.
pub fn first(
    context: &Context<'_>,
    full: &ModelFit,
    comparisons: &[RivalComparison],
    significance: f64,
) -> Option<usize> {
    if context.control.is_interrupted() {
        return None;
    }
    let channels_of = |k: usize| channels_of(&full.model, &full.hypotheses[k].named_joints());
    let mut named: Vec<usize> = (0..comparisons.len()).flat_map(channels_of).collect();
    named.sort_unstable();
    named.dedup();
    let mut corrections = additive_model::of_some(context, full, &named);
    let tried = corrections.len();
    corrections.retain(|correction| correction.is_needed(significance, tried));
    (0..comparisons.len()).find(|&k| {
        let channels = channels_of(k);
        let beside = corrections.iter();
        let beside: Vec<&AdditiveModel> =
            beside.filter(|c| channels.contains(&c.channel)).collect();
        !beside.is_empty() && is_superfluous(context, full, &beside, &comparisons[k].without)
    })
}

/// Whether a model without a finding and with smooth corrections leaves no more than the one with both.
fn is_superfluous(
    context: &Context<'_>,
    full: &ModelFit,
    beside: &[&AdditiveModel],
    without: &ModelFit,
) -> bool {
    let instead = additive_model::in_place(context, without, beside);
    if instead.len() < beside.len() || instead.iter().all(|correction| correction.is_own) {
        return false;
    }
    let poorer =
        additive_model::left_everywhere(context, without, &instead.iter().collect::<Vec<_>>());
    let richer = additive_model::left_everywhere(context, full, beside);
    let mean_square = |residual: &[f64]| rms(residual).powi(2);
    let pairs = poorer.iter().zip(&richer);
    let mut each = pairs.map(|(poorer, richer)| [mean_square(poorer), mean_square(richer)]);
    each.all(|[poorer, richer]| poorer <= (1.0 + IN_DOUBT) * richer)
}
