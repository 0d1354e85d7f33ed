//! What was found, in a sentence or two, and the figures that a reader looks for first.

use crate::outcome::diagnose::{Diagnosis, Verdict};
use crate::outcome::finding::UNNAMED;
use crate::outcome::fit::Fit;
use crate::outcome::joint::JointFigures;
use crate::outcome::{Outcome, Part};
use crate::report::escape::{escape, prose};
use crate::report::facts::{self, count};
use crate::report::number;
use crate::report::section::{Section, Source, main_result};

pub(super) fn section(source: &Source) -> Option<Section> {
    let outcome = source.outcome;
    let mut body = alert(outcome);
    let sentence = sentence(outcome);
    body.push_str(&format!(
        "<p class=\"lead\">{}{}</p>\n",
        verdict(outcome),
        prose(&sentence)
    ));
    body.push_str(&match &outcome.part {
        Part::Fit(fit) => {
            main_result::html(&outcome.estimate.parameters, fit)
                + &figures(&fit_figures(outcome, fit))
        }
        Part::Diagnose(diagnosis) => figures(&diagnosis_figures(outcome, diagnosis)),
        _ => String::new(),
    });
    body.push_str(&cut_off(outcome));
    Some(Section::new("summary", "Summary", body))
}

/// How the search for a motion ended that came to one within its limits and might have come to a better one.
fn cut_off(outcome: &Outcome) -> String {
    match (&outcome.estimate.solver, &outcome.part) {
        (Some(solver), Part::Design(_)) if facts::is_cut_off(solver) => {
            let sentence = escape(&facts::design_sentence(solver));
            format!("<p class=\"hint\">{sentence}.</p>\n")
        }
        _ => String::new(),
    }
}

/// A warning where the solver did not end well: the figures are then not the answer, but for a motion within its limits, which
/// can be used.
fn alert(outcome: &Outcome) -> String {
    match (&outcome.estimate.solver, &outcome.part) {
        (Some(solver), Part::Design(_)) if facts::is_cut_off(solver) => String::new(),
        (Some(solver), _) if !solver.converged => format!(
            "<p class=\"alert\">{}. The values below are what it had reached.</p>\n",
            escape(&facts::solver_sentence(solver))
        ),
        _ => String::new(),
    }
}

fn sentence(outcome: &Outcome) -> String {
    match &outcome.part {
        Part::Fit(_) => fit_sentence(outcome),
        Part::Check(check) => {
            let counts = facts::finding_counts(&check.findings);
            format!("The inputs were read and nothing was run: {counts}.")
        }
        Part::Simulate(simulation) => {
            let files = count(simulation.files.len(), "file");
            format!("The model was simulated and {files} written.")
        }
        Part::Design(design) => format!(
            "A motion within the limits was sought from {}; the best has a {} of {}.",
            count(design.starts as usize, "start"),
            design.criterion_meaning,
            number::significant(design.criterion_value)
        ),
        Part::Diagnose(diagnosis) => diagnosis_sentence(diagnosis),
        Part::Trials(trials) => facts::trials_sentence(trials),
        Part::Rollout(rollout) => rollout.summary.clone(),
        Part::Fleet(fleet) => fleet.summary.clone(),
    }
}

fn fit_sentence(outcome: &Outcome) -> String {
    let estimate = &outcome.estimate;
    let held_out = facts::range(&estimate.joints, |joint| joint.relative_validation);
    let trained = facts::range(&estimate.joints, |joint| Some(joint.relative_train));
    let (range, recordings) = match (held_out, trained) {
        (Some(range), _) => (range, "held-out recordings"),
        (None, Some(range)) => (range, "training recordings (none was held out)"),
        (None, None) => return format!("{}.", facts::parameter_counts(&estimate.parameters)),
    };
    let channels = match estimate.joints.len() {
        1 => "the joint".to_string(),
        number => format!("the {number} joints"),
    };
    let mut text = format!(
        "On the {recordings} the model leaves {} of the signal of {channels} unexplained",
        facts::in_words(range, number::percent)
    );
    if let Some((low, high)) = facts::range(&estimate.joints, |joint| joint.lack_of_fit) {
        // The square root of a ratio of mean squares: a ratio of root mean squares.
        let ratio = facts::in_words((low.sqrt(), high.sqrt()), number::significant);
        text.push_str(&format!(", which is {ratio} times the noise"));
    }
    format!(
        "{text}. Parameters: {}.",
        facts::parameter_counts(&estimate.parameters)
    )
}

