//! Whether the scales of speed of a law lie within the speeds that recordings have.

use crate::chain::effect::Memory;
use crate::chain::parameter::Role;
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
    let model = &refit.model;
    let train = bench.recordings(Split::Train);
    let mut parameters = model.parameters().iter().zip(refit.values.iter());
    parameters.all(|(parameter, value)| {
        let Role::Effect {
            joint,
            effect,
            parameter,
        } = parameter.role
        else {
            return true;
        };
        let (law, _) = model.joints()[joint].effects[effect];
        let is_own = law.id == hypothesis.effect.id && hypothesis.joints.contains(&joint);
        let info = law.parameters.get(parameter).filter(|_| is_own);
        info.is_none_or(|info| Motion::of(&train, joint).shows(info.search, *value))
    })
}
