//! Laws that a search has carried away.
//!
//! Where the scale of a law shrinks below every speed of the motion, its size may grow without limit for the sake of the one row that
//! is next to it: `Fs exp(−(v/vs)²)` with vs → 0 and Fs → ∞. Recordings tell nothing of such a law, and other motions would have all
//! of it.

use crate::chain::effect::Unit;
use crate::chain::model::Model;
use crate::chain::parameter::Role;
use crate::estimate::fit_problem::problem::FitProblem;
use crate::estimate::minimisation::minimise::torque_per_signal;
use nalgebra::DVector;

/// No law of a joint has a torque this many times the largest that was recorded of it: gravity, inertia and friction of one joint
/// cancel to some per cent of themselves at the most.
const FAR: f64 = 1e3;

/// A law at a joint, by their positions in the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct LawAt {
    joint: usize,
    effect: usize,
}

/// The unknowns, by their numbers, of laws of which one has a torque that is not possible.
pub fn unknowns(problem: &FitProblem<'_>, x: &DVector<f64>) -> Vec<usize> {
    let positions = problem.unknowns.positions();
    let law = |k: usize| match problem.model.parameters()[positions[k]].role {
        Role::Effect { joint, effect, .. } => Some(LawAt { joint, effect }),
        _ => None,
    };
    let is_far = |k: &usize| {
        let limit = largest_torque(problem, positions[*k]);
        limit.is_some_and(|largest| x[*k].abs() > FAR * largest)
    };
    let away: Vec<LawAt> = (0..x.len()).filter(is_far).filter_map(law).collect();
    let is_lost = |k: &usize| law(*k).is_some_and(|law| away.contains(&law));
    (0..x.len()).filter(is_lost).collect()
}

/// The largest recorded torque of the joint of a law, where a parameter is a torque of it.
fn largest_torque(problem: &FitProblem<'_>, position: usize) -> Option<f64> {
    let model: &Model = problem.model;
    let Role::Effect {
        joint,
        effect,
        parameter,
    } = model.parameters()[position].role
    else {
        return None;
    };
    let info = &model.joints()[joint].effects[effect].0.parameters[parameter];
    let channels = model.channels().iter();
    let channel = channels
        .enumerate()
        .find(|(_, channel)| channel.active && channel.joint == Some(joint));
    let (channel, _) = channel.filter(|_| info.unit == Unit::Torque)?;
    let signals = problem.recordings.iter().flat_map(|r| r.signal(channel));
    let largest = signals.fold(0.0_f64, |largest, s| largest.max(s.abs()));
    let torque = largest * torque_per_signal(model, joint);
    (torque > 0.0).then_some(torque)
}
