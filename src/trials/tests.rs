//! Trials follow from their seed, robots are possible, and rates count what they say.

use crate::chain::effect;
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::rivals::{Doubt, Stated};
use crate::outcome::trials::{Found, Hidden, Inseparable, Trial, is_outside};
use crate::problem::solution::Control;
use crate::trials::outside::Outside;
use crate::trials::plan::{Plan, Scope};
use crate::trials::run::run;
use crate::trials::tally::tally;
use crate::trials::{conceal, longer};

#[test]
fn every_effect_that_is_not_declared_is_concealed_in_some_trial() {
    let scope = Scope::all(3);
    let drawn: Vec<Plan> = (0..200).map(|n| Plan::draw(&scope, (n, 0))).collect();
    for known in conceal::effects() {
        let has = |plan: &Plan| {
            plan.concealed
                .iter()
                .any(|c| c.hypothesis.effect.id == known.id)
        };
        assert!(drawn.iter().any(has), "{}", known.id);
    }
    for law in Outside::ALL {
        assert!(is_outside(law.name()) && effect::find(law.name()).is_none());
    }
    let controls = drawn
        .iter()
        .filter(|p| p.concealed.is_empty() && p.outside.is_none());
    assert_eq!(controls.count(), 40);
    for plan in &drawn {
        for link in plan.robot.tree.joints() {
            assert!(
                link.inertia
                    .central()
                    .is_some_and(|c| c.tensor.symmetric_eigenvalues().min() > 0.0)
            );
        }
        assert!(
            plan.concealed
                .iter()
                .all(|c| effect::find(c.hypothesis.effect.id).is_some() && !c.values.is_empty())
        );
    }
}

#[test]
fn a_trial_is_the_same_again() {
    let scope = Scope {
        effects: vec!["torque_offset"],
        robots: vec!["arm3"],
        ..Scope::all(5)
    };
    let [first, second] = [0, 1].map(|_| run(&scope, 1, &Control::default()));
    assert_eq!(first.failure, None);
    assert_eq!(
        Trial {
            seconds: 0.0,
            ..first
        },
        Trial {
            seconds: 0.0,
            ..second
        }
    );
}

/// A rotor and a spring that the declared model lacks: its links take their place, and no longer do with what is found.
#[test]
fn bodies_are_as_right_with_what_is_found_as_with_the_truth() {
    for number in [13, 20] {
        let trial = run(&Scope::all(5), number, &Control::default());
        let [declared, found, known] = trial.body_error.unwrap();
        assert!(declared > 5.0 * known, "{number}: {declared} {known}");
        assert!(found < 1.5 * known, "{number}: {found} {known}");
        // Of the noise of a sample, where thousands of samples are fitted.
        assert!(known < 0.2, "{number}: {known}");
    }
}

fn trial(seed: u64, size: Option<f64>, found: Option<&str>) -> Trial {
    let joints = vec!["j1".to_string()];
    let right = size.is_some() && found == Some("joint_spring");
    Trial {
        seed,
        concealed: size
            .map(|effect_over_noise| Hidden {
                effect: "joint_spring".to_string(),
                joints: joints.clone(),
                effect_over_noise,
            })
            .into_iter()
            .collect(),
        found: found
            .map(|effect| Found {
                effect: effect.to_string(),
                joints,
                ..Found::default()
            })
            .into_iter()
            .collect(),
        right_effect: right,
        right_joints: size.is_some() && found.is_some(),
        all_found: right,
        ..Trial::default()
    }
}

#[test]
fn rates_count_large_effects_and_controls() {
    let trials = vec![
        trial(0, Some(5.0), Some("joint_spring")),
        trial(1, Some(4.0), Some("torque_ripple")),
        trial(2, Some(0.5), None),
        trial(3, None, None),
        trial(4, None, Some("joint_spring")),
    ];
    let tallied = tally(trials);
    let rates = &tallied.rates;
    assert_eq!((rates.first_right.are, rates.first_right.of), (1, 2));
    assert_eq!((rates.wrong_names.are, rates.wrong_names.of), (1, 2));
    assert_eq!(
        (
            tallied.false_findings.with_finding,
            tallied.false_findings.controls
        ),
        (1, 2)
    );
    assert_eq!(tallied.confusion["joint_spring"]["torque_ripple"], 1);
    // Of two cases one: the p with P(X ≤ 1) = 1 − p² = 0.05.
    approx::assert_relative_eq!(
        tallied.false_findings.upper95,
        0.95_f64.sqrt(),
        epsilon = 1e-9
    );
}

#[test]
fn longer_recordings_judge_what_is_said_to_be_inseparable() {
    let scope = Scope {
        effects: vec!["torque_offset"],
        robots: vec!["arm3"],
        ..Scope::all(5)
    };
    let plan = Plan::draw(&scope, (1, 0));
    let truth = plan.concealed[0].hypothesis.clone();
    let joint = truth.joints[0];
    let other = |id: &str| Stated {
        hypotheses: vec![Hypothesis {
            effect: effect::find(id).unwrap(),
            ..truth.clone()
        }],
        start: Vec::new(),
    };
    let names = vec![plan.robot.name(joint).to_string()];
    let claim = |id: &str| Inseparable {
        effect: id.to_string(),
        joints: names.clone(),
        ..Inseparable::default()
    };
    let rivals = ["asymmetric_friction", "rotor_inertia"];
    let mut found = [Found {
        effect: "torque_offset".to_string(),
        joints: names.clone(),
        inseparable: rivals.map(claim).to_vec(),
        ..Found::default()
    }];
    let doubt = Doubt {
        finding: 0,
        found: other("torque_offset"),
        rivals: rivals.map(other).to_vec(),
    };
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("longer");
    let control = Control::default();
    longer::judge(&plan, (&[doubt], &mut found), (&place, &control)).unwrap();
    let told: Vec<Option<bool>> = found[0].inseparable.iter().map(|c| c.told_apart).collect();
    // An offset is half the difference of Coulomb levels in both directions; an inertia is something else.
    assert_eq!(told, [Some(false), Some(true)]);
}
