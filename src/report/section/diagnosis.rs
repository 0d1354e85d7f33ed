//! What is missing in the declared model: findings with their rivals, and the errors before and after.

use crate::outcome::diagnose::{Diagnosis, NextExperiment};
use crate::outcome::finding::{Finding, Rival, UNNAMED};
use crate::outcome::formula::ProposedFormula;
use crate::outcome::parameter::Parameter;
use crate::report::escape::{breakable, escape, prose};
use crate::report::facts::count;
use crate::report::number::{optional, percent, significant};
use crate::report::plots::rows::{Bars, bars};
use crate::report::plots::{PREDICTED, RECORDED, figure, key};
use crate::report::section::{Section, Source};
use crate::report::table::{Cell, Table};

/// A probability from which on a finding is called sure, and below which it is open: one wrong in twenty, and as likely wrong as right.
const SURE: f64 = 0.95;
const OPEN: f64 = 0.5;

/// Less than so many times the length is not worth saying.
const NOT_BY_LENGTH: f64 = 2.0;

/// From so many times the length on, two models are the same for any recording that is ever made.
const SAME: f64 = 1e4;

pub(super) fn missing(source: &Source) -> Option<Section> {
    let diagnosis = source.diagnosis()?;
    if diagnosis.findings.is_empty() {
        return None;
    }
    let cards = diagnosis.findings.iter().enumerate();
    let cards: String = cards
        .map(|(k, finding)| card(k + 1, finding, diagnosis))
        .collect();
    let mut body = format!("<div class=\"cards\">\n{cards}</div>\n");
    body.push_str(&biased(diagnosis));
    if let Some(next) = &diagnosis.next_experiment {
        body.push_str(&format!(
            "<h3>What to record next</h3>\n<p>{}</p>\n<details><summary>next_experiment.toml</summary>\n\
             <pre>{}</pre></details>\n",
            prose(&next.sentence),
            escape(&next.problem)
        ));
    }
    Some(Section::new("missing", "What is missing", body))
}

/// One finding: what and where, how sure, what it changes, its values, its rivals, and what to do.
fn card(number: usize, finding: &Finding, diagnosis: &Diagnosis) -> String {
    let joints = diagnosis.baseline.joints.iter();
    let units = joints.filter(|joint| finding.joints.contains(&joint.joint));
    let mut units: Vec<&str> = units.map(|joint| joint.unit.as_str()).collect();
    units.dedup();
    // Joints that turn and joints that slide have no common unit.
    let unit = match units[..] {
        [unit] => escape(unit),
        _ => String::new(),
    };
    let (before, after) = (
        finding.rmse_validation_before,
        finding.rmse_validation_after,
    );
    let [was, is] = [before, after].map(|value| 100.0 * value / before.max(after));
    let mut terms = vec![(
        "Error held out".to_string(),
        format!(
            "{} {unit} before<span class=\"meter was\"><span style=\"width:{was:.1}%\"></span></span>{} {unit} after\
             <span class=\"meter\"><span style=\"width:{is:.1}%\"></span></span>",
            significant(before),
            significant(after)
        ),
    )];
    terms.extend(finding.parameters.iter().map(value));
    terms.push((
        "Explains".to_string(),
        format!(
            "{} of the misfit there; as much by chance: p = {}",
            percent(finding.explained_share),
            significant(finding.p_value)
        ),
    ));
    terms.push(("Instead".to_string(), instead(finding)));
    terms.extend(finding.formula.iter().flat_map(formula));
    let terms: String = terms
        .iter()
        .map(|(term, text)| format!("<dt>{term}</dt><dd>{text}</dd>\n"))
        .collect();
    format!(
        "<article class=\"card\"><div class=\"head\"><h3>{number}. {} on {}</h3><span class=\"badge {}\">{} {}</span></div>\n\
         <p>{}</p>\n<dl>{terms}</dl>\n<p class=\"do\"><b>What to do:</b> {}</p></article>\n",
        escape(&finding.effect.replace('_', " ")),
        escape(&finding.joints.join(", ")),
        sureness(finding.probability),
        percent(finding.probability),
        of_what(finding),
        prose(&finding.sentence),
        to_do(finding, diagnosis.next_experiment.as_ref()),
    )
}

