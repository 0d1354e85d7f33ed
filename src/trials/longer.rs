//! Whether a longer recording of the same robot tells apart what a diagnosis said it could not.

use crate::chain::dataset::Dataset;
use crate::chain::effect::Memory;
use crate::diagnose::drift::unrolled;
use crate::diagnose::floor;
use crate::diagnose::refit::Refit;
use crate::diagnose::rivals::{Doubt, Stated, sets_aside};
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
    let opened = Opened::read(&folder.join(PROBLEM))?;
    for doubt in doubts {
        let joints = joints_of(&doubt.found, doubt.finding);
        let Some(finding) = found.get_mut(doubt.finding) else {
            continue;
        };
        let data = rows(&opened.data, doubt);
        let fit = |stated: &Stated| opened.fit(&data, (&stated.hypotheses, &stated.start), control);
        let full = fit(&doubt.found)?;
        let noise = floor::of_rows(&opened.bench(&data, control), &full, &[]);
        for rival in &doubt.rivals {
            let other = fit(rival)?;
            let apart = |pair: (&Refit, &Refit)| sets_aside(&noise, pair, &joints);
            let told_apart = apart((&other, &full)) || apart((&full, &other));
            let named = names(rival, &other);
            let claims = finding.inseparable.iter_mut();
            let own = claims.filter(|claim| (&claim.effect, &claim.joints) == (&named.0, &named.1));
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

fn joints_of(stated: &Stated, k: usize) -> Vec<usize> {
    stated
        .hypotheses
        .get(k)
        .map_or_else(Vec::new, |h| h.named_joints())
}

/// Effect and joints of the hypothesis that stands in the place of the finding.
fn names(stated: &Stated, refit: &Refit) -> (String, Vec<String>) {
    let joints = joints_of(stated, stated.hypotheses.len() - 1);
    let name = |j: usize| refit.model.joints()[j].name.clone();
    let effect = stated.hypotheses.last().map_or("", |h| h.effect.id);
    (effect.to_string(), joints.into_iter().map(name).collect())
}
