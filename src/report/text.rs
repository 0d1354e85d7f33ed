//! The summary on a terminal: the few lines that matter, in aligned columns.

use std::path::Path;

use crate::outcome::check::{Check, Mistake, Severity};
use crate::outcome::design::Design;
use crate::outcome::diagnose::{Diagnosis, Verdict};
use crate::outcome::estimate::{Estimate, Solver};
use crate::outcome::finding::{Finding, UNNAMED};
use crate::outcome::fit::Fit;
use crate::outcome::formula::ProposedFormula;
use crate::outcome::joint::JointFigures;
use crate::outcome::load::Load;
use crate::outcome::model_comparison::ModelComparison;
use crate::outcome::parameter::Parameter;
use crate::outcome::simulation::Simulation;
use crate::outcome::trials::Trials;
use crate::outcome::{FORMULAS_FILE, Outcome, Part};
use crate::report::number::{optional, percent, significant};
use crate::report::terminal::{GAP, align};
use crate::report::terminal_parameters::{self, LOAD};
use crate::report::{facts, terminal_fleet, terminal_rollout, terminal_simulator};

/// Lines of a fit or a diagnosis, about a screen: base parameters and places of the misfit give way to the rest.
const LINES: usize = 40;

/// The summary of an outcome whose report is at `report`; ends with a newline.
pub fn summary(outcome: &Outcome, report: Option<&Path>) -> String {
    let mut head = vec![format!("{}: {}", outcome.name, outcome.part.verb())];
    head.extend(mistake_lines(&outcome.mistakes));
    let room = LINES.saturating_sub(head.len() + usize::from(report.is_some()));
    let mut lines = match &outcome.part {
        Part::Fit(fit) => fit_lines(&outcome.estimate, fit, room),
        Part::Check(check) => check_lines(check),
        Part::Simulate(simulation) => simulation_lines(simulation),
        Part::Design(design) => design_lines(&outcome.estimate, design),
        Part::Diagnose(diagnosis) => diagnosis_lines(diagnosis, room),
        Part::Trials(trials) => trial_lines(trials),
        Part::Rollout(rollout) => terminal_rollout::lines(rollout),
        Part::Fleet(fleet) => terminal_fleet::lines(fleet),
    };
    lines.splice(0..0, head);
    if let Some(report) = report {
        lines.push(format!("report: {}", report.display()));
    }
    lines.join("\n") + "\n"
}

/// How a solver ended.
pub fn solver_sentence(solver: &Solver) -> String {
    facts::solver_sentence(solver)
}

/// What the inputs say wrongly, without notes: those are in the report.
fn mistake_lines(mistakes: &[Mistake]) -> Vec<String> {
    let weighty = mistakes.iter().filter(|m| m.severity < Severity::Note);
    weighty.flat_map(finding_lines).collect()
}

/// What is wrong with an input, and what to do about it.
pub fn finding_lines(finding: &Mistake) -> [String; 2] {
    let place = facts::finding_place(finding);
    let place = if place.is_empty() {
        place
    } else {
        format!("{place}: ")
    };
    let severity = finding.severity.as_str();
    [
        format!("{severity}: {place}{} [{}]", finding.message, finding.code),
        format!("{GAP}{}", finding.remedy),
    ]
}

fn fit_lines(estimate: &Estimate, fit: &Fit, room: usize) -> Vec<String> {
    let mut lines = joint_lines(&estimate.joints);
    let feasible = match fit.feasible {
        Some(true) => ", physically feasible",
        Some(false) => ", not physically feasible",
        None => "",
    };
    lines.push(format!(
        "rank {}, condition number {}{feasible}",
        facts::rank_in_words(fit),
        significant(fit.condition_number)
    ));
    lines.push(format!(
        "parameters: {}",
        facts::parameter_counts(&estimate.parameters)
    ));
    let mut rest = Vec::new();
    if let Some(load) = &fit.payload {
        rest.extend(load_lines(estimate, load));
    }
    rest.extend(estimate.solver.as_ref().map(facts::solver_sentence));
    rest.extend(comparison_lines(&fit.contests));
    rest.extend(fit.simulator.iter().flat_map(terminal_simulator::lines));
    rest.extend(fit.sharing.iter().map(|sharing| sharing.sentence.clone()));
    rest.extend(fit.notes.iter().map(|note| format!("note: {note}")));
    let room = room.saturating_sub(lines.len() + rest.len());
    let parameters = terminal_parameters::lines(&estimate.parameters, room);
    let room = room.saturating_sub(parameters.len());
    lines.extend(parameters);
    let base = terminal_parameters::base(&estimate.parameters, &fit.base_parameters, room);
    lines.into_iter().chain(base).chain(rest).collect()
}