/// What the probability of a finding is one of.
fn of_what(finding: &Finding) -> &'static str {
    match finding.effect.as_str() {
        UNNAMED => "outside of the vocabulary",
        _ => "probable",
    }
}

/// Class of a probability: from [`SURE`] on green, below [`OPEN`] red.
fn sureness(probability: f64) -> &'static str {
    match probability {
        p if p >= SURE => "good",
        p if p >= OPEN => "fair",
        _ => "bad",
    }
}

/// A formula with its values, what other formulas explain, and the law for the problem file.
fn formula(formula: &ProposedFormula) -> Vec<(String, String)> {
    let against = match &formula.against {
        Some(rival) => format!(", not {}", escape(&rival.replace('_', " "))),
        None => String::new(),
    };
    let others = formula.others.iter().map(|other| {
        format!(
            "<br><code>{}</code> explains {} with {}",
            breakable(&other.expression),
            percent(other.explains),
            count(other.complexity, "parameter")
        )
    });
    let proposed = format!(
        "<code>{}</code> explains {} with {}; {} probable{against}{}\
         <details><summary>{}, a law for the problem file</summary><pre>{}</pre></details>",
        breakable(&formula.expression),
        percent(formula.explains),
        count(formula.complexity, "parameter"),
        percent(formula.probability),
        others.collect::<String>(),
        escape(&formula.effect),
        escape(&formula.law)
    );
    let proposed = ("Formula".to_string(), proposed);
    std::iter::once(proposed)
        .chain(formula.parameters.iter().map(value))
        .collect()
}

fn value(parameter: &Parameter) -> (String, String) {
    let interval = parameter.ci95.map_or(String::new(), |[low, high]| {
        format!(", 95 % from {} to {}", significant(low), significant(high))
    });
    let unit = match parameter.unit.as_str() {
        "1" => String::new(),
        unit => format!(" {}", escape(unit)),
    };
    let text = format!("{}{unit}{interval}", optional(parameter.value));
    (format!("<code>{}</code>", breakable(&parameter.name)), text)
}

/// What else it may be: rivals with their probabilities, something without a name, nothing.
fn instead(finding: &Finding) -> String {
    let rivals = finding.rivals.iter().map(|rival| {
        format!(
            "{} on {} ({}; these recordings {})<br>",
            escape(&rival.effect.replace('_', " ")),
            escape(&rival.joints.join(", ")),
            percent(rival.probability),
            told_apart(rival)
        )
    });
    let nothing = percent(finding.probability_nothing);
    if finding.effect == UNNAMED {
        let known = 1.0 - finding.probability - finding.probability_nothing;
        return format!(
            "physics of the vocabulary that was not recognised ({}); nothing ({nothing})",
            percent(known.max(0.0))
        );
    }
    format!(
        "{}something without a name ({}); nothing ({nothing})",
        rivals.collect::<String>(),
        percent(finding.probability_unnamed),
    )
}

/// The next step: a recording where rivals are open, else the line of the problem file.
fn to_do(finding: &Finding, next: Option<&NextExperiment>) -> String {
    let open = finding.rivals.iter().any(|rival| !rival.separable);
    match (open, next) {
        (true, Some(_)) => {
            "make the recording below, which tells it from its rivals, and diagnose again."
                .to_string()
        }
        (true, None) => {
            "treat it and its rivals alike: no recording of this kind tells them apart.".to_string()
        }
        (false, _) if finding.formula.is_some() => format!(
            "think about the formula; its law, put into the problem file and among the effects of {}, is fitted like any other.",
            escape(&finding.joints.join(", "))
        ),
        (false, _) if finding.has_no_name() => {
            "look at where it lies below; a law of your own can be tried with <code>[[law]]</code>."
                .to_string()
        }
        (false, _) => format!(
            "add <code>{}</code> to the effects of {} in the problem file and fit again.",
            breakable(&finding.effect),
            escape(&finding.joints.join(", "))
        ),
    }
}

