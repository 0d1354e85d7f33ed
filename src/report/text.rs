//! The summary on a terminal: the few lines that matter, in aligned columns.

use std::path::Path;

use crate::outcome::check::Check;
use crate::outcome::estimate::Estimate;
use crate::outcome::fit::Fit;
use crate::outcome::joint::JointFigures;
use crate::outcome::simulation::Simulation;
use crate::outcome::{Outcome, Part};
use crate::report::facts;
use crate::report::number::{optional, percent, significant};

/// Space between two columns.
const GAP: &str = "  ";

/// The summary of an outcome whose report is at `report`; ends with a newline.
pub fn summary(outcome: &Outcome, report: Option<&Path>) -> String {
    let mut lines = match &outcome.part {
        Part::Fit(fit) => fit_lines(&outcome.estimate, fit),
        Part::Check(check) => check_lines(check),
        Part::Simulate(simulation) => simulation_lines(simulation),
    };
    lines.insert(0, format!("{}: {}", outcome.name, outcome.part.verb()));
    if let Some(report) = report {
        lines.push(format!("report: {}", report.display()));
    }
    lines.join("\n") + "\n"
}

fn fit_lines(estimate: &Estimate, fit: &Fit) -> Vec<String> {
    let mut lines = joint_lines(&estimate.joints);
    let feasible = match fit.feasible {
        Some(true) => ", physically feasible",
        Some(false) => ", not physically feasible",
        None => "",
    };
    lines.push(format!(
        "rank {}, condition number {}{feasible}",
        fit.rank,
        significant(fit.condition_number)
    ));
    lines.push(format!(
        "parameters: {}",
        facts::parameter_counts(&estimate.parameters)
    ));
    lines.extend(estimate.solver.as_ref().map(facts::solver_sentence));
    lines.extend(fit.notes.iter().map(|note| format!("note: {note}")));
    lines
}

fn joint_lines(joints: &[JointFigures]) -> Vec<String> {
    let headers = [
        "joint",
        "unit",
        "RMSE train",
        "held out",
        "noise",
        "relative train",
        "held out",
    ];
    let mut rows = vec![headers.map(str::to_string)];
    rows.extend(joints.iter().map(|joint| {
        [
            joint.joint.clone(),
            joint.unit.clone(),
            significant(joint.rmse_train),
            optional(joint.rmse_validation),
            optional(joint.noise_rms),
            percent(joint.relative_train),
            percent(joint.relative_validation.unwrap_or(f64::NAN)),
        ]
    }));
    align(&rows)
}

/// Rows of equal columns: the first two to the left, numbers to the right.
fn align<const N: usize>(rows: &[[String; N]]) -> Vec<String> {
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max();
    let widths: Vec<usize> = (0..N).map(|column| width(column).unwrap_or(0)).collect();
    rows.iter()
        .map(|row| {
            let cells: Vec<String> = row
                .iter()
                .zip(&widths)
                .enumerate()
                .map(|(column, (cell, &width))| match column {
                    0 | 1 => format!("{cell:<width$}"),
                    _ => format!("{cell:>width$}"),
                })
                .collect();
            format!("{GAP}{}", cells.join(GAP).trim_end())
        })
        .collect()
}

fn check_lines(check: &Check) -> Vec<String> {
    let mut lines = Vec::new();
    for finding in &check.findings {
        let place = facts::finding_place(finding);
        let place = if place.is_empty() {
            place
        } else {
            format!("{place}: ")
        };
        let severity = finding.severity.as_str();
        lines.push(format!(
            "{severity}: {place}{} [{}]",
            finding.message, finding.code
        ));
        lines.push(format!("{GAP}{}", finding.remedy));
    }
    lines.push(facts::finding_counts(&check.findings));
    lines
}

fn simulation_lines(simulation: &Simulation) -> Vec<String> {
    let mut lines: Vec<String> = simulation
        .files
        .iter()
        .map(|file| format!("{GAP}{file}"))
        .collect();
    lines.extend(simulation.realised_noise.iter().map(|noise| {
        let std_dev = significant(noise.std_dev);
        format!("noise of {}: {std_dev} {}", noise.channel, noise.unit)
    }));
    lines.extend(simulation.notes.iter().map(|note| format!("note: {note}")));
    lines
}
