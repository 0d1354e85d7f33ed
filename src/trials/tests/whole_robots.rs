//! Whole robots with several effects at once: what a search has to look for beside what is yet missing, and not to lose.

use crate::outcome::trials::{Hidden, Trial};
use crate::problem::solution::Control;
use crate::trials::motion::{Motion, Noise};
use crate::trials::plan::{AtOnce, Scope};
use crate::trials::run::run;

/// The seed of most of the robots.
const SEED: u64 = 271653;

fn scope(seed: u64, least: usize, most: usize) -> Scope {
    Scope {
        motions: vec![Motion::Fourier],
        noises: vec![Noise::White],
        at_once: Some(AtOnce { least, most }),
        ..Scope::all(seed)
    }
}

fn whole_robot(seed: u64, number: u64) -> Trial {
    run(&scope(seed, 3, 8), number, &Control::default())
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
    let effects = vec![
        "backlash",
        "transmission_efficiency",
        "unmodelled_payload",
        "torque_ripple",
        "stribeck_friction",
        "drive_gain",
        "rotor_inertia",
    ];
    let scope = Scope {
        effects,
        ..scope(664422, 3, 5)
    };
    assert_all_named(&run(&scope, 15, &Control::default()));
}

/// Rounding of the encoders repeats with the motion, and two parallel axes have more of it in their torques than each has in its
/// acceleration.
#[test]
fn noise_of_coupled_joints_is_no_elasticity() {
    let trial = whole_robot(517709, 10);
    let mut found = trial.found.iter();
    assert!(
        found.all(|f| f.effect != "joint_elasticity"),
        "{:#?}",
        trial.found
    );
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
    // A rotor inertia of less than the noise is concealed beside them.
    let trial = whole_robot(946150, 20);
    let found: Vec<&str> = trial.found.iter().map(|f| f.effect.as_str()).collect();
    assert_eq!(
        found,
        ["base_tilt", "presliding_hysteresis"],
        "{:#?}",
        trial.found
    );
}

/// Bristles whose force beyond Coulomb friction leaves no trace: one of a hundred times what the joint ever bears fits as well by
/// chance, and the search for what lies beside it then ends far off.
#[test]
fn bristles_gain_no_force_that_chance_would_give_them() {
    assert_all_named(&whole_robot(946150, 3));
}

/// A spot of friction as wide as half of the motion has several optima, and one step of all parameters promises most where none of them
/// is.
#[test]
fn a_wide_spot_is_found() {
    assert_all_named(&whole_robot(SEED, 22));
}
