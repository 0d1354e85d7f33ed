//! Trials of the diagnosis: rates, detections over the size of the effect, and what was taken for what.

use crate::outcome::Part;
use crate::outcome::trials::{Power, Share, Trials, is_outside};
use crate::report::facts;
use crate::report::number::{percent, significant};
use crate::report::plots::curves::{Curve, curves};
use crate::report::plots::{PREDICTED, figure};
use crate::report::section::{Section, Source};
use crate::report::table::{Cell, Table};

pub(super) fn section(source: &Source) -> Option<Section> {
    let Part::Trials(trials) = &source.outcome.part else {
        return None;
    };
    let mut body = rates(trials);
    body.push_str(&picture(&trials.power));
    body.push_str("<h3>Found first, by what was concealed</h3>\n");
    body.push_str(&confusion(trials));
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

fn picture(power: &[Power]) -> String {
    let points = over_size(power);
    if points.len() < 2 {
        return String::new();
    }
    let at = points
        .iter()
        .map(|(size, share)| (size.max(0.1).log10(), share.value()));
    let curve = Curve::new(at.collect(), PREDICTED);
    let plot = curves(
        &[curve],
        &[0.0, 0.95, 1.0],
        "log10 of the effect over the noise (lower end of the range)",
        "Share of trials with one effect that are right, over the size of the effect",
    );
    let caption =
        "<b>Share of trials that are right</b>, one effect; the line in between is at 95 %";
    format!("<div class=\"plots\">{}</div>\n", figure(caption, &plot))
}

fn confusion(trials: &Trials) -> String {
    let mut table = Table::new(&["Concealed", "Trials", "Right name", "Others found first"]);
    for (concealed, found) in &trials.confusion {
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
