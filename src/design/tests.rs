//! The parts of a design against the chain they are made from, and gradients against differences.

use nalgebra::{DMatrix, DVector, Isometry3, Point3, Vector3};

use crate::chain::base_parameters::BaseParameters;
use crate::chain::effect::find;
use crate::chain::evaluate::{Evaluator, Segment};
use crate::chain::model::{Model, ModelSettings, Payload, Signal};
use crate::chain::parameter::Role;
use crate::design::constraints::joint_limits::{Ends, rows};
use crate::design::constraints::workspace::{Place, Rule};
use crate::design::criterion::model_discrimination::{Rival, Rivals};
use crate::design::criterion::parameters_of_interest::{Scale, Target};
use crate::design::criterion::{CRITERIA, Criterion};
use crate::design::information::columns::Columns;
use crate::design::problem::{Excitation, Experiment, Plan};
use crate::design::search::starts::Starts;
use crate::design::trajectory::fourier_series::Series;
use crate::design::trajectory::motion::{Joints, Motion, of_motors};
use crate::problem::Problem;
use crate::robot::batch::Trajectory;
use crate::robot::random::{body, generator, symmetric, tree};
use crate::setup::limits::JointLimits;

/// rad/s; wide against the steps of differences.
const WIDTH: f64 = 0.4;

const NOISE: [f64; 3] = [0.5, 0.3, 0.2];
const LOADS: [bool; 2] = [false, true];
const SAMPLES: usize = 33;

/// A random robot of three joints, one motor of which moves two of them, that carries a load.
fn model(effects: &[&str]) -> Model {
    let mut rng = generator(17);
    let robot = tree(&mut rng, 3);
    let effects: Vec<_> = effects.iter().map(|id| find(id).unwrap()).collect();
    let mut coupling = DMatrix::identity(3, 3);
    coupling[(2, 1)] = 0.3;
    let mut model = Model::new(ModelSettings {
        torque_constant: Some(vec![11.0, 7.0, 5.0]),
        coupling: Some(coupling),
        offset: Some(vec![0.0, 0.1, -0.2]),
        effects: vec![effects; 3],
        payload: Some(Payload {
            link: 2,
            frame: Isometry3::new(Vector3::new(0.1, -0.2, 0.3), Vector3::new(0.4, 0.5, -0.6)),
        }),
        ..ModelSettings::bodies(robot, Signal::Current)
    })
    .unwrap();
    let load = body(&mut rng);
    for p in 0..model.parameters().len() {
        let parameter = &model.parameters()[p];
        let value = match parameter.role {
            Role::Inertial { link, quantity } => model.tree().joints()[link].inertia.0[quantity],
            Role::Payload { quantity } => load.0[quantity],
            _ if parameter.name.ends_with(".w") => WIDTH,
            _ => parameter.scale,
        };
        model.start(p, value);
    }
    model
}

fn limits() -> Vec<JointLimits> {
    let one = JointLimits {
        lower: -2.0,
        upper: 1.5,
        velocity: 2.0,
        acceleration: 8.0,
        jerk: Some(200.0),
        torque: Some(150.0),
    };
    vec![one; 3]
}

fn joints(trajectories: usize) -> Joints {
    Joints {
        series: Series {
            harmonics: 4,
            period: 6.0,
        },
        count: 3,
        moving: vec![0, 1, 2],
        harmonics: vec![4, 3, 4],
        standing: vec![0.0; 3],
        trajectories,
        loops: None,
    }
}

fn rules() -> Vec<Rule> {
    let place = Place {
        name: "tip".into(),
        link: Some(2),
        point: Point3::new(0.1, 0.2, 0.3),
    };
    vec![
        Rule::Halfspace {
            label: "half-space".into(),
            place: place.clone(),
            normal: Vector3::z(),
            offset: -3.0,
        },
        Rule::Speed { place, limit: 9.0 },
    ]
}

/// Parts that an experiment borrows.
struct Bench {
    model: Model,
    columns: Columns,
    values: DVector<f64>,
}

impl Bench {
    fn new(effects: &[&str]) -> Self {
        let model = model(effects);
        let none = DMatrix::zeros(0, model.parameters().len());
        let kept = BaseParameters::structural(&model, &LOADS, &none).kept();
        Self {
            columns: Columns::new(&model, kept, &LOADS, &NOISE),
            values: model.values(),
            model,
        }
    }

    fn experiment<'a>(
        &'a self,
        criterion: &'static dyn Criterion,
        rivals: Option<Rivals<'a>>,
    ) -> Experiment<'a> {
        let plan = Plan {
            model: &self.model,
            columns: &self.columns,
            values: &self.values,
            loads: &LOADS,
            joints: joints(2),
            samples: SAMPLES,
            bounds: limits(),
            rules: rules(),
            target: Target {
                criterion,
                wanted: None,
                prior: DMatrix::identity(self.columns.len(), self.columns.len()) * 1e-3,
                scale: Scale::Own,
            },
            rivals,
        };
        plan.experiment()
    }
}

