//! The seven-joint arm of `problems/panda_friction`, whose truth stands in `hand.toml`: physically possible estimates with
//! nonlinear friction on two ways, a lasso, and the hand as a difference.

use exid::estimate::task::{self, FitRun};
use exid::outcome::parameter::{Parameter, Source};
use exid::problem::solution::Control;
use exid::problem_file::ProblemFile;
use exid::simulate::{self, write_csv};
use std::fs::File;
use std::path::Path;

fn read(file: &str, overrides: &[&str]) -> ProblemFile {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("problems/panda_friction")
        .join(file);
    let overrides: Vec<String> = overrides.iter().map(|o| o.to_string()).collect();
    ProblemFile::read(&path, &overrides, &exid::chain::effect::ids()).unwrap()
}

fn fit(file: &str, overrides: &[&str]) -> FitRun {
    task::run(&read(file, overrides), &Control::default(), |_| {}).unwrap()
}

/// The arm alone, with a friction law and settings of the fit.
fn arm(effects: &str, overrides: &[&str]) -> FitRun {
    let effects = format!("drive.effects=[{effects}]");
    let mut all = vec!["fit.compare=[]", effects.as_str()];
    all.extend(overrides);
    fit("problem.toml", &all)
}

const STRIBECK: &str = "\"coulomb_friction\", \"viscous_friction\", \"stribeck_friction\"";
const LUGRE: &str = "\"coulomb_friction\", \"viscous_friction\", \"presliding_hysteresis\"";
const SIGMOID: &str = "\"sigmoid_friction\", \"viscous_friction\"";

/// Largest difference of two estimates over their combinations, in standard deviations of the first.
fn distance(first: &FitRun, second: &FitRun) -> f64 {
    let (a, b) = (&first.fitted.fit.posterior, &second.fitted.fit.posterior);
    assert_eq!(a.combinations.len(), b.combinations.len());
    let pairs = a.combinations.iter().zip(&b.combinations).enumerate();
    let of = |(k, (x, y)): (usize, (&_, &exid::outcome::fit::Combination))| {
        let x: &exid::outcome::fit::Combination = x;
        assert_eq!(x.terms, y.terms);
        (x.value - y.value).abs() / a.covariance[k][k].sqrt()
    };
    pairs.map(of).filter(|d| d.is_finite()).fold(0.0, f64::max)
}

#[test]
fn cones_and_chart_agree_with_stribeck_and_with_sigmoid_friction() {
    let estimator = "fit.estimator=\"feasible_maximum_likelihood\"";
    for (effects, inside) in [(STRIBECK, true), (SIGMOID, false)] {
        let cones = arm(effects, &[estimator]);
        let chart = arm(effects, &[estimator, "fit.feasible_by=\"log_cholesky\""]);
        for run in [&cones, &chart] {
            let found = run.fitted.fit.feasibility.as_ref().unwrap();
            assert!(found.least_eigenvalue >= found.margin * (1.0 - 1e-6));
        }
        let converged = |run: &FitRun| run.fitted.estimate.solver.as_ref().unwrap().converged;
        // At the edge of what bodies can be the chart has no optimum, only a way towards it.
        assert!(converged(&cones) && (converged(&chart) || !inside));
        let [by_cones, by_chart] =
            [&cones, &chart].map(|r| r.fitted.fit.feasibility.as_ref().unwrap().cost);
        let apart = distance(&cones, &chart);
        eprintln!("{effects}: {apart:.1e} standard deviations, costs {by_cones} and {by_chart}");
        // Weights are iterated until they change by a thousandth, which moves an estimate by less than that.
        assert!(apart < 2e-2, "{apart}");
        assert!((by_cones / by_chart - 1.0).abs() < 2e-3);
    }
}

#[test]
fn a_lasso_takes_parameters_to_zero_and_says_how_strong_it_is() {
    let lasso = "fit.prior.kind=\"lasso\"";
    let settings = ["fit.estimator=\"feasible\"", lasso];
    let w = (1..=7).map(|j| format!("\"joint{j}.coulomb_friction.w\"=0.01"));
    let known = format!("drive.values={{{}}}", w.collect::<Vec<_>>().join(","));
    let run = arm(STRIBECK_LINEAR, &[settings[0], settings[1], &known]);
    let feasibility = run.fitted.fit.feasibility.as_ref().unwrap();
    let prior = feasibility.prior.as_ref().unwrap();
    assert_eq!(prior.kind, "lasso");
    assert_eq!(prior.chosen_by, "held_out");
    let least = prior
        .path
        .iter()
        .map(|p| p.error)
        .fold(f64::INFINITY, f64::min);
    let chosen = prior.path.iter().find(|p| p.strength == prior.strength);
    assert_eq!(chosen.unwrap().error, least);
    // The path is one: too strong a penalty predicts worse.
    assert!(prior.path.last().unwrap().error > 2.0 * least);
    let notes = run.fitted.fit.notes.join(" ");
    assert!(
        notes.contains("lasso") && notes.contains("to zero"),
        "{notes}"
    );
    let zeros = |strength: &str| {
        let strength = format!("fit.prior.strength={strength}");
        let run = arm(
            STRIBECK_LINEAR,
            &[settings[0], settings[1], &known, &strength],
        );
        let small = |r: &&exid::outcome::fit::Realized| r.value.abs() < 1e-6;
        let body = &run.fitted.fit.realization;
        let absolute: f64 = body.iter().map(|r| r.value.abs()).sum();
        (body.iter().filter(small).count(), absolute)
    };
    let (few, large) = zeros("1e-3");
    let (many, small) = zeros("1e3");
    eprintln!("zeros {few} and {many}, sums of sizes {large:.2} and {small:.2}");
    assert!(many > few && small < large);
}