/// The load as controllers ask for it, with its intervals.
fn load_lines(estimate: &Estimate, load: &Load) -> Vec<String> {
    let own = estimate.parameters.iter();
    let own: Vec<&Parameter> = own.filter(|p| p.name.starts_with(LOAD)).collect();
    let apart = own.iter().any(|p| p.std_dev_statistical.is_some());
    let mut headers = vec!["load", "unit", "value", "std. dev.", "95 % from", "to"];
    headers.extend(apart.then_some("of noise"));
    let mut rows: Vec<Vec<String>> = vec![headers.into_iter().map(str::to_string).collect()];
    let ends = |ci95: Option<[f64; 2]>| [0, 1].map(|k| optional(ci95.map(|ci| ci[k])));
    for p in own {
        let name = p.name.trim_start_matches(LOAD).to_string();
        let [lower, upper] = ends(p.ci95);
        let (value, std_dev) = (optional(p.value), optional(p.std_dev));
        let mut row = vec![name, p.unit.clone(), value, std_dev, lower, upper];
        row.extend(apart.then(|| optional(p.std_dev_statistical)));
        rows.push(row);
    }
    for (k, moment) in load.principal.iter().enumerate() {
        let name = format!("principal {}", k + 1);
        let [lower, upper] = ends(moment.ci95);
        let (value, std_dev) = (significant(moment.value), optional(moment.std_dev));
        let unit = "kg·m²".to_string();
        rows.push(vec![name, unit, value, std_dev, lower, upper]);
    }
    let mut lines = align(&rows, 2);
    if load.possible == Some(false) {
        lines.push("no body has these ten values; `estimator = \"feasible_maximum_likelihood\"` keeps to those that have".into());
    }
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
    align(&rows, 2)
}

/// Root mean square errors of the models that are compared, and which is best.
fn comparison_lines(comparisons: &[ModelComparison]) -> Vec<String> {
    let mut lines = Vec::new();
    for comparison in comparisons {
        let joint = comparison.joint.as_deref().unwrap_or("all joints together");
        let errors: Vec<String> = comparison
            .models
            .iter()
            .map(|model| format!("{} {}", model.name, significant(model.judged().value)))
            .collect();
        let unit = match comparison.unit.as_str() {
            "" => "of this fit's error".to_string(),
            unit => unit.to_string(),
        };
        lines.push(format!(
            "comparison, {joint}: {} {unit}; {}",
            errors.join(", "),
            comparison.sentence
        ));
    }
    lines
}

fn diagnosis_lines(diagnosis: &Diagnosis, room: usize) -> Vec<String> {
    let mut lines = vec![format!("verdict: {}", Verdict::or_none(diagnosis.verdict))];
    if diagnosis.findings.is_empty() {
        lines.push(diagnosis.summary.clone());
    }
    for (k, finding) in diagnosis.findings.iter().enumerate() {
        let probability = percent(finding.probability);
        let of_what = match finding.effect.as_str() {
            UNNAMED => "probable that the vocabulary lacks it",
            _ => "probable",
        };
        lines.push(format!(
            "{}. {} ({probability} {of_what})",
            k + 1,
            finding.sentence
        ));
        lines.extend(rival_line(finding));
        let formula = finding.formula.iter();
        lines.extend(formula.map(|formula| {
            let ProposedFormula { effect, joint, .. } = formula;
            format!("{GAP}{GAP}law: {effect}, for the effects of {joint} [{FORMULAS_FILE}]")
        }));
    }
    let mut rest = Vec::new();
    if !diagnosis.findings.is_empty() {
        let left = diagnosis.unattested.iter();
        rest.extend(left.map(|left| format!("{GAP}left: {}", left.sentence)));
    }
    let next = diagnosis.next_experiment.as_ref();
    rest.extend(next.map(|next| format!("next: {} [next_experiment.toml]", next.sentence)));
    rest.extend(before_and_after(diagnosis));
    let simulator = diagnosis.simulator.iter();
    rest.extend(simulator.flat_map(terminal_simulator::lines));
    let sharing = diagnosis.fit.iter().flat_map(|fit| &fit.sharing);
    rest.extend(sharing.map(|sharing| sharing.sentence.clone()));
    rest.extend(diagnosis.notes.iter().map(|note| format!("note: {note}")));
    let room = room.saturating_sub(lines.len() + rest.len());
    let located = diagnosis.located.iter().take(room);
    let located: Vec<String> = located
        .map(|place| format!("{GAP}where: {}", place.sentence))
        .collect();
    lines.into_iter().chain(located).chain(rest).collect()
}

