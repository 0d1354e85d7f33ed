//! Trials of the diagnosis: rates, detections over the size of the effect, and what was taken for what.

use crate::outcome::Part;
use crate::outcome::trials::{Calibration, Group, Power, Share, Trials, is_outside};
use crate::report::escape::escape;
use crate::report::facts::{self, CALIBRATION_HEADERS, GROUP_HEADERS};
use crate::report::number::{percent, significant};
use crate::report::plots::agreement::{Measured, agreement};
use crate::report::plots::curves::{Curve, curves};
use crate::report::plots::{INK, KIND, PREDICTED, RECORDED, RESIDUAL, figure, key};
use crate::report::section::{Section, Source};
use crate::report::series::Point;
use crate::report::table::{Cell, Table};
use plotters::style::RGBColor;
use std::collections::BTreeMap;

/// Colours of the kinds of motion, in the order of the table.
const KINDS: [RGBColor; 5] = [PREDICTED, RECORDED, INK, RESIDUAL, KIND];

pub(super) fn section(source: &Source) -> Option<Section> {
    let Part::Trials(trials) = &source.outcome.part else {
        return None;
    };
    let mut body = rates(trials);
    body.push_str(&picture(trials));
    for (title, groups) in [
        ("By kind of motion", &trials.by_motion),
        ("By kind of noise", &trials.by_noise),
    ] {
        if !groups.is_empty() {
            body.push_str(&format!("<h3>{title}</h3>\n{}", by_kind(groups)));
        }
    }
    if !trials.calibration.is_empty() {
        body.push_str("<h3>Stated probabilities</h3>\n");
        body.push_str(&calibration(&trials.calibration));
    }
    body.push_str("<h3>Found first, by what was concealed</h3>\n");
    body.push_str(&confusion(&trials.confusion));
    body.push_str(&details_of(&trials.by_motion));
    body.push_str("<h3>Right, by effect and size over noise</h3>\n");
    body.push_str(&by_effect(&trials.power));
    Some(Section::new("trials", "Trials", body))
}

fn rates(trials: &Trials) -> String {
    let mut table = Table::new(&["", "Are", "Of", "Share"]);
    for (what, share) in facts::trial_rates(trials) {
        table.row(vec![
            Cell::text(what),
            Cell::Number(share.are.to_string()),
            Cell::Number(share.of.to_string()),
            Cell::Number(if share.of > 0 {
                percent(share.value())
            } else {
                String::new()
            }),
        ]);
    }
    let figures = [
        (
            "held-out error after over before, median",
            trials.rates.median_error_ratio,
        ),
        (
            "error of friction over that of the informed fit, median",
            trials.rates.median_friction_ratio,
        ),
        (
            "error of the bodies' torque over that of the informed fit, median",
            trials.rates.median_body_ratio,
        ),
        (
            "error of formulas in a larger motion over that of the smooth correction, median",
            trials
                .rates
                .outside
                .as_ref()
                .and_then(|outside| outside.median_forecast_ratio),
        ),
        ("processor seconds a trial", trials.rates.core_seconds),
    ];
    for (what, value) in figures {
        if let Some(value) = value {
            let figure = Cell::Number(significant(value));
            table.row(vec![
                Cell::text(what),
                Cell::text(""),
                Cell::text(""),
                figure,
            ]);
        }
    }
    table.html()
}

/// Shares of all effects together over the lower ends of the ranges of size.
fn over_size(power: &[Power]) -> Vec<(f64, Share)> {
    let mut sizes: Vec<f64> = power.iter().map(|p| p.effect_over_noise).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.dedup();
    let of = |size: f64| {
        let own = power.iter().filter(|p| p.effect_over_noise == size);
        let sum = own.fold(Share::default(), |s, p| Share {
            of: s.of + p.trials,
            are: s.are + p.right,
        });
        (size, sum)
    };
    sizes.into_iter().map(of).collect()
}

/// Shares over sizes as points of a plot: sizes below 0.1 stand there.
fn points(power: &[Power]) -> Vec<Point> {
    let all = over_size(power).into_iter();
    all.map(|(size, share)| (size.max(0.1).log10(), share.value()))
        .collect()
}

fn picture(trials: &Trials) -> String {
    let all = points(&trials.power);
    if all.len() < 2 {
        return String::new();
    }
    let plot = |lines: &[Curve]| {
        curves(
            lines,
            &[0.0, 0.95, 1.0],
            "log10 of the effect over the noise (lower end of the range)",
            "Share of trials with one effect that are right, over the size of the effect",
        )
    };
    let caption =
        "<b>Share of trials that are right</b>, one effect; the line in between is at 95 %";
    let mut figures = figure(caption, &plot(&[Curve::new(all, PREDICTED)]));
    if trials.by_motion.len() > 1 {
        let kinds = || trials.by_motion.iter().zip(KINDS.into_iter().cycle());
        let lines: Vec<Curve> = kinds()
            .map(|(group, colour)| Curve::new(points(&group.power), colour))
            .collect();
        let keys: String = kinds()
            .map(|(group, colour)| key(colour, &escape(&group.kind)))
            .collect();
        let caption = format!("<b>The same by kind of motion</b>: {keys}");
        figures.push_str(&figure(&caption, &plot(&lines)));
    }
    format!("<div class=\"plots\">{figures}</div>\n")
}