const STRIBECK_LINEAR: &str = "\"coulomb_friction\", \"viscous_friction\"";

/// Bristles of a joint with this Coulomb friction, N·m, and its viscous friction, N·m·s/rad.
fn bristles(dry: f64, viscous: f64) -> [(&'static str, f64); 6] {
    [
        ("viscous_friction.Fv", viscous),
        ("coulomb_friction.Fc", dry),
        ("presliding_hysteresis.sigma0", 100.0 * dry),
        ("presliding_hysteresis.sigma1", dry),
        ("presliding_hysteresis.Fs", 0.3 * dry),
        ("presliding_hysteresis.vs", 0.1),
    ]
}

/// A joint's excess of friction at low speed with the opposite sign and a scale of speed ten times as large looks like
/// its viscous friction; searches end there unless they begin near the truth.
#[test]
fn bristles_come_back_as_they_are_and_not_as_viscous_friction() {
    let joints = [1.5, 1.5, 1.2, 1.2, 0.8, 0.6, 0.5]
        .into_iter()
        .zip([2.5, 2.5, 2.0, 2.0, 0.9, 0.8, 0.6]);
    let truth: Vec<(String, f64)> = (1..)
        .zip(joints)
        .flat_map(|(j, (dry, viscous))| {
            bristles(dry, viscous).map(|(name, x)| (format!("joint{j}.{name}"), x))
        })
        .collect();
    let values = truth.iter().map(|(name, x)| format!("{name:?}={x}"));
    let effects = format!("drive.effects=[{LUGRE}]");
    let simulated = read(
        "problem.toml",
        &[
            &effects,
            "simulate.trajectory=\"random\"",
            "simulate.periods=3",
            "simulate.noise=[0.1,0.1,0.1,0.1,0.04,0.04,0.04]",
            &format!(
                "simulate.values={{{}}}",
                values.collect::<Vec<_>>().join(",")
            ),
        ],
    );
    let folder = tempfile::tempdir().unwrap();
    let (mut held, mut all) = (0, 0);
    for seed in [2003, 2006, 2009] {
        let made = simulate::run(&simulated, seed, &Control::default()).unwrap();
        let path = folder.path().join(&made.recordings[0].name);
        write_csv(File::create(&path).unwrap(), &made.recordings[0]).unwrap();
        let train = format!("recordings.train=[{:?}]", path.display().to_string());
        let run = arm(LUGRE, &[&train, "recordings.validation=[]"]);
        for (name, value) in &truth {
            let found = run
                .fitted
                .estimate
                .parameters
                .iter()
                .find(|p| p.name == *name);
            let [low, high] = found.unwrap().ci95.unwrap_or([f64::NAN; 2]);
            all += 1;
            held += usize::from((low..=high).contains(value));
        }
    }
    eprintln!("{held} of {all} intervals of 95 % hold the truth");
    // Less than this by chance: once in fifty thousand times.
    assert!(held * 100 >= all * 85, "{held} of {all}");
}

/// Truth of the hand: `problems/panda_friction/hand.toml`.
const HAND: [(&str, f64); 10] = [
    ("mass", 0.73),
    ("com_x", -0.01),
    ("com_y", 0.0),
    ("com_z", 0.137),
    ("inertia_xx", 0.0010),
    ("inertia_xy", 0.0),
    ("inertia_xz", 0.0),
    ("inertia_yy", 0.0025),
    ("inertia_yz", 0.0),
    ("inertia_zz", 0.0017),
];

fn hand(run: &FitRun, name: &str) -> Parameter {
    let wanted = format!("payload.{name}");
    let mut all = run.fitted.estimate.parameters.iter();
    all.rfind(|p| p.name == wanted).unwrap().clone()
}

#[test]
fn recovers_known_truth_of_a_hand_as_a_difference() {
    let difference = fit("hand.toml", &[]);
    let together = fit("hand.toml", &["fit.load=\"together\""]);
    for (name, truth) in HAND {
        let [of_two, of_one] = [&difference, &together].map(|run| hand(run, name));
        assert_eq!(of_two.source, Source::Data);
        let (value, sd) = (of_two.value.unwrap(), of_two.std_dev.unwrap());
        let (other, other_sd) = (of_one.value.unwrap(), of_one.std_dev.unwrap());
        eprintln!(
            "{name}: {value:.5} ± {sd:.5}, together {other:.5} ± {other_sd:.5}, truth {truth}"
        );
        assert!(
            (value - truth).abs() < 3.5 * sd,
            "{name}: {value} ± {sd}, truth {truth}"
        );
        // Both use the same recordings: the difference cannot be much better, and is not much worse.
        assert!(
            sd > 0.7 * other_sd && sd < 2.0 * other_sd,
            "{name}: {sd}, {other_sd}"
        );
    }
    let notes = difference.fitted.fit.notes.join(" ");
    assert!(notes.contains("difference of two fits"), "{notes}");
}
