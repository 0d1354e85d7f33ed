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
mod motors;
mod notes;
mod parameters;
mod preprocessing;
mod rollout;
mod signals;
mod simulation;
mod simulator;
mod solver;
mod summary;
mod trials;

use crate::outcome::Outcome;
use crate::outcome::Part;
use crate::outcome::diagnose::Diagnosis;
use crate::outcome::fit::Fit;
use crate::report::explore::Exploration;
use crate::report::series::Series;

/// A part of the page with a heading of its own.
pub(super) struct Section {
    /// Anchor in the page.
    pub id: &'static str,
    pub title: &'static str,
    /// HTML.
    pub body: String,
}

impl Section {
    fn new(id: &'static str, title: &'static str, body: String) -> Self {
        Self { id, title, body }
    }
}

/// What a section is made from.
struct Source<'a> {
    outcome: &'a Outcome,
    series: &'a Series,
    exploration: &'a Exploration,
}

impl<'a> Source<'a> {
    /// The part of `fit`, if that is the verb.
    fn fit(&self) -> Option<&'a Fit> {
        match &self.outcome.part {
            Part::Fit(fit) => Some(fit),
            _ => None,
        }
    }

    /// The part of `diagnose`, if that is the verb.
    fn diagnosis(&self) -> Option<&'a Diagnosis> {
        match &self.outcome.part {
            Part::Diagnose(diagnosis) => Some(diagnosis),
            _ => None,
        }
    }
}

/// Every section in the order of the page; each is absent where it has nothing to say.
const SECTIONS: [fn(&Source) -> Option<Section>; 28] = [
    summary::section,
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
    load::section,
    parameters::section,
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
