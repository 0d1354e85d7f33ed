//! Whether the scales of a law of speed or position lie within what recordings have of it.

use crate::chain::dataset::Prepared;
use crate::chain::effect::{Memory, Search};
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::estimate::search_range::MotionRange;
use crate::recording::split::Split;

/// Whether a law of speed changes within the speeds of its joint, as fitted, and one that repeats does within its positions;
/// true of any other effect. One that does not is a line with some bend, and imitates others. Positions of held-out
/// recordings count too: what repeats beyond the fitted range as it was fitted is no imitation. What remembers is left out: it
/// changes with more than speed.
pub fn are_reached(context: &Context<'_>, fit: &ModelFit, hypothesis: &Hypothesis) -> bool {
    if hypothesis.effect.needs.memory != Memory::None {
        return true;
    }
    let train = context.recordings(Split::Train);
    let all: Vec<&Prepared> = context.data.recordings.iter().collect();
    hypothesis.joints.iter().all(|&joint| {
        let [fitted, whole] = [&train, &all].map(|recordings| MotionRange::of(recordings, joint));
        let mut parameters = fit.model.joints()[joint].parameters_of(hypothesis.effect.id);
        parameters.all(|(info, at)| {
            let motion = match info.search {
                Search::Cycles => &whole,
                _ => &fitted,
            };
            motion.covers(info.search, fit.values[at])
        })
    })
}