/// A verdict as a mark before the sentence; empty where there is none.
fn verdict(outcome: &Outcome) -> String {
    let Part::Diagnose(diagnosis) = &outcome.part else {
        return String::new();
    };
    let class = match diagnosis.verdict {
        Some(Verdict::NothingMissing | Verdict::Explained) => "good",
        Some(Verdict::PartlyExplained) | None => "fair",
        Some(Verdict::Unexplained) => "bad",
    };
    let words = Verdict::or_none(diagnosis.verdict);
    format!("<span class=\"badge {class}\">{}</span> ", escape(words))
}

/// What was found, in brief: the cards below have the sentences.
fn diagnosis_sentence(diagnosis: &Diagnosis) -> String {
    let found: Vec<String> = diagnosis
        .findings
        .iter()
        .map(|f| format!("{} on {}", in_words(&f.effect), f.joints.join(", ")))
        .collect();
    match found.len() {
        0 => diagnosis.summary.clone(),
        1 => format!("The declared model lacks {}.", found[0]),
        number => format!(
            "The declared model lacks {}: {}.",
            count(number, "effect"),
            found.join("; ")
        ),
    }
}

fn in_words(effect: &str) -> String {
    match effect {
        UNNAMED => "something without a name".to_string(),
        effect => effect.replace('_', " "),
    }
}

/// The joint that is furthest from its noise, before and after.
fn diagnosis_figures(outcome: &Outcome, diagnosis: &Diagnosis) -> Vec<(&'static str, String)> {
    let worst = |joints: &[JointFigures]| {
        let judged = joints
            .iter()
            .filter_map(|j| Some((j.lack_of_fit?, &j.joint)));
        let worst = judged.max_by(|a, b| a.0.total_cmp(&b.0));
        worst.map_or_else(
            || number::ABSENT.to_string(),
            |(lack, joint)| format!("{} ({joint})", number::significant(lack)),
        )
    };
    vec![
        ("Findings", diagnosis.findings.len().to_string()),
        (
            "Worst lack of fit, declared",
            worst(&diagnosis.baseline.joints),
        ),
        ("Worst lack of fit, final", worst(&diagnosis.outcome.joints)),
        ("Hypotheses fitted", diagnosis.evidence.len().to_string()),
        (
            "Wall time",
            format!("{} s", number::significant(outcome.run.wall_s)),
        ),
    ]
}

fn fit_figures(outcome: &Outcome, fit: &Fit) -> Vec<(&'static str, String)> {
    let parameters = &outcome.estimate.parameters;
    let mut figures = vec![
        ("Parameters", parameters.len().to_string()),
        ("Independent combinations (rank)", facts::rank_in_words(fit)),
        (
            "Condition number",
            number::significant(fit.condition_number),
        ),
    ];
    if let Some(feasible) = fit.feasible {
        let answer = if feasible { "yes" } else { "no" };
        figures.push(("Physically feasible", answer.to_string()));
    }
    if let Some(value) = fit.min_pseudo_inertia_eigenvalue {
        figures.push((
            "Least pseudo-inertia eigenvalue",
            number::significant(value),
        ));
    }
    if let Some(solver) = &outcome.estimate.solver {
        let ended = if solver.converged {
            "converged"
        } else {
            "not converged"
        };
        figures.push(("Solver", ended.to_string()));
    }
    figures.push((
        "Wall time",
        format!("{} s", number::significant(outcome.run.wall_s)),
    ));
    figures
}

/// Figures that stand out.
fn figures(figures: &[(&str, String)]) -> String {
    let items: String = figures
        .iter()
        .map(|(term, value)| format!("<div><dt>{term}</dt><dd>{}</dd></div>\n", escape(value)))
        .collect();
    format!("<dl class=\"figures\">\n{items}</dl>\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_name_is_no_effect_of_that_name() {
        assert_eq!(in_words(UNNAMED), "something without a name");
        assert_eq!(in_words("torque_offset"), "torque offset");
    }
}
