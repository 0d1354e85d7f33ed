//! The same fit with other lists of effects, side by side.

use crate::outcome::fit::Comparison;
use crate::outcome::joint::JointFigures;
use crate::report::html::{breakable, escape};
use crate::report::number::{optional, significant};
use crate::report::section::{Section, Source};
use crate::report::table::{Cell, Table};

pub(super) fn section(source: &Source) -> Option<Section> {
    let fit = source.fit()?;
    if fit.comparison.is_empty() {
        return None;
    }
    let joints = &source.outcome.estimate.joints;
    let mut headers = vec!["Joint", "Unit", "This fit"];
    headers.extend(fit.comparison.iter().map(|variant| variant.name.as_str()));
    let mut table = Table::new(&headers);
    for joint in joints {
        let mut cells = vec![Cell::name(&joint.joint), Cell::text(&joint.unit)];
        cells.push(Cell::Number(error(joint)));
        cells.extend(fit.comparison.iter().map(|variant| {
            let figures = variant
                .joints
                .iter()
                .find(|other| other.joint == joint.joint);
            Cell::Number(figures.map_or_else(|| optional(None), error))
        }));
        table.row(cells);
    }
    let held_out = joints.iter().any(|joint| joint.rmse_validation.is_some());
    let which = if held_out {
        "held out"
    } else {
        "of training, nothing was held out"
    };
    let body = format!(
        "<p class=\"hint\">RMSE, {which}.</p>\n{}<ul>\n{}</ul>\n",
        table.html(),
        fit.comparison.iter().map(effects).collect::<String>()
    );
    Some(Section::new("comparison", "Comparison of models", body))
}

fn error(joint: &JointFigures) -> String {
    significant(joint.rmse_validation.unwrap_or(joint.rmse_train))
}

fn effects(variant: &Comparison) -> String {
    let effects: Vec<String> = variant
        .effects
        .iter()
        .map(|effect| format!("<code>{}</code>", breakable(effect)))
        .collect();
    let effects = if effects.is_empty() {
        "no effects".to_string()
    } else {
        effects.join(", ")
    };
    format!("<li><b>{}</b>: {effects}</li>\n", escape(&variant.name))
}
