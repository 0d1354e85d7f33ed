//! Whatever else a reader should know.

use crate::outcome::Part;
use crate::report::escape::prose;
use crate::report::section::{Section, Source};

pub(super) fn section(source: &Source) -> Option<Section> {
    let notes = match &source.outcome.part {
        Part::Fit(fit) => &fit.notes,
        Part::Simulate(simulation) => &simulation.notes,
        Part::Design(design) => &design.notes,
        Part::Diagnose(diagnosis) => &diagnosis.notes,
        Part::Trials(trials) => &trials.notes,
        Part::Rollout(rollout) => &rollout.notes,
        Part::Fleet(fleet) => &fleet.notes,
        Part::Check(_) => return None,
    };
    if notes.is_empty() {
        return None;
    }
    let items: String = notes
        .iter()
        .map(|note| format!("<li>{}</li>\n", prose(note)))
        .collect();
    Some(Section::new(
        "notes",
        "Notes",
        format!("<ul>\n{items}</ul>\n"),
    ))
}