pub(super) fn some_motion(count: usize, seed: u64) -> DVector<f64> {
    let mut rng = generator(seed);
    DVector::from_fn(count, |_, _| symmetric(&mut rng, 0.6))
}

const LAWS: [&str; 3] = ["coulomb_friction", "viscous_friction", "rotor_inertia"];

/// Slopes along a direction by differences whose error is of fourth order: `(8 Δ(h) − Δ(2h)) / 12h`.
fn slope(
    problem: &dyn Problem,
    (x, d): (&DVector<f64>, &DVector<f64>),
    step: f64,
) -> (f64, DVector<f64>) {
    let at = |h: f64| problem.values(&(x + d * h)).unwrap();
    let [a, b, c, e] = [step, -step, 2.0 * step, -2.0 * step].map(at);
    let of = |a: f64, b: f64, c: f64, e: f64| (8.0 * (a - b) - (c - e)) / (12.0 * step);
    let rows = a.constraints.len();
    let constraints = DVector::from_fn(rows, |k, _| {
        let [a, b, c, e] = [&a, &b, &c, &e].map(|v| v.constraints[k]);
        of(a, b, c, e)
    });
    (of(a.cost, b.cost, c.cost, e.cost), constraints)
}

pub(super) fn assert_slopes_of_cost(problem: &dyn Problem, x: &DVector<f64>, name: &str) {
    let exact = problem.linearize(x).unwrap();
    for seed in 0..4 {
        let d = some_motion(x.len(), 100 + seed);
        let (cost, _) = slope(problem, (x, &d), 4e-5);
        // The sign v/(|v| + w) bends at once where v changes sign, so the error is of second order in h; rounding
        // of a condition number is 1e-12 / h.
        let size = exact.gradient.norm() * d.norm();
        let error = (cost - exact.gradient.dot(&d)).abs();
        assert!(error < 1e-6 * size, "{name}: {error} of {size}");
    }
}

pub(super) fn assert_slopes_of_constraints(problem: &dyn Problem, x: &DVector<f64>) {
    let exact = problem.linearize(x).unwrap();
    let d = some_motion(x.len(), 100);
    let (_, rows) = slope(problem, (x, &d), 1e-5);
    let along = &exact.jacobian * &d;
    for k in 0..rows.len() {
        let size = 1.0 + exact.jacobian.row(k).norm() * d.norm();
        let error = (rows[k] - along[k]).abs();
        assert!(error < 1e-6 * size, "row {k}: {error} of {size}");
    }
}

#[test]
fn invariant_slopes_of_constraints_agree_with_differences() {
    let bench = Bench::new(&LAWS);
    let experiment = bench.experiment(CRITERIA[0], None);
    let x = some_motion(experiment.joints.coefficients(), 5);
    assert_slopes_of_constraints(&Excitation::new(&experiment, 1.0, 0.97), &x);
}

#[test]
fn invariant_gradients_of_every_criterion_agree_with_differences() {
    let bench = Bench::new(&LAWS);
    for criterion in CRITERIA {
        let experiment = bench.experiment(*criterion, None);
        let x = some_motion(experiment.joints.coefficients(), 5);
        for exponent in [criterion.exponents()[0], 32.0] {
            let problem = Excitation::new(&experiment, exponent, 0.97);
            assert_slopes_of_cost(&problem, &x, criterion.id());
        }
    }
}

/// W of the chain itself: what an estimate would see.
fn information_of_the_chain(bench: &Bench, motion: &Motion) -> DMatrix<f64> {
    let model = &bench.model;
    let inverse = model.coupling(&bench.values).try_inverse();
    let motors = of_motors(motion, inverse.as_ref(), model.offset());
    let [q, dq, ddq] = &motors.values;
    let parameters = &bench.columns.parameters;
    let mut sum = DMatrix::zeros(parameters.len(), parameters.len());
    for loaded in LOADS {
        let segment = Segment::states(Trajectory { q, dq, ddq }, loaded);
        let mut evaluator = Evaluator::along(model, &bench.values, parameters, motion.len());
        let block = evaluator.evaluate_whole(segment);
        for (c, noise) in NOISE.iter().enumerate() {
            let w = DMatrix::from_fn(motion.len(), parameters.len(), |s, k| {
                block.derivative(c, k).map_or(0.0, |d| d[s] / noise)
            });
            sum += w.tr_mul(&w);
        }
    }
    sum
}

