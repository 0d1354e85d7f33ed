//! The same fit with other lists of effects, side by side.

use crate::outcome::fit::Comparison;
use crate::outcome::joint::JointFigures;
use crate::outcome::model_comparison::{ErrorFigure, ModelComparison, ModelErrors};
use crate::report::escape::{breakable, escape, prose};
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
        "<p class=\"hint\">RMSE, {which}.</p>\n{}<ul>\n{}</ul>\n{}{}",
        table.html(),
        fit.comparison.iter().map(effects).collect::<String>(),
        MEASURES
            .map(|measure| errors(&fit.contests, measure))
            .concat(),
        verdicts(&fit.contests)
    );
    Some(Section::new("comparison", "Comparison of models", body))
}

fn error(joint: &JointFigures) -> String {
    significant(joint.rmse_validation.unwrap_or(joint.rmse_train))
}

/// What a table of errors shows, and the error of a model.
/// A figure of the errors of a model.
struct Measure {
    title: &'static str,
    of: fn(&ModelErrors) -> Option<ErrorFigure>,
}

const MEASURES: [Measure; 4] = [
    Measure {
        title: "RMSE, identification",
        of: |m| Some(m.rmse_train),
    },
    Measure {
        title: "RMSE, validation",
        of: |m| m.rmse_validation,
    },
    Measure {
        title: "MAE, identification",
        of: |m| Some(m.mae_train),
    },
    Measure {
        title: "MAE, validation",
        of: |m| m.mae_validation,
    },
];

/// Errors of every model with their 95 % intervals, joint by joint; empty where there are none.
fn errors(comparisons: &[ModelComparison], measure: Measure) -> String {
    let Measure { title, of } = measure;
    let joints = || comparisons.iter().filter(|c| c.joint.is_some());
    let Some(first) = joints().next() else {
        return String::new();
    };
    if first.models.iter().any(|model| of(model).is_none()) {
        return String::new();
    }
    let mut headers = vec!["Joint", "Unit"];
    headers.extend(first.models.iter().map(|model| model.name.as_str()));
    let mut table = Table::new(&headers);
    for comparison in joints() {
        let joint = comparison.joint.as_deref().unwrap_or_default();
        let mut cells = vec![Cell::name(joint), Cell::text(&comparison.unit)];
        let figures = comparison.models.iter().filter_map(of);
        cells.extend(figures.map(|figure| Cell::Number(with_interval(figure))));
        table.row(cells);
    }
    format!(
        "<p class=\"hint\">{title}, with 95 % intervals.</p>\n{}",
        table.html()
    )
}

fn with_interval(figure: ErrorFigure) -> String {
    let value = significant(figure.value);
    match figure.ci95 {
        Some([low, high]) => format!("{value} ({} to {})", significant(low), significant(high)),
        None => value,
    }
}

/// Which model predicts best, joint by joint.
fn verdicts(comparisons: &[ModelComparison]) -> String {
    let line = |comparison: &ModelComparison| {
        let joint = comparison.joint.as_deref().unwrap_or("all joints together");
        format!(
            "<li>{}: {}</li>\n",
            escape(joint),
            prose(&comparison.sentence)
        )
    };
    match comparisons {
        [] => String::new(),
        _ => format!(
            "<ul>\n{}</ul>\n",
            comparisons.iter().map(line).collect::<String>()
        ),
    }
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
