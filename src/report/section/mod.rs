//! The sections of the page, one file each: the table below is their order.

mod base_parameters;
mod comparison;
mod correlations;
mod design;
mod diagnosis;
mod evidence;
mod explorer;
mod findings;
pub(super) mod fleet;
mod inputs;
mod joints;
mod load;
mod main_result;
mod motors;
mod notes;
mod parameters;
mod part;
mod preprocessing;
mod rollout;
mod sharing;
mod signals;
mod simulation;
mod simulator;
mod solver;
mod summary;
mod trials;

use crate::outcome::Outcome;
use crate::report::explore::Exploration;
pub(super) use crate::report::section::part::Section;
use crate::report::section::part::Source;
use crate::report::series::Series;

/// Every section in the order of the page; each is absent where it has nothing to say.
const SECTIONS: [fn(&Source) -> Option<Section>; 29] = [
    summary::section,
    load::section,
    fleet::look_at,
    fleet::types,
    fleet::failures,
    diagnosis::missing,
    diagnosis::before_and_after,
    simulator::section,
    evidence::located,
    findings::section,
    joints::section,
    signals::section,
    simulation::section,
    parameters::section,
    sharing::section,
    base_parameters::section,
    base_parameters::of_joint_torques,
    correlations::section,
    evidence::tried,
    comparison::section,
    motors::section,
    trials::section,
    design::motion,
    design::section,
    rollout::section,
    preprocessing::section,
    notes::section,
    solver::section,
    inputs::section,
];

/// The sections that this outcome fills.
pub(super) fn all(outcome: &Outcome, series: &Series, exploration: &Exploration) -> Vec<Section> {
    let source = Source {
        outcome,
        series,
        exploration,
    };
    SECTIONS
        .iter()
        .filter_map(|section| section(&source))
        .collect()
}