fn trial_lines(trials: &Trials) -> Vec<String> {
    let mut lines = vec![facts::trials_sentence(trials)];
    let rates = facts::trial_rates(trials).into_iter();
    let rows = rates
        .filter(|(_, share)| share.of > 0)
        .map(|(what, share)| {
            [
                what.to_string(),
                share.are.to_string(),
                share.of.to_string(),
                percent(share.value()),
            ]
        });
    let mut table = vec![["", "are", "of", "share"].map(str::to_string)];
    table.extend(rows);
    lines.extend(align(&table, 2));
    for groups in [&trials.by_motion, &trials.by_noise] {
        let mut table = vec![facts::GROUP_HEADERS.map(str::to_string)];
        table.extend(groups.iter().map(facts::group_row));
        if !groups.is_empty() {
            lines.extend(align(&table, 2));
        }
    }
    let mut table = vec![facts::CALIBRATION_HEADERS.map(str::to_string)];
    table.extend(trials.calibration.iter().map(facts::calibration_row));
    if table.len() > 1 {
        lines.extend(align(&table, 2));
    }
    lines.extend(trials.notes.iter().map(|note| format!("note: {note}")));
    lines
}

fn rival_line(finding: &Finding) -> Option<String> {
    let alike = finding.rivals.iter().filter(|r| !r.separable);
    let names: Vec<&str> = alike.map(|r| r.effect.as_str()).collect();
    (!names.is_empty()).then(|| format!("{GAP}not told apart from: {}", names.join(", ")))
}

fn before_and_after(diagnosis: &Diagnosis) -> Vec<String> {
    let headers = [
        "joint",
        "unit",
        "held out before",
        "after",
        "noise",
        "lack of fit before",
        "after",
    ];
    let mut rows = vec![headers.map(str::to_string)];
    let pairs = diagnosis
        .baseline
        .joints
        .iter()
        .zip(&diagnosis.outcome.joints);
    rows.extend(pairs.map(|(before, after)| {
        [
            before.joint.clone(),
            before.unit.clone(),
            optional(before.rmse_validation),
            optional(after.rmse_validation),
            optional(after.noise_rms),
            optional(before.lack_of_fit),
            optional(after.lack_of_fit),
        ]
    }));
    align(&rows, 2)
}

fn check_lines(check: &Check) -> Vec<String> {
    let mut lines: Vec<String> = check.findings.iter().flat_map(finding_lines).collect();
    lines.push(facts::finding_counts(&check.findings));
    lines
}

fn design_lines(estimate: &Estimate, design: &Design) -> Vec<String> {
    let mut lines: Vec<String> = design
        .files
        .iter()
        .map(|file| format!("{GAP}{file}"))
        .collect();
    lines.push(format!(
        "{}: {} after {}; condition number {}, log det {}",
        design.criterion,
        significant(design.criterion_value),
        facts::count(design.starts as usize, "start"),
        significant(design.condition_number),
        significant(design.log_det)
    ));
    let tightest = design
        .worst_margins
        .iter()
        .min_by(|a, b| a.relative.total_cmp(&b.relative));
    lines.extend(tightest.map(|m| {
        let joint = m.joint.as_deref().unwrap_or("the workspace");
        format!(
            "tightest limit: {} of {joint}, {} left",
            m.constraint,
            percent(m.relative)
        )
    }));
    let hidden = design.coverage.iter().filter(|c| !c.shown);
    lines.extend(hidden.map(|c| {
        format!(
            "the motion shows little of {} on {}: {}",
            c.effect, c.joint, c.sentence
        )
    }));
    lines.extend(estimate.solver.as_ref().map(facts::design_sentence));
    lines.extend(design.notes.iter().map(|note| format!("note: {note}")));
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
