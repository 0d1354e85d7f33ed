//! The forecast of a larger motion: what a diagnosis leaves of a law there with its smooth correction, and with its formula.

use crate::diagnose::findings::report::Nameless;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::residuals::additive_model::{self, AdditiveModel};
use crate::outcome::trials::Forecast;
use crate::problem::solution::Control;
use crate::stats::deviation::rms;
use crate::trials::error::TrialError;
use crate::trials::plan::Plan;
use crate::trials::reference_fits::DeclaredModel;
use std::path::Path;

/// RMS of what models leave of a joint's signal in the validation recording of a problem, which has no noise, over the noise of a row.
pub fn forecast(
    plan: &Plan,
    nameless: &Nameless,
    joint: usize,
    problem: &Path,
    control: &Control<'_>,
) -> Result<Forecast, TrialError> {
    let opened = DeclaredModel::read(problem, control)?;
    let context = opened.context(&opened.data, control);
    let noise = plan.robot.noise[joint] / plan.averaged().sqrt();
    let left = |fit: &ModelFit, corrections: &[&AdditiveModel]| {
        let left = additive_model::left(fit, corrections);
        left.get(joint).map_or(f64::NAN, |left| rms(left) / noise)
    };
    let full = nameless.full.on(&context);
    let corrections = nameless.corrections.iter();
    let corrections: Vec<AdditiveModel> = corrections
        .map(|correction| correction.on(&context, &full, &[]))
        .collect();
    let formula = nameless.formulas.iter().find(|f| f.channel == joint);
    Ok(Forecast {
        nothing: left(&full, &[]),
        smooth: left(&full, &corrections.iter().collect::<Vec<_>>()),
        formula: formula.map(|formula| left(&formula.fit.on(&context), &[])),
    })
}
