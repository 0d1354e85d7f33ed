//! What is missing in the declared model: findings with their rivals, and the errors before and after.

use crate::outcome::diagnose::{Diagnosis, Finding, Rival};
use crate::report::html::escape;
use crate::report::number::{optional, percent, significant};
use crate::report::plots::rows::{Bars, bars};
use crate::report::plots::{PREDICTED, RECORDED, figure, key};
use crate::report::section::{Section, Source};
use crate::report::table::{Cell, Table};

/// Less than so many times the length is not worth saying.
const NOT_BY_LENGTH: f64 = 2.0;

/// From so many times the length on, two models are the same for any recording that is ever made.
const SAME: f64 = 1e4;

pub(super) fn missing(source: &Source) -> Option<Section> {
    let diagnosis = source.diagnosis()?;
    if diagnosis.findings.is_empty() {
        return None;
    }
    let mut body = String::new();
    for finding in &diagnosis.findings {
        body.push_str(&one(finding));
    }
    body.push_str(&spoiled(diagnosis));
    if let Some(next) = &diagnosis.next_experiment {
        body.push_str(&format!(
            "<h3>What to record next</h3>\n<p>{}</p>\n<details><summary>next_experiment.toml</summary>\n\
             <pre>{}</pre></details>\n",
            escape(&next.sentence),
            escape(&next.problem)
        ));
    }
    Some(Section::new("missing", "What is missing", body))
}

fn one(finding: &Finding) -> String {
    let mut html = format!(
        "<h3>{}</h3>\n<p>{}</p>\n<p>It explains {} of the misfit there; a finding as strong as this \
         by chance: p = {}. That it is what is there: {}; something without a name: {}; nothing: {}.</p>\n",
        escape(&finding.effect),
        escape(&finding.sentence),
        percent(finding.explained_share),
        significant(finding.p_value),
        percent(finding.probability),
        percent(finding.probability_unnamed),
        percent(finding.probability_nothing)
    );
    if !finding.parameters.is_empty() {
        let mut table = Table::new(&["Parameter", "Value", "Unit", "95 % from", "to"]);
        for parameter in &finding.parameters {
            table.row(vec![
                Cell::name(&parameter.name),
                Cell::Number(optional(parameter.value)),
                Cell::text(&parameter.unit),
                Cell::Number(optional(parameter.ci95.map(|ends| ends[0]))),
                Cell::Number(optional(parameter.ci95.map(|ends| ends[1]))),
            ]);
        }
        html.push_str(&table.html());
    }
    if !finding.rivals.is_empty() {
        let headers = [
            "Rival",
            "Joints",
            "Explains",
            "Probability",
            "These recordings",
        ];
        let mut table = Table::new(&headers);
        for rival in &finding.rivals {
            table.row(vec![
                Cell::text(&rival.effect),
                Cell::text(rival.joints.join(", ")),
                Cell::Number(percent(rival.explained_share)),
                Cell::Number(percent(rival.probability)),
                Cell::text(told_apart(rival)),
            ]);
        }
        html.push_str(&table.html());
    }
    html
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
fn spoiled(diagnosis: &Diagnosis) -> String {
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
    let hint = "<p class=\"hint\">How far either model strays from the robot when it is simulated forward: <code>exid \
                rollout</code> with this results folder.</p>";
    let body = format!(
        "<div class=\"plots\">{plot}</div>\n{}{hint}\n",
        table.html()
    );
    Some(Section::new("before-and-after", "Before and after", body))
}