/// Whether the recordings tell a rival apart, and longer ones would.
fn told_apart(rival: &Rival) -> String {
    let as_it_is = "cannot tell it apart";
    match rival.times_longer {
        _ if rival.separable => "tell it apart".to_string(),
        Some(times) if times < NOT_BY_LENGTH => as_it_is.to_string(),
        Some(times) if times < SAME => {
            format!(
                "{as_it_is}, nor could any of less than {} times the length",
                significant(times)
            )
        }
        _ => format!("{as_it_is}, nor could longer ones: it is the same torque"),
    }
}

/// What the missing physics had done to the other parameters.
fn biased(diagnosis: &Diagnosis) -> String {
    if diagnosis.spoiled.is_empty() {
        return String::new();
    }
    let mut table = Table::new(&[
        "Parameter",
        "Declared model",
        "With what was missing",
        "Std. dev.",
        "Unit",
    ]);
    for entry in &diagnosis.spoiled {
        table.row(vec![
            Cell::name(&entry.name),
            Cell::Number(significant(entry.before)),
            Cell::Number(significant(entry.after)),
            Cell::Number(significant(entry.std_dev)),
            Cell::text(&entry.unit),
        ]);
    }
    format!(
        "<h3>What it had done to the other parameters</h3>\n<p class=\"hint\">Parameters that move by \
         more than three standard deviations when the model has what it lacked.</p>\n{}",
        table.html()
    )
}

pub(super) fn before_and_after(source: &Source) -> Option<Section> {
    let diagnosis = source.diagnosis()?;
    let pairs = || {
        diagnosis
            .baseline
            .joints
            .iter()
            .zip(&diagnosis.outcome.joints)
    };
    let mut table = Table::new(&[
        "Joint",
        "Unit",
        "RMSE held out, declared",
        "final",
        "Noise",
        "Lack of fit, declared",
        "final",
    ]);
    for (before, after) in pairs() {
        table.row(vec![
            Cell::name(&before.joint),
            Cell::text(&before.unit),
            Cell::Number(optional(before.rmse_validation)),
            Cell::Number(optional(after.rmse_validation)),
            Cell::Number(optional(after.noise_rms)),
            Cell::Number(optional(before.lack_of_fit)),
            Cell::Number(optional(after.lack_of_fit)),
        ]);
    }
    let rows: Vec<Bars> = pairs()
        .filter_map(|(before, after)| {
            let scale = after
                .noise_rms
                .filter(|n| *n > 0.0)
                .or(after.rmse_validation)?;
            Some(Bars {
                label: before.joint.clone(),
                train: before.rmse_validation? / scale,
                validation: after.rmse_validation.map(|e| e / scale),
            })
        })
        .collect();
    let legend = format!(
        "{}{}",
        key(RECORDED, "declared model"),
        key(PREDICTED, "final model")
    );
    let caption = format!("<b>Held-out RMSE in multiples of the noise</b>{legend}");
    let plot = figure(&caption, &bars(&rows, Some(1.0), "RMSE / noise"));
    let hint = match source.diagnosis().is_some_and(|d| d.rollout.is_some()) {
        true => "",
        false => {
            "<p class=\"hint\">How far either model strays from the robot when it is simulated forward: <code>exid \
             rollout</code> with this results folder.</p>"
        }
    };
    let body = format!(
        "<div class=\"plots\">{plot}</div>\n{}{hint}\n",
        table.html()
    );
    Some(Section::new("before-and-after", "Before and after", body))
}
