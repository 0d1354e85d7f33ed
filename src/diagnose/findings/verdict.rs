//! The verdict of a diagnosis, and the parameters of the declared model that what was missing had biased.

use crate::diagnose::findings::compared::{LackOfFit, MOSTLY};
use crate::diagnose::residuals::noise_level::LEAST_EXCESS;
use crate::outcome::diagnose::{BiasedParameter, Unattested, Verdict};
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
pub fn biased(before: &[Parameter], after: &[Parameter]) -> Vec<BiasedParameter> {
    /// Standard deviations of the later estimate beyond which a change is one.
    const MOVED: f64 = 3.0;
    let mut biased: Vec<(f64, BiasedParameter)> = after
        .iter()
        .filter_map(|new| {
            let old = before.iter().find(|p| p.name == new.name)?;
            let (from, to, deviation) = (old.value?, new.value?, new.std_dev?);
            let moved = (to - from).abs() / deviation;
            let entry = BiasedParameter {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn finding(effect: &str) -> Finding {
        Finding {
            effect: effect.to_string(),
            joints: vec!["j1".to_string()],
            parameters: Vec::new(),
            rmse_validation_before: 2.0,
            rmse_validation_after: 1.0,
            explained_share: 0.5,
            p_value: 1e-6,
            sentence: String::new(),
            rivals: Vec::new(),
            probability: 1.0,
            probability_unnamed: 0.0,
            probability_nothing: 0.0,
            formula: None,
        }
    }

    /// Nine tenths of the excess over the noise, half of it, less.
    #[test]
    fn a_misfit_is_explained_by_most_of_its_excess() {
        let named = [finding("torque_offset")];
        let of = |findings: &[Finding], before: f64, after: f64| {
            verdict(findings, LackOfFit { before, after }, &[])
        };
        assert_eq!(of(&[], 1.0, 1.0), Verdict::NothingMissing);
        assert_eq!(of(&named, 11.0, 1.9), Verdict::Explained);
        assert_eq!(of(&named, 11.0, 2.1), Verdict::PartlyExplained);
        assert_eq!(of(&named, 11.0, 5.9), Verdict::PartlyExplained);
        assert_eq!(of(&named, 11.0, 6.1), Verdict::Unexplained);
        // However little was there, what is left is noise.
        assert_eq!(of(&named, 1.06, 1.04), Verdict::Explained);
        let beside = [finding("torque_offset"), finding("unnamed")];
        assert_eq!(of(&beside, 11.0, 1.1), Verdict::PartlyExplained);
        assert_eq!(of(&beside[1..], 11.0, 1.1), Verdict::Unexplained);
        let left = Unattested {
            joint: "j2".to_string(),
            unit: "A".to_string(),
            rmse_validation: 1.0,
            of_signal: 0.1,
            sentence: String::new(),
        };
        let lack = LackOfFit {
            before: 11.0,
            after: 1.1,
        };
        let open = std::slice::from_ref(&left);
        assert_eq!(verdict(&named, lack, open), Verdict::PartlyExplained);
        assert_eq!(verdict(&[], lack, open), Verdict::Unexplained);
    }

    #[test]
    fn what_moved_by_three_deviations_was_biased() {
        let estimated = |name: &str, value: f64| Parameter {
            std_dev: Some(0.5),
            ..Parameter::known(name, "N·m", value)
        };
        let before = ["a", "b", "c"].map(|name| estimated(name, 1.0));
        let after = [
            estimated("a", 2.4),
            estimated("b", 2.6),
            estimated("c", -1.0),
            estimated("d", 9.0),
        ];
        let moved = biased(&before, &after);
        let names: Vec<&str> = moved.iter().map(|spoiled| spoiled.name.as_str()).collect();
        assert_eq!(names, ["c", "b"]);
        assert_eq!((moved[1].before, moved[1].after), (1.0, 2.6));
    }
}
