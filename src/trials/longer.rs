//! Whether a longer recording of the same robot tells apart what a diagnosis said it could not.

use crate::chain::dataset::Dataset;
use crate::chain::effect::Memory;
use crate::diagnose::conclude::joint_names;
use crate::diagnose::drift::unrolled;
use crate::diagnose::floor;
use crate::diagnose::refit::Refit;
use crate::diagnose::rivals::{Doubt, Stated, separation};
use crate::outcome::trials::{Found, LONGER};
use crate::problem::solution::Control;
use crate::trials::error::TrialError;
use crate::trials::plan::Plan;
use crate::trials::run::{Opened, PROBLEM, prepare};
use std::fs;
use std::path::Path;

/// Puts every claim of a diagnosis to recordings of [`LONGER`] times the length, which are written into a new
/// folder.
pub fn judge(
    plan: &Plan,
    (doubts, found): (&[Doubt], &mut [Found]),
    (folder, control): (&Path, &Control<'_>),
) -> Result<(), TrialError> {
    if doubts.is_empty() {
        return Ok(());
    }
    fs::create_dir(folder)?;
    let mut longer = plan.clone();
    longer.course.periods *= LONGER;
    prepare(&longer, folder, control)?;
    let opened = Opened::read(&folder.join(PROBLEM), control)?;
    for doubt in doubts {
        let named = doubt.found.hypotheses.get(doubt.finding);
        let (Some(named), Some(finding)) = (named, found.get_mut(doubt.finding)) else {
            continue;
        };
        let joints = named.named_joints();
        let data = rows(&opened.data, doubt);
        let fit = |stated: &Stated| opened.fit(&data, (&stated.hypotheses, &stated.start), control);
        let full = fit(&doubt.found)?;
        let bench = opened.bench(&data, control);
        let noise = floor::of_rows(&bench, &full, &[]);
        for rival in &doubt.rivals {
            let other = fit(rival)?;
            let apart =
                |pair: (&Refit, &Refit)| separation(&bench, &noise, pair, &joints).separable;
            let told_apart = apart((&other, &full)) || apart((&full, &other));
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
fn rows(data: &Dataset, doubt: &Doubt) -> Dataset {
    let models = std::iter::once(&doubt.found).chain(&doubt.rivals);
    let mut hypotheses = models.flat_map(|stated| &stated.hypotheses);
    match hypotheses.any(|h| h.effect.needs.memory == Memory::Time) {
        true => unrolled(data),
        false => data.clone(),
    }
}
