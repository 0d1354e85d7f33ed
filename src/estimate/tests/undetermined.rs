//! Unknowns on which the signal does not depend, or no more than on others.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::effect;
use crate::chain::model::{Inertials, Model, ModelSettings, Signal};
use crate::chain::prior::Prior;
use crate::estimate::fit_problem::estimator::Training;
use crate::estimate::fit_problem::problem::FitProblem;
use crate::estimate::fit_problem::unknowns::Unknowns;
use crate::estimate::minimisation::run_away;
use crate::estimate::residual::weights::Weights;
use crate::estimate::tests::{PENDULUM, TRUE_FRICTION, USUAL, pendulum, torque, valued};
use crate::estimate::uncertainty::covariance::of_unknowns;
use crate::recording::split::Split;
use crate::robot::urdf;
use nalgebra::DVector;
use std::path::Path;

/// A recording of a pendulum.
fn recorded() -> Dataset {
    let model = pendulum(&["viscous_friction", "torque_offset"]);
    let torque = torque(&model, &valued(&model, &TRUE_FRICTION));
    Dataset {
        recordings: vec![USUAL.record(&torque, (1, Split::Train))],
    }
}

/// A pendulum whose torque constant may be another.
fn with_gain(inertials: Inertials) -> Model {
    let effects = ["viscous_friction", "torque_offset", "drive_gain"];
    let effects = effects.map(|id| effect::find(id).unwrap());
    let tree = urdf::parse(PENDULUM, Path::new("pendulum.urdf")).unwrap();
    Model::new(ModelSettings {
        inertials,
        torque_constant: Some(vec![2.0]),
        effects: vec![effects.to_vec()],
        ..ModelSettings::bodies(tree, Signal::Current)
    })
    .unwrap()
}

/// A factor of all torques is determined where a body is known, and stays as it is declared where everything may be larger.
#[test]
fn a_factor_of_the_whole_torque_is_no_unknown_unless_something_has_a_size() {
    let data = recorded();
    for (inertials, determined) in [(Inertials::Known, true), (Inertials::Estimate, false)] {
        let model = with_gain(inertials);
        let gain = model.find("hinge.drive_gain.gain").unwrap();
        let prior = Prior::none(model.parameters().len());
        let unknowns = Unknowns::find(&model, &data, &prior);
        assert_eq!(
            unknowns.nonlinear.contains(&gain),
            determined,
            "{inertials:?}"
        );
        assert_eq!(unknowns.positions().contains(&gain), determined);
    }
}

/// A search may carry the size of an excess beyond all limits where its speed is below that of every row: it is left out, and all else
/// stays.
#[test]
fn a_law_that_no_row_shows_is_left_out() {
    let data = recorded();
    let model = pendulum(&["viscous_friction", "coulomb_friction", "stribeck_friction"]);
    let of = |name: &str| model.find(&format!("hinge.{name}")).unwrap();
    let [size, speed] = ["stribeck_friction.Fs", "stribeck_friction.vs"].map(of);
    let prior = Prior::none(model.parameters().len());
    let training: Vec<&Prepared> = data.recordings.iter().collect();
    let unknowns = Unknowns::find(&model, &data, &prior);
    let problem = |unknowns| {
        let training = Training {
            recordings: &training,
            prior: &prior,
        };
        let weights = Weights::PerChannel(DVector::from_element(1, 1.0));
        FitProblem::new(&model, unknowns, training, weights)
    };
    let all = problem(&unknowns);
    let positions = unknowns.positions();
    let place = |p: usize| positions.iter().position(|q| *q == p).unwrap();
    let mut x = all.start();
    x[place(speed)] = 1e-9;
    x[place(size)] = 100.0;
    assert!(run_away::unknowns(&all, &x).is_empty());
    x[place(size)] = -1e12;
    let mut lost = run_away::unknowns(&all, &x);
    lost.sort_unstable();
    let mut expected = [place(size), place(speed)];
    expected.sort_unstable();
    assert_eq!(lost, expected);
    let fewer = unknowns.without(&lost);
    let others = positions.iter().filter(|p| ![size, speed].contains(p));
    assert_eq!(fewer.positions(), others.copied().collect::<Vec<usize>>());
    let without = problem(&fewer);
    let values = without.parameters(&without.start());
    assert_eq!(values[size], 0.0);
}

/// The speed of an excess of friction that is none, or too small to be seen, changes nothing, and is as uncertain as can be; all
/// else is as certain as without it.
#[test]
fn the_shape_of_a_law_without_a_size_has_no_interval() {
    let data = recorded();
    let effects = [
        "viscous_friction",
        "torque_offset",
        "coulomb_friction",
        "stribeck_friction",
    ];
    let model = pendulum(&effects);
    let of = |name: &str| model.find(&format!("hinge.{name}")).unwrap();
    let [size, speed] = ["stribeck_friction.Fs", "stribeck_friction.vs"].map(of);
    let dry = of("coulomb_friction.Fc");
    let prior = Prior::none(model.parameters().len());
    let training: Vec<&Prepared> = data.recordings.iter().collect();
    let variances = |model: &Model, excess: f64| {
        let unknowns = Unknowns::find(model, &data, &prior);
        let weights = Weights::PerChannel(DVector::from_element(1, 1.0));
        let problem = FitProblem::new(
            model,
            &unknowns,
            Training {
                recordings: &training,
                prior: &prior,
            },
            weights,
        );
        let mut x = problem.start();
        let positions = unknowns.positions();
        for (x, p) in x.iter_mut().zip(&positions) {
            match *p {
                p if p == size => *x = excess,
                p if p == dry => *x = 1.0,
                _ => (),
            }
        }
        let covariance = of_unknowns(&problem, &x).unwrap();
        let variances = covariance.diagonal().iter().copied().collect::<Vec<f64>>();
        positions
            .into_iter()
            .zip(variances)
            .collect::<Vec<(usize, f64)>>()
    };
    let variance = |all: &[(usize, f64)], p: usize| all.iter().find(|(q, _)| *q == p).unwrap().1;
    assert!(variance(&variances(&model, 0.5), speed).is_finite());
    let none = variances(&model, 0.0);
    assert_eq!(variance(&none, speed), f64::INFINITY);
    // Nor does one that leaves no trace in a row.
    let traceless = variances(&model, 1e-6);
    assert_eq!(variance(&traceless, speed), f64::INFINITY);
    let mut known = model.clone();
    let value = model.parameters()[speed].value;
    known.fix(speed, value).unwrap();
    for (p, alone) in variances(&known, 0.0) {
        let off = variance(&none, p) / alone - 1.0;
        let name = &model.parameters()[p].name;
        assert!(off.abs() < 1e-9, "{name}: {off:e}");
    }
}
