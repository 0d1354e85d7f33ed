//! Whole robots with several effects at once: what a search has to look for beside what is yet missing, and not to lose.

use crate::outcome::trials::{Hidden, Trial};
use crate::problem::solution::Control;
use crate::trials::motion::{Motion, Noise};
use crate::trials::plan::{AtOnce, Scope};
use crate::trials::run::run;

/// The seed of most of the robots.
const SEED: u64 = 271653;

fn whole_robot(seed: u64, number: u64) -> Trial {
    let scope = Scope {
        motions: vec![Motion::Fourier],
        noises: vec![Noise::White],
        at_once: Some(AtOnce { least: 3, most: 8 }),
        ..Scope::all(seed)
    };
    run(&scope, number, &Control::default())
}

fn assert_all_named(trial: &Trial) {
    let is_named = |hidden: &Hidden| {
        let mut found = trial.found.iter();
        found.any(|f| f.effect == hidden.effect && f.joints == hidden.joints)
    };
    assert!(trial.concealed.iter().all(is_named), "{trial:#?}");
    assert_eq!(trial.found.len(), trial.concealed.len(), "{trial:#?}");
}

/// Impacts of play shake the whole robot, and which gap it is shows only where everything else is fitted beside it.
#[test]
fn a_gap_is_found_while_other_physics_is_missing() {
    assert_all_named(&whole_robot(SEED, 82));
}

/// Of bristles that never break, as they stand in for what is missing, the breaking force is free: it says nothing against what
/// explains the rows.
#[test]
fn what_leaves_no_trace_speaks_against_no_finding() {
    assert_all_named(&whole_robot(SEED, 21));
}

/// Bristles that lower the error of their joint only beside the effects that were found after them.
#[test]
fn a_finding_that_helps_beside_later_ones_stays() {
    assert_all_named(&whole_robot(SEED, 83));
}

/// Bristles that bend by a tenth of a radian, whose dry friction the poorer model has nothing of.
#[test]
fn soft_bristles_are_found() {
    assert_all_named(&whole_robot(946150, 3));
}
