//! Laws that a search has carried away.
//!
//! Where the scale of a law shrinks below every speed of the motion, its size may grow without limit for the sake of the one row that
//! is next to it: `Fs exp(−(v/vs)²)` with vs → 0 and Fs → ∞. Recordings tell nothing of such a law, and other motions would have all
//! of it.

use crate::chain::effect::Unit;
use crate::chain::effect_parameter::EffectParameter;
use crate::estimate::fit_problem::problem::FitProblem;
use crate::estimate::initial::search_range::largest_torque;
use nalgebra::DVector;

/// No law of a joint has a torque this many times the largest that was recorded of it: gravity, inertia and friction of one joint
/// cancel to some per cent of themselves at the most.
const FAR: f64 = 1e3;

/// The unknowns, by their numbers, of laws of which one has a torque that is not possible.
pub fn unknowns(problem: &FitProblem<'_>, x: &DVector<f64>) -> Vec<usize> {
    let positions = problem.unknowns.positions();
    let largest: Vec<Option<f64>> = (0..problem.model.joints().len())
        .map(|joint| largest_torque(problem.model, problem.recordings, joint))
        .collect();
    let law = |k: usize| problem.model.effect_parameter(positions[k]);
    let is_far = |k: usize, own: &EffectParameter| {
        let limit = largest[own.joint].filter(|_| own.info.unit == Unit::Torque);
        limit.is_some_and(|largest| x[k].abs() > FAR * largest)
    };
    let place = |own: EffectParameter| (own.joint, own.number);
    let away: Vec<(usize, usize)> = (0..x.len())
        .filter_map(|k| law(k).filter(|own| is_far(k, own)).map(place))
        .collect();
    let is_lost = |k: &usize| law(*k).is_some_and(|own| away.contains(&place(own)));
    (0..x.len()).filter(is_lost).collect()
}