fn by_kind(groups: &[Group]) -> String {
    let mut table = Table::new(&GROUP_HEADERS);
    for group in groups {
        let cells = facts::group_row(group).into_iter().enumerate();
        table.row(
            cells
                .map(|(k, text)| {
                    if k == 1 || k == 2 {
                        Cell::Number(text)
                    } else {
                        Cell::text(text)
                    }
                })
                .collect(),
        );
    }
    table.html()
}

fn calibration(rows: &[Calibration]) -> String {
    let plot = |kind: Option<&String>| {
        let own = rows.iter().filter(|row| row.motion.as_ref() == kind);
        let points: Vec<Measured> = own
            .map(|row| Measured {
                stated: row.stated,
                right: row.right as f64 / row.claims as f64,
                interval: row.ci95,
            })
            .collect();
        let name = kind.map_or("all trials", String::as_str);
        let label = format!("Share of claims that are right over the stated probability: {name}");
        let caption = format!(
            "<b>Share that is right</b> with its 95 % interval: {}",
            escape(name)
        );
        figure(&caption, &agreement(&points, "stated probability", &label))
    };
    let mut kinds: Vec<Option<&String>> = rows.iter().map(|row| row.motion.as_ref()).collect();
    kinds.dedup();
    let figures: String = kinds.into_iter().map(plot).collect();
    let mut table = Table::new(&CALIBRATION_HEADERS);
    let mut before = None;
    for row in rows {
        if before.is_some_and(|motion| motion != &row.motion) {
            table.begin_group();
        }
        before = Some(&row.motion);
        let cells = facts::calibration_row(row).into_iter().enumerate();
        table.row(
            cells
                .map(|(k, text)| {
                    if k == 2 {
                        Cell::Number(text)
                    } else {
                        Cell::text(text)
                    }
                })
                .collect(),
        );
    }
    format!(
        "<div class=\"plots small\">{figures}</div>\n{}",
        table.html()
    )
}

/// What was taken for what, of each kind of motion.
fn details_of(groups: &[Group]) -> String {
    let folded = |group: &Group| {
        format!(
            "<details><summary>{}</summary>\n{}{}</details>\n",
            escape(&group.kind),
            confusion(&group.confusion),
            by_effect(&group.power)
        )
    };
    groups.iter().map(folded).collect()
}

fn confusion(found_first: &BTreeMap<String, BTreeMap<String, usize>>) -> String {
    let mut table = Table::new(&["Concealed", "Trials", "Right name", "Others found first"]);
    for (concealed, found) in found_first {
        let all: usize = found.values().sum();
        // What lies outside the vocabulary has no name to be found.
        let is_right = |name: &str| name == concealed || is_outside(concealed) && name == "unnamed";
        let right: usize = found
            .iter()
            .filter(|(name, _)| is_right(name))
            .map(|(_, n)| n)
            .sum();
        let others = found.iter().filter(|(name, _)| !is_right(name));
        let others: Vec<String> = others.map(|(name, n)| format!("{name} {n}")).collect();
        table.row(vec![
            Cell::name(concealed),
            Cell::Number(all.to_string()),
            Cell::Number(right.to_string()),
            Cell::text(others.join(", ")),
        ]);
    }
    table.html()
}

fn by_effect(power: &[Power]) -> String {
    let sizes: Vec<f64> = over_size(power).into_iter().map(|(size, _)| size).collect();
    let titles: Vec<String> = sizes.iter().map(|s| format!("from {s}")).collect();
    let mut headers = vec!["Effect"];
    headers.extend(titles.iter().map(String::as_str));
    let mut table = Table::new(&headers);
    let mut effects: Vec<&str> = power.iter().map(|p| p.effect.as_str()).collect();
    effects.dedup();
    for effect in effects {
        let cell = |size: &f64| {
            let own = power
                .iter()
                .find(|p| p.effect == effect && p.effect_over_noise == *size);
            let text = own.map_or(String::new(), |p| format!("{}/{}", p.right, p.trials));
            Cell::text(text)
        };
        let mut row = vec![Cell::name(effect)];
        row.extend(sizes.iter().map(cell));
        table.row(row);
    }
    table.html()
}
