//! Where the misfit lies, and every hypothesis that was fitted.

use crate::outcome::diagnose::Located;
use crate::report::escape::escape;
use crate::report::number::{percent, significant};
use crate::report::plots::figure;
use crate::report::plots::scatter::scatter;
use crate::report::section::{Section, Source};
use crate::report::series::Point;
use crate::report::table::{Cell, Table};

pub(super) fn located(source: &Source) -> Option<Section> {
    let diagnosis = source.diagnosis()?;
    if diagnosis.located.is_empty() {
        return None;
    }
    let mut table = Table::new(&[
        "Joint",
        "Variable",
        "Explains",
        "Most of it from",
        "to",
        "Unit",
    ]);
    let mut plots = String::new();
    for place in &diagnosis.located {
        table.row(vec![
            Cell::name(&place.joint),
            Cell::text(&place.variable),
            Cell::Number(percent(place.share)),
            Cell::Number(significant(place.low)),
            Cell::Number(significant(place.high)),
            Cell::text(&place.unit),
        ]);
        plots.push_str(&picture(place));
    }
    let hint = "<p class=\"hint\">Share of the declared model's residual on held-out rows that its mean over \
                the variable forecasts. Plots: mean residual, recorded minus predicted, along the motion \
                where the direction counts.</p>\n";
    let body = format!("{}{hint}<div class=\"plots\">{plots}</div>\n", table.html());
    Some(Section::new("located", "Where the misfit lies", body))
}

fn picture(place: &Located) -> String {
    let curve: Vec<Point> = place.curve.iter().map(|p| (p.at, p.mean)).collect();
    let caption = format!(
        "<b>{}</b> over {}",
        escape(&place.joint),
        escape(&place.variable)
    );
    let title = format!("{} [{}]", place.variable, place.unit);
    let label = format!("Mean residual of {} over {}", place.joint, place.variable);
    figure(&caption, &scatter(&curve, &title, &label))
}

pub(super) fn tried(source: &Source) -> Option<Section> {
    let diagnosis = source.diagnosis()?;
    if diagnosis.evidence.is_empty() {
        return None;
    }
    let mut table = Table::new(&[
        "Beside",
        "Hypothesis",
        "Joints",
        "True share",
        "Error falls by",
        "p",
        "Accepted",
    ]);
    let mut step = usize::MAX;
    for entry in &diagnosis.evidence {
        if entry.step != step {
            step = entry.step;
            table.begin_group();
        }
        let beside = match entry.step {
            0 => "the declared model".to_string(),
            1 => "1 finding".to_string(),
            count => format!("{count} findings"),
        };
        table.row(vec![
            Cell::text(&beside),
            Cell::text(&entry.effect),
            Cell::text(entry.joints.join(", ")),
            Cell::Number(significant(entry.slope)),
            Cell::Number(percent(entry.relief)),
            Cell::Number(significant(entry.p_value)),
            Cell::text(if entry.accepted { "yes" } else { "" }),
        ]);
    }
    let hint = "<p class=\"hint\">Each hypothesis was fitted together with all other parameters. True share: the \
                part of what it takes from the residual that held-out recordings confirm, 0 where nothing is \
                missing and 1 where it is right. p: of such a share by chance, corrected for all hypotheses \
                tried and for autocorrelation.</p>\n";
    Some(Section::new(
        "evidence",
        "What was tried",
        format!("{}{hint}", table.html()),
    ))
}
