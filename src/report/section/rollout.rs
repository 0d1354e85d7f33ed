//! Forward simulations beside recordings: errors by horizon, and two windows sample by sample.

use crate::outcome::Part;
use crate::outcome::rollout::{ErrorCurve, Example, Rollout, Spread};
use crate::report::escape::{escape, prose};
use crate::report::facts::count;
use crate::report::number::{optional, significant};
use crate::report::plots::curves::{Curve, curves};
use crate::report::plots::{PREDICTED, RECORDED, RESIDUAL, figure, key};
use crate::report::section::explorer::explorer;
use crate::report::section::{Section, Source};
use crate::report::series::Point;
use crate::report::table::{Cell, Table};
use crate::report::terminal_rollout::quartiles;
use plotters::style::RGBColor;

pub(super) fn section(source: &Source) -> Option<Section> {
    let rollout = match &source.outcome.part {
        Part::Rollout(rollout) => rollout.as_ref(),
        Part::Diagnose(diagnosis) => diagnosis.rollout.as_ref()?,
        _ => return None,
    };
    let mut body = about(rollout);
    body.push_str(&pictures(rollout));
    body.push_str(&table(rollout));
    body.push_str(&match &source.outcome.part {
        Part::Diagnose(_) => beside_a_diagnosis(rollout),
        _ => windows(source, rollout),
    });
    Some(Section::new("rollout", "Simulated forward", body))
}

fn windows(source: &Source, rollout: &Rollout) -> String {
    let windows = rollout.examples.iter();
    let still: String = windows.map(|example| window(rollout, example)).collect();
    format!(
        "<h3>Windows, sample by sample</h3>\n{}",
        explorer(source, None, &still)
    )
}

/// What a page of a rollout has in other places.
fn beside_a_diagnosis(rollout: &Rollout) -> String {
    let hint = |text: &str| format!("<p class=\"hint\">{text}</p>\n");
    let notes = rollout.notes.iter();
    let notes: String = notes.map(|note| hint(&prose(note))).collect();
    notes + &hint("Windows sample by sample: <code>exid rollout</code> with this results folder.")
}

fn about(rollout: &Rollout) -> String {
    let before = rollout.before.map_or(String::new(), |before| {
        format!(" Before: {}.", before.words())
    });
    let models = match rollout.source.as_str() {
        "" => prose(&rollout.summary) + " Models of this result",
        source => format!("Models of <code>{}</code>", escape(source)),
    };
    format!(
        "<p>{}, in {}.{} Noise alone: the final model under its own torques with the noise of the signal, \
         from starts with the errors of the estimated motion. Integrated by {} with steps of at most {} s; halving: what half of \
         the steps change in {}, RMS.</p>\n",
        models,
        rollout.held_out.words(),
        escape(&before),
        escape(&rollout.integrator.name),
        significant(rollout.integrator.step),
        count(rollout.integrator.checked, "window"),
    )
}

/// Medians and quartiles of every joint over the time since the start.
fn pictures(rollout: &Rollout) -> String {
    let mut out = format!(
        "<h3>Error of position over the horizon</h3>\n<p class=\"hint\">{}{}{}: medians with quartiles over windows</p>\n<div class=\"plots\">\n",
        if rollout.before.is_some() {
            key(RESIDUAL, "before")
        } else {
            String::new()
        },
        key(PREDICTED, "after"),
        key(RECORDED, "noise alone"),
    );
    for curve in &rollout.curves {
        let caption = format!("<b>{}</b> [{}]", escape(&curve.joint), escape(&curve.unit));
        let mut lines = spread_lines(curve, &curve.noise, RECORDED);
        lines.extend(spread_lines(curve, &curve.before, RESIDUAL));
        lines.extend(spread_lines(curve, &curve.after, PREDICTED));
        let label = format!("error of {} over the horizon", curve.joint);
        out.push_str(&figure(&caption, &curves(&lines, &[], "t [s]", &label)));
    }
    out.push_str("</div>\n");
    out
}

fn spread_lines(curve: &ErrorCurve, spreads: &[Spread], colour: RGBColor) -> Vec<Curve> {
    let along = |of: &dyn Fn(&Spread) -> Option<f64>| {
        let points = curve.t.iter().zip(spreads);
        let points: Vec<Point> = points
            .map(|(t, spread)| (*t, of(spread).unwrap_or(f64::NAN)))
            .collect();
        Curve::new(points, colour)
    };
    vec![
        along(&|s| s.lower_quartile),
        along(&|s| s.median),
        along(&|s| s.upper_quartile),
    ]
}

fn table(rollout: &Rollout) -> String {
    let of_model = ["Quartiles", "RMS", "Lost"];
    let mut columns = vec!["Joint", "Horizon [s]", "Unit"];
    if rollout.before.is_some() {
        columns.push("Before");
        columns.extend(of_model);
    }
    columns.push("After");
    columns.extend(of_model);
    columns.extend(["Noise alone", "RMS", "Halving", "Windows"]);
    let mut table = Table::new(&columns);
    let names = rollout.horizons.first().map_or(0, |h| h.joints.len());
    for joint in 0..names {
        table.begin_group();
        for horizon in &rollout.horizons {
            let Some(errors) = horizon.joints.get(joint) else {
                continue;
            };
            let mut cells = vec![
                Cell::name(&errors.joint),
                Cell::Number(significant(horizon.horizon)),
                Cell::text(&errors.unit),
            ];
            if rollout.before.is_some() {
                cells.extend(of_spread(&errors.before.unwrap_or_default()));
            }
            cells.extend(of_spread(&errors.after));
            cells.extend([
                Cell::Number(optional(errors.noise.median)),
                Cell::Number(optional(errors.noise.rms)),
                Cell::Number(significant(errors.integration)),
                Cell::Number(errors.after.windows.to_string()),
            ]);
            table.row(cells);
        }
    }
    format!("<h3>By horizon</h3>\n{}", table.html())
}

/// Median, quartiles, root mean square, and windows in which the model is lost.
fn of_spread(spread: &Spread) -> [Cell; 4] {
    [
        Cell::Number(optional(spread.median)),
        Cell::text(quartiles(spread)),
        Cell::Number(optional(spread.rms)),
        Cell::Number(spread.lost.to_string()),
    ]
}

/// Positions of the joints in one window.
fn window(rollout: &Rollout, example: &Example) -> String {
    let mut out = format!(
        "<h3>The {} window</h3>\n<p class=\"hint\">{}{}{}from {} s of <code>{}</code></p>\n<div class=\"plots\">\n",
        escape(&example.kind),
        key(RECORDED, "recorded"),
        if rollout.before.is_some() {
            key(RESIDUAL, "before")
        } else {
            String::new()
        },
        key(PREDICTED, "after"),
        significant(example.start),
        escape(&example.recording),
    );
    for joint in &example.joints {
        let line = |series: &[f64], colour: RGBColor| {
            let points = example.t.iter().copied().zip(series.iter().copied());
            Curve::new(points.collect(), colour)
        };
        let lines = [
            line(&joint.before, RESIDUAL),
            line(&joint.recorded, RECORDED),
            line(&joint.after, PREDICTED),
        ];
        let caption = format!("<b>{}</b> [{}]", escape(&joint.joint), escape(&joint.unit));
        let label = format!("position of {} in the {} window", joint.joint, example.kind);
        out.push_str(&figure(&caption, &curves(&lines, &[], "t [s]", &label)));
    }
    out.push_str("</div>\n");
    out
}
