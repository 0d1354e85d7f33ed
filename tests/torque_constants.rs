//! Uncertain torque constants: what they add to intervals is how far the estimate moves where a constant is another.

use std::path::Path;

use exid::chain::effect;
use exid::estimate::task;
use exid::outcome::estimate::Estimate;
use exid::outcome::fit::Fit;
use exid::problem::solution::Control;
use exid::problem_file::ProblemFile;

fn fit(problem: &str, overrides: &[String]) -> (Estimate, Fit) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(problem);
    let problem = ProblemFile::read(&path, overrides, &effect::ids()).unwrap();
    let run = task::run(&problem, &Control::default(), |_| ()).unwrap();
    (run.fitted.estimate, run.fitted.fit)
}

const ARM: &str = "problems/arm6/problem.toml";

/// N·m/A, as the problem has them.
const DECLARED: [f64; 6] = [13.1, 13.0, 12.8, 9.2, 9.1, 9.3];

fn listed(key: &str, values: [f64; 6]) -> String {
    format!("drive.{key}={values:?}")
}

#[test]
fn matches_the_estimate_with_another_constant() {
    // Small enough for first order, large beside what a search leaves.
    const SHARE: f64 = 1e-3;
    const DEVIATION: f64 = 0.04;
    for joint in [1, 4] {
        let mut deviations = [0.0; 6];
        deviations[joint] = DEVIATION;
        let mut constants = DECLARED;
        constants[joint] *= 1.0 + SHARE;
        let (stated, _) = fit(ARM, &[listed("torque_constant_std", deviations)]);
        let (other, _) = fit(ARM, &[listed("torque_constant", constants)]);
        let mut compared = 0;
        for (own, moved) in stated.parameters.iter().zip(&other.parameters) {
            let (Some(std_dev), Some(statistical)) = (own.std_dev, own.std_dev_statistical) else {
                continue;
            };
            let expected = (moved.value.unwrap() - own.value.unwrap()).abs() / SHARE * DEVIATION;
            let added = (std_dev.powi(2) - statistical.powi(2)).max(0.0).sqrt();
            // The weights follow the residuals in the one and not in the other: a few per cent of what noise makes.
            let tolerance = 0.03 * expected + 0.05 * statistical;
            assert!(
                (added - expected).abs() <= tolerance,
                "{}: {added} for {expected}, noise {statistical}",
                own.name
            );
            let half = 1.959_964 * std_dev;
            let [low, high] = own.ci95.unwrap();
            assert!((high - low - 2.0 * half).abs() < 1e-3 * half);
            compared += usize::from(expected > statistical);
        }
        assert!(compared >= 3, "joint {joint}: {compared} parameters moved");
    }
}

#[test]
fn certain_constants_add_nothing() {
    let (plain, _) = fit(ARM, &[]);
    let (zero, _) = fit(ARM, &[listed("torque_constant_std", [0.0; 6])]);
    assert_eq!(plain, zero);
    let apart = |p: &exid::outcome::parameter::Parameter| p.std_dev_statistical.is_some();
    assert!(!plain.parameters.iter().any(apart));
}

/// Polynomials of the current, as the problem has them.
const POLYNOMIALS: [[f64; 4]; 6] = [
    [0.0, 185.0, 0.25, -0.012],
    [0.0, 185.0, 0.25, -0.012],
    [0.0, 150.0, 0.20, -0.012],
    [0.0, 64.0, 0.20, -0.0200],
    [0.0, 60.0, 0.1875, -0.01875],
    [0.0, 40.0, 0.125, -0.0125],
];

#[test]
fn the_mass_of_a_load_moves_with_the_torque_of_the_current() {
    const SHARE: f64 = 1e-3;
    let load = "problems/kr150_payload/problem.toml";
    let mut scaled = POLYNOMIALS;
    scaled[2].iter_mut().for_each(|c| *c *= 1.0 + SHARE);
    let mass = |estimate: &Estimate| {
        let named = |p: &&exid::outcome::parameter::Parameter| p.name == "payload.mass";
        estimate.parameters.iter().find(named).unwrap().clone()
    };
    let deviations = [0.0, 0.0, 0.05, 0.0, 0.0, 0.0];
    let (plain, fit_of_plain) = fit(load, &[]);
    let (other, _) = fit(load, &[format!("drive.current_polynomial={scaled:?}")]);
    let (stated, fit_of_stated) = fit(load, &[listed("torque_constant_std", deviations)]);
    let (plain, other, stated) = (mass(&plain), mass(&other), mass(&stated));
    assert_eq!(plain.std_dev, stated.std_dev_statistical);
    let expected = (other.value.unwrap() - plain.value.unwrap()).abs() / SHARE * 0.05;
    let statistical = plain.std_dev.unwrap();
    let added = (stated.std_dev.unwrap().powi(2) - statistical.powi(2)).sqrt();
    assert!(
        (added - expected).abs() <= 0.03 * expected + 0.05 * statistical,
        "{added} for {expected}, noise {statistical}"
    );
    // Joint 3 lifts arm and load, of which the arm is known: its constant says more than its share of the load.
    assert!(expected > 0.02 * plain.value.unwrap());
    let says = |fit: &Fit| fit.notes.iter().any(|n| n.contains("torque_constant_std"));
    assert!(says(&fit_of_plain) && !says(&fit_of_stated));
}
