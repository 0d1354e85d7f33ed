//! Trials of laws outside the vocabulary: what is drawn, the larger motion, and what is counted.

use crate::outcome::diagnose::Unattested;
use crate::outcome::finding::UNNAMED;
use crate::outcome::trials::{Forecast, Hidden, Nameless, Share, Trial};
use crate::problem::solution::Control;
use crate::recording::split::Split;
use crate::trials::files::{AMPLITUDE, prepare, prepare_larger};
use crate::trials::motion::Motion;
use crate::trials::plan::{Plan, Scope};
use crate::trials::reference_fits::DeclaredModel;
use crate::trials::run::run;
use crate::trials::score::most_unexplained;
use crate::trials::tally::tally;

fn scope(motion: Motion) -> Scope {
    Scope {
        outside: true,
        robots: vec!["arm3"],
        motions: vec![motion],
        ..Scope::all(41)
    }
}

/// One law in every trial but one of five, between a small share of the usual torque and half of it; none where effects are
/// concealed.
#[test]
fn laws_take_the_place_of_effects() {
    for number in 0..40 {
        let plan = Plan::draw(&scope(Motion::Fourier), number, 0);
        assert_eq!(plan.law.is_none(), number % 5 == 4);
        assert!(plan.concealed.is_empty() && plan.outside.is_none());
        if let Some(law) = &plan.law {
            assert!(law.size > 0.0 && law.joint < plan.robot.tree.len());
        }
        let usual = Plan::draw(&Scope::all(41), number, 0);
        assert!(usual.law.is_none() && !usual.counts_formulas);
    }
}

/// Names that take a part of a law are withdrawn: an offset where the law bends the other parameters as well, a bump of friction with a
/// spring where the position shapes it otherwise, and a spring in whose place a formula leaves less.
#[test]
fn a_law_that_the_vocabulary_lacks_is_given_no_name() {
    let scope = Scope {
        outside: true,
        ..Scope::all(640837)
    };
    for number in [117, 132, 263] {
        let trial = run(&scope, number, &Control::default());
        assert!(!trial.found.is_empty(), "{number}");
        let named = trial.found.iter().find(|found| found.effect != UNNAMED);
        assert!(named.is_none(), "{number}: {named:?}");
    }
}

/// What is commanded is followed to within hundredths of the range, and has no noise.
#[test]
fn the_larger_motion_has_the_amplitude_that_is_stated() {
    for motion in [Motion::Fourier, Motion::Moves] {
        let plan = Plan::draw(&scope(motion), 1, 0);
        let folder = tempfile::tempdir().unwrap();
        let control = Control::default();
        let made = prepare(&plan, folder.path(), &control).unwrap();
        let problem = prepare_larger(&plan, &made, folder.path(), &control).unwrap();
        let opened = DeclaredModel::read(&problem, &control).unwrap();
        let positions = |split: Split| {
            let mut recordings = opened.data.of(split);
            recordings
                .next()
                .unwrap()
                .experiment
                .motion
                .position
                .clone()
        };
        let (fitted, larger) = (positions(Split::Train), positions(Split::Validation));
        for (joint, (fitted, larger)) in fitted.iter().zip(&larger).enumerate() {
            assert_eq!(fitted.len(), larger.len());
            let about_mean = |series: &[f64]| -> Vec<f64> {
                let mean = series.iter().sum::<f64>() / series.len() as f64;
                series.iter().map(|q| q - mean).collect()
            };
            let (fitted, larger) = (about_mean(fitted), about_mean(larger));
            let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let amplitude = product(&larger, &fitted) / product(&fitted, &fitted);
            assert!(
                (amplitude / AMPLITUDE - 1.0).abs() < 0.03,
                "{joint}: {amplitude}"
            );
        }
    }
}

fn trial(size: Option<f64>, formula: Option<&str>, forecast: [f64; 2]) -> Trial {
    let names = |names: &str| names.split_whitespace().map(str::to_string).collect();
    let joints = vec!["j1".to_string()];
    Trial {
        concealed: size
            .map(|effect_over_noise| Hidden {
                effect: "outside: a product".to_string(),
                joints: joints.clone(),
                effect_over_noise,
            })
            .into_iter()
            .collect(),
        right_joints: size.is_some(),
        nameless: Some(Nameless {
            law: size.map(|_| "size*q*v[j2]".to_string()),
            variables: names("q v[j2]"),
            formula: formula.map(str::to_string),
            formula_variables: formula.map_or_else(Vec::new, names),
            smooth_share: 0.6,
            unexplained: None,
            forecast: size.map(|_| Forecast {
                nothing: 9.0,
                smooth: forecast[0],
                formula: formula.map(|_| forecast[1]),
            }),
        }),
        ..Trial::default()
    }
}

#[test]
fn formulas_are_counted_where_a_smooth_correction_is_not_enough() {
    let larger = [8.0, 3.0];
    let mut lost = trial(Some(4.0), None, larger);
    lost.right_joints = false;
    let unexplained = |joint: &str| {
        let mut trial = lost.clone();
        trial.nameless.as_mut().unwrap().unexplained = Some(joint.to_string());
        trial
    };
    let [stated, elsewhere] = ["j1", "j2"].map(unexplained);
    let trials = vec![
        trial(Some(6.0), Some("v[j2] q"), larger),
        trial(Some(6.0), Some("v[j2]"), [8.0, 5.0]),
        trial(Some(6.0), None, larger),
        // Too small for a formula, and for anything.
        lost,
        stated,
        elsewhere,
        trial(Some(0.5), None, larger),
        // The smooth correction forecasts it, better than a formula once.
        trial(Some(6.0), Some("v[j2] q"), [0.9, 0.1]),
        trial(Some(6.0), Some("v[j2] q"), [0.9, 0.95]),
        trial(None, None, larger),
        trial(None, Some("q"), larger),
    ];
    let tallied = tally(trials);
    let rates = tallied.rates.outside.unwrap();
    let share = |are: usize, of: usize| Share { of, are };
    assert_eq!(rates.located, share(5, 8));
    assert_eq!(rates.located_or_unexplained, share(6, 8));
    assert_eq!(rates.smooth_takes_half, share(8, 8));
    assert_eq!(rates.proposed, share(2, 3));
    assert_eq!(rates.forecasts, share(1, 3));
    assert_eq!(rates.variables_right, share(1, 2));
    assert_eq!(rates.needless, share(2, 4));
    assert_eq!(rates.median_forecast_ratio, Some(5.0 / 8.0));
    assert_eq!(tally(vec![Trial::default()]).rates.outside, None);
}

#[test]
fn most_is_unexplained_where_the_largest_known_share_is_left() {
    let left = |joint: &str, of_signal: f64| Unattested {
        joint: joint.to_string(),
        unit: "A".to_string(),
        rmse_validation: 1.0,
        of_signal,
        sentence: String::new(),
    };
    let all = [
        left("j1", 0.1),
        left("j2", 0.3),
        left("j3", f64::NAN),
        left("j4", 0.2),
    ];
    assert_eq!(most_unexplained(&all).as_deref(), Some("j2"));
    assert_eq!(most_unexplained(&all[2..3]), None);
}
