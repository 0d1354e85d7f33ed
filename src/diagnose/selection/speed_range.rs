//! Whether the scales of speed of a law lie within the speeds that recordings have.

use crate::chain::effect::Memory;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::estimate::reach::Motion;
use crate::recording::split::Split;

/// Whether a law of speed changes within the speeds of its joint, as fitted, and one that repeats does within its positions;
/// true of any other effect. One that does
/// not is a line with some bend, and imitates others. What remembers is left out: it changes with more than speed.
pub fn are_reached(context: &Context<'_>, fit: &ModelFit, hypothesis: &Hypothesis) -> bool {
    if hypothesis.effect.needs.memory != Memory::None {
        return true;
    }
    let train = context.recordings(Split::Train);
    hypothesis.joints.iter().all(|&joint| {
        let motion = Motion::of(&train, joint);
        let mut parameters = fit.model.joints()[joint].parameters_of(hypothesis.effect.id);
        parameters.all(|(info, at)| motion.shows(info.search, fit.values[at]))
    })
}
