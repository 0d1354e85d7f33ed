//! Whether the scales of speed of a law lie within the speeds that recordings have.

use crate::chain::effect::Memory;
use crate::diagnose::bench::Bench;
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::refit::Refit;
use crate::estimate::reach::Motion;
use crate::recording::split::Split;

/// Whether a law of speed changes within the speeds of its joint, as fitted; true of any other effect. One that does
/// not is a line with some bend, and imitates others. What remembers is left out: it changes with more than speed.
pub fn are_reached(bench: &Bench<'_>, refit: &Refit, hypothesis: &Hypothesis) -> bool {
    if hypothesis.effect.needs.memory != Memory::None {
        return true;
    }
    let train = bench.recordings(Split::Train);
    hypothesis.joints.iter().all(|&joint| {
        let motion = Motion::of(&train, joint);
        let mut parameters = refit.model.joints()[joint].parameters_of(hypothesis.effect.id);
        parameters.all(|(info, at)| motion.shows(info.search, refit.values[at]))
    })
}
