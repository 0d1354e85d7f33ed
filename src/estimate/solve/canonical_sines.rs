//! The canonical form of sinusoids: of two parameter sets of one sine, the one with the amplitude that is not negative.
//!
//! ```text
//! a sin(x + φ) = −a sin(x + φ + π) = a sin(x + φ ± 2π):   a ≥ 0,  −π ≤ φ ≤ π
//! ```

use crate::chain::effect::knowledge::Sine;
use crate::estimate::fit_problem::problem::FitProblem;
use crate::problem::Problem;
use crate::problem::solution::Solution;
use std::f64::consts::{PI, TAU};

/// The same optimum with amplitudes that are not negative and phases of half a turn at most, where both are unknowns by
/// themselves, no prior speaks of them and their limits hold what they become.
pub(crate) fn canonical(problem: &FitProblem<'_>, mut solution: Solution) -> Solution {
    for joint in problem.model.joints() {
        for (effect, _) in &joint.effects {
            for sine in effect.knowledge.sines {
                let named = |name: &str| {
                    let mut own = joint.parameters_of(effect.id);
                    own.find(|(info, _)| info.name == name).map(|(_, at)| at)
                };
                let Sine { amplitude, phase } = sine;
                let (Some(amplitude), Some(phase)) = (named(amplitude), named(phase)) else {
                    continue;
                };
                // The sign of an amplitude that joints have in common is that of all of their phases.
                let joints = [amplitude, phase].map(|p| problem.model.sharing(p).len());
                let places = (alone(problem, amplitude), alone(problem, phase));
                if let ((Some(amplitude), Some(phase)), true) = (places, joints[0] == joints[1]) {
                    turn(problem, &mut solution, amplitude, phase);
                }
            }
        }
    }
    solution
}

/// The place among the unknowns of a parameter that is one by itself, of which no prior speaks.
fn alone(problem: &FitProblem<'_>, parameter: usize) -> Option<usize> {
    let unknowns = problem.unknowns;
    let place = unknowns.positions().iter().position(|&p| p == parameter)?;
    let is_new = !problem.prior.speaks_of(parameter);
    (unknowns.is_single(place) && is_new).then_some(place)
}

fn turn(problem: &FitProblem<'_>, solution: &mut Solution, amplitude: usize, phase: usize) {
    let (a, half) = match solution.x[amplitude] {
        negative if negative < 0.0 => (-negative, PI),
        a => (a, 0.0),
    };
    let turned = solution.x[phase] + half;
    let turned = turned - TAU * (turned / TAU).round();
    let variables = &problem.form().variables;
    let fits = |k: usize, value: f64| (variables[k].lower..=variables[k].upper).contains(&value);
    if !fits(amplitude, a) || !fits(phase, turned) || turned == solution.x[phase] {
        return;
    }
    solution.x[amplitude] = a;
    solution.x[phase] = turned;
    let moved = [amplitude, phase].map(|k| &variables[k].name);
    solution
        .active_bounds
        .retain(|bound| !moved.contains(&&bound.variable));
}