#[test]
fn invariant_information_of_a_design_is_that_of_the_chain() {
    let bench = Bench::new(&LAWS);
    let experiment = bench.experiment(CRITERIA[0], None);
    let x = some_motion(experiment.joints.coefficients(), 8);
    let motion = Motion::of(&experiment.joints, &experiment.basis, &x);
    let found = experiment.information(&x);
    let expected = information_of_the_chain(&bench, &motion);
    // Sums of 400 products, each rounded.
    let size = expected.diagonal().map(f64::sqrt);
    for i in 0..size.len() {
        for j in 0..size.len() {
            let error = (found[(i, j)] - expected[(i, j)]).abs();
            assert!(error < 1e-11 * size[i] * size[j], "{i} {j}: {error}");
        }
    }
}

fn rival(name: &str, effects: &[&str]) -> Rival {
    let model = model(effects);
    let none = DMatrix::zeros(0, model.parameters().len());
    let unknowns = BaseParameters::structural(&model, &LOADS, &none).kept();
    Rival {
        name: name.into(),
        values: model.values(),
        prior: DMatrix::zeros(unknowns.len(), unknowns.len()),
        unknowns,
        model,
    }
}

fn rivals(models: Vec<Rival>) -> Rivals<'static> {
    Rivals {
        models,
        loads: &LOADS,
        noise: &NOISE,
    }
}

#[test]
fn invariant_gradients_of_distances_between_rivals_agree_with_differences() {
    let bench = Bench::new(&LAWS);
    let friction = rival("friction", &["coulomb_friction", "viscous_friction"]);
    let spring = rival("spring", &["coulomb_friction", "joint_spring"]);
    let late = rival(
        "late",
        &["coulomb_friction", "viscous_friction", "time_delay"],
    );
    for models in [vec![friction.clone(), spring], vec![friction, late]] {
        let experiment = bench.experiment(CRITERIA[1], Some(rivals(models)));
        let x = some_motion(experiment.joints.coefficients(), 6);
        let problem = Excitation::new(&experiment, 1.0, 1.0);
        assert_slopes_of_cost(&problem, &x, "discriminate");
    }
}

/// Where one model is the other with a further linear law, what is left after the fit is the part of that
/// law's column that the others do not explain.
#[test]
fn matches_the_information_of_a_further_parameter_where_a_rival_contains_the_other() {
    let small = rival("small", &["coulomb_friction"]);
    let large = rival("large", &["coulomb_friction", "torque_offset"]);
    let (bench, joints) = (
        Bench::new(&["coulomb_friction", "torque_offset"]),
        joints(1),
    );
    let basis = crate::design::trajectory::fourier_series::Basis::new(joints.series, SAMPLES);
    let motion = Motion::of(&joints, &basis, &some_motion(joints.coefficients(), 3));
    let found = rivals(vec![small, large]).value(&motion, &basis);
    let information = information_of_the_chain(&bench, &motion);
    let offsets: Vec<usize> = (0..bench.columns.len())
        .filter(|&k| {
            let name = &bench.model.parameters()[bench.columns.parameters[k]].name;
            name.contains("torque_offset")
        })
        .collect();
    let covariance = information.try_inverse().unwrap();
    let own = covariance
        .select_rows(&offsets)
        .select_columns(&offsets)
        .try_inverse()
        .unwrap();
    let values = DVector::from_iterator(
        offsets.len(),
        offsets
            .iter()
            .map(|&k| bench.values[bench.columns.parameters[k]]),
    );
    // The larger model explains the smaller one, so that direction counts nothing.
    let expected = -(0.5 * values.dot(&(own * &values))).sqrt();
    assert!(
        (found / expected - 1.0).abs() < 1e-6,
        "{found} and {expected}"
    );
}

#[test]
fn invariant_starts_keep_fewer_harmonics_and_rest_at_both_ends() {
    let bench = Bench::new(&LAWS);
    let experiment = bench.experiment(CRITERIA[0], None);
    let rows = rows(&experiment.joints, &experiment.bounds, Ends::AtRest);
    let problem = Excitation::new(&experiment, 1.0, 1.0);
    let starts = Starts::of(&experiment, &problem, &rows);
    for seed in 0..5 {
        let x = starts.random(&mut generator(seed));
        let values = rows.values(&x);
        for (row, value) in rows.rows.iter().zip(&values) {
            if row.is_equation() {
                // Sums of eight products of size 10 at most.
                assert!((value - row.upper).abs() < 1e-12);
            }
        }
        assert!(rows.violation(&x) < 1e-12);
        let second = experiment.joints.first(0, 1);
        assert_eq!(
            (x[second + 4].abs() < 1e-12, x[second + 8].abs() < 1e-12),
            (true, true)
        );
    }
}
