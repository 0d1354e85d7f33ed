//! Whether a longer recording of the same robot separates rivals that a diagnosis could not separate.

use crate::chain::dataset::Dataset;
use crate::chain::effect::Memory;
use crate::diagnose::fit::hypothesis::joint_names;
use crate::diagnose::fit::model_fit::{FitPair, ModelFit};
use crate::diagnose::residuals::noise_level;
use crate::diagnose::selection::rival_models::{Ambiguity, StatedModel, separation};
use crate::outcome::trials::{Found, LONGER};
use crate::problem::solution::Control;
use crate::trials::error::TrialError;
use crate::trials::files::{PROBLEM, prepare};
use crate::trials::plan::Plan;
use crate::trials::reference_fits::DeclaredModel;
use std::fs;
use std::path::Path;

/// Puts every claim of a diagnosis to recordings of [`LONGER`] times the length, which are written into a new
/// folder.
pub fn judge(
    plan: &Plan,
    ambiguities: &[Ambiguity],
    found: &mut [Found],
    folder: &Path,
    control: &Control<'_>,
) -> Result<(), TrialError> {
    if ambiguities.is_empty() {
        return Ok(());
    }
    fs::create_dir(folder)?;
    let mut longer = plan.clone();
    longer.length.periods *= LONGER;
    prepare(&longer, folder, control)?;
    let opened = DeclaredModel::read(&folder.join(PROBLEM), control)?;
    for ambiguity in ambiguities {
        let named = ambiguity.found.hypotheses.get(ambiguity.finding);
        let (Some(named), Some(finding)) = (named, found.get_mut(ambiguity.finding)) else {
            continue;
        };
        let joints = named.named_joints();
        let data = rows(&opened.data, ambiguity);
        let fit =
            |stated: &StatedModel| opened.fit(&data, &stated.hypotheses, &stated.start, control);
        let full = fit(&ambiguity.found)?;
        let context = opened.context(&data, control);
        let noise = noise_level::of_rows(&context, &full, &[]);
        for rival in &ambiguity.rivals {
            let other = fit(rival)?;
            let apart = |poorer: &ModelFit, richer: &ModelFit| {
                let pair = FitPair { poorer, richer };
                separation(&context, &noise, pair, &joints).separable
            };
            let told_apart = apart(&other, &full) || apart(&full, &other);
            let Some(own) = other.hypotheses.last() else {
                continue;
            };
            let names = joint_names(&other.model, &own.named_joints());
            let claims = finding.inseparable.iter_mut();
            let own = claims.filter(|c| c.effect == own.effect.id && c.joints == names);
            own.for_each(|claim| claim.told_apart = Some(told_apart));
        }
    }
    Ok(())
}

/// The rows that the diagnosis looked at: in the order of time where something changes from period to period.
fn rows(data: &Dataset, ambiguity: &Ambiguity) -> Dataset {
    let models = std::iter::once(&ambiguity.found).chain(&ambiguity.rivals);
    let mut hypotheses = models.flat_map(|stated| &stated.hypotheses);
    match hypotheses.any(|h| h.effect.needs.memory == Memory::Time) {
        true => data.in_successive_periods(),
        false => data.clone(),
    }
}
