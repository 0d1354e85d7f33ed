//! The seven-joint arm of `problems/panda_friction`, whose truth stands in `hand.toml`: physically possible estimates with
//! nonlinear friction on two ways, a lasso, and the hand as a difference.

use exid::estimate::task::{self, FitRun};
use exid::outcome::parameter::{Parameter, Source};
use exid::problem::solution::Control;
use exid::problem_file::ProblemFile;
use std::path::Path;

fn fit(file: &str, overrides: &[&str]) -> FitRun {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("problems/panda_friction")
        .join(file);
    let overrides: Vec<String> = overrides.iter().map(|o| o.to_string()).collect();
    let problem = ProblemFile::read(&path, &overrides, &exid::chain::effect::ids()).unwrap();
    task::run(&problem, &Control::default(), |_| {}).unwrap()
}

/// The arm alone, with a friction law and settings of the fit.
fn arm(effects: &str, overrides: &[&str]) -> FitRun {
    let effects = format!("drive.effects=[{effects}]");
    let mut all = vec!["fit.compare=[]", effects.as_str()];
    all.extend(overrides);
    fit("problem.toml", &all)
}

const STRIBECK: &str = "\"coulomb_friction\", \"viscous_friction\", \"stribeck_friction\"";
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
