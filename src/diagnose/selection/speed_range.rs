//! Whether the scales of a law of speed or position lie within what recordings have of it.

use crate::chain::dataset::Prepared;
use crate::chain::effect::Memory;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::estimate::reach::Motion;

/// Whether a law of speed changes within the speeds of its joint, as fitted, and one that repeats does within its positions;
/// true of any other effect. One that does not is a line with some bend, and imitates others. Held-out recordings count too:
/// a law that goes on beyond what was fitted as it was fitted is no imitation. What remembers is left out: it changes with
/// more than speed.
pub fn are_reached(context: &Context<'_>, fit: &ModelFit, hypothesis: &Hypothesis) -> bool {
    if hypothesis.effect.needs.memory != Memory::None {
        return true;
    }
    let all: Vec<&Prepared> = context.data.recordings.iter().collect();
    hypothesis.joints.iter().all(|&joint| {
        let motion = Motion::of(&all, joint);
        let mut parameters = fit.model.joints()[joint].parameters_of(hypothesis.effect.id);
        parameters.all(|(info, at)| motion.shows(info.search, fit.values[at]))
    })
}
