//! How well each joint is predicted, on what was fitted and on what was held out.

use crate::outcome::joint::JointFigures;
use crate::report::number::{optional, percent, significant};
use crate::report::plots::rows::{Bars, bars};
use crate::report::plots::{PREDICTED, RECORDED, figure, key};
use crate::report::section::{Section, Source};
use crate::report::table::{Cell, Table};

const EXPLANATION: &str = "<p class=\"hint\">RMSE: root mean square of prediction minus recording, \
    after the preprocessing below; raw: over every recorded sample, unfiltered. Relative: norm of \
    the residual over norm of the signal. Noise: standard deviation of one preprocessed sample by \
    evidence that needs no model. Lack of fit: mean squared residual over squared noise; 1 means \
    that nothing is left to explain.</p>\n";

pub(super) fn section(source: &Source) -> Option<Section> {
    let joints = &source.outcome.estimate.joints;
    if joints.is_empty() {
        return None;
    }
    let body = format!("{}{}{EXPLANATION}", chart(joints), table(joints).html());
    Some(Section::new("joints", "Accuracy by joint", body))
}

fn table(joints: &[JointFigures]) -> Table {
    let mut table = Table::new(&[
        "Joint",
        "Unit",
        "RMSE train",
        "RMSE held out",
        "Noise",
        "Relative train",
        "Relative held out",
        "Lack of fit",
        "MAE train",
        "MAE held out",
        "RMSE train raw",
        "RMSE held out raw",
    ]);
    for joint in joints {
        let mut cells = vec![Cell::name(&joint.joint), Cell::text(&joint.unit)];
        let numbers = [
            significant(joint.rmse_train),
            optional(joint.rmse_validation),
            optional(joint.noise_rms),
            percent(joint.relative_train),
            percent(joint.relative_validation.unwrap_or(f64::NAN)),
            optional(joint.lack_of_fit),
            significant(joint.mae_train),
            optional(joint.mae_validation),
            significant(joint.rmse_train_raw),
            optional(joint.rmse_validation_raw),
        ];
        cells.extend(numbers.into_iter().map(Cell::Number));
        table.row(cells);
    }
    table
}

/// Errors of all joints on one axis without unit: in multiples of the noise where every joint has
/// that evidence, else as a share of the signal.
fn chart(joints: &[JointFigures]) -> String {
    let noise: Option<Vec<f64>> = joints
        .iter()
        .map(|joint| joint.noise_rms.filter(|noise| *noise > 0.0))
        .collect();
    let held_out = joints.iter().any(|joint| joint.rmse_validation.is_some());
    let mut legend = key(RECORDED, "train");
    if held_out {
        legend.push_str(&key(PREDICTED, "held out"));
    }
    let row = |joint: &JointFigures, train, validation| Bars {
        label: joint.joint.clone(),
        train,
        validation,
    };
    let (rows, reference, axis, title): (Vec<Bars>, _, _, _) = match noise {
        Some(noise) => {
            let ratios = joints.iter().zip(noise).map(|(joint, noise)| {
                let validation = joint.rmse_validation.map(|rmse| rmse / noise);
                row(joint, joint.rmse_train / noise, validation)
            });
            (
                ratios.collect(),
                Some(1.0),
                "RMSE / noise",
                "RMSE in multiples of the noise",
            )
        }
        None => {
            let shares = joints.iter().map(|joint| {
                let validation = joint.relative_validation.map(|share| 100.0 * share);
                row(joint, 100.0 * joint.relative_train, validation)
            });
            (
                shares.collect(),
                None,
                "residual / signal [%]",
                "Residual as a share of the signal",
            )
        }
    };
    let caption = format!("<b>{title}</b>{legend}");
    let plot = figure(&caption, &bars(&rows, reference, axis));
    format!("<div class=\"plots\">{plot}</div>\n")
}
