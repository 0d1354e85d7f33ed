//! The verdict of a diagnosis, and the parameters of the declared model that what was missing had biased.

use crate::diagnose::findings::compared::{LackOfFit, MOSTLY};
use crate::diagnose::residuals::noise_level::LEAST_EXCESS;
use crate::outcome::diagnose::{Spoiled, Unattested, Verdict};
use crate::outcome::finding::Finding;
use crate::outcome::parameter::Parameter;

/// Share of the excess that findings explain where they explain part of it.
const PARTLY: f64 = 0.5;

/// The verdict from the lack of fit of the joints that findings name, before and after, from what is left without a name,
/// and from whether what is left is known to be noise.
pub fn verdict(findings: &[Finding], lack: LackOfFit, unattested: &[Unattested]) -> Verdict {
    let LackOfFit { before, after } = lack;
    let named = findings.iter().filter(|f| !f.has_no_name()).count();
    if named == 0 {
        return match findings.is_empty() && unattested.is_empty() {
            true => Verdict::NothingMissing,
            false => Verdict::Unexplained,
        };
    }
    let share = (before - after) / (before - 1.0).max(LEAST_EXCESS);
    let all_named = named == findings.len() && unattested.is_empty();
    if all_named && (share >= MOSTLY || after - 1.0 <= LEAST_EXCESS) {
        Verdict::Explained
    } else if share >= PARTLY {
        Verdict::PartlyExplained
    } else {
        Verdict::Unexplained
    }
}

/// Parameters that both models determine and that moved by more than their uncertainty.
pub fn biased(before: &[Parameter], after: &[Parameter]) -> Vec<Spoiled> {
    /// Standard deviations of the later estimate beyond which a change is one.
    const MOVED: f64 = 3.0;
    let mut biased: Vec<(f64, Spoiled)> = after
        .iter()
        .filter_map(|new| {
            let old = before.iter().find(|p| p.name == new.name)?;
            let (from, to, deviation) = (old.value?, new.value?, new.std_dev?);
            let moved = (to - from).abs() / deviation;
            let entry = Spoiled {
                name: new.name.clone(),
                unit: new.unit.clone(),
                before: from,
                after: to,
                std_dev: deviation,
            };
            (moved > MOVED).then_some((moved, entry))
        })
        .collect();
    biased.sort_by(|a, b| b.0.total_cmp(&a.0));
    biased.into_iter().map(|(_, entry)| entry).collect()
}
