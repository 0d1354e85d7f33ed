//! Designed motions: feasible for any robot, worth more than random ones, and as accurate as predicted.

use exid::chain::base_parameters::BaseParameters;
use exid::chain::effect::find;
use exid::chain::evaluate::{Evaluator, Segment};
use exid::chain::model::{Model, ModelSettings, Signal};
use exid::chain::prior::Prior;
use exid::design::constraints::joint_limits::{self, Ends};
use exid::design::criterion::Criterion;
use exid::design::criterion::a_optimal::AOptimal;
use exid::design::criterion::d_optimal::DOptimal;
use exid::design::criterion::parameters_of_interest::{Scale, Target};
use exid::design::information::columns::Columns;
use exid::design::problem::{Excitation, Experiment, Plan};
use exid::design::results::designed::End;
use exid::design::results::expected_deviations::ExpectedEstimate;
use exid::design::search::inter_sample_limits;
use exid::design::search::multistart::{Search, Settings};
use exid::design::search::starts::Starts;
use exid::design::task;
use exid::design::trajectory::fourier_series::Series;
use exid::design::trajectory::motion::{Joints, Motion};
use exid::design::verify;
use exid::problem::linear_rows::LinearRows;
use exid::problem::solution::Control;
use exid::problem_file::ProblemFile;
use exid::robot::batch::Trajectory;
use exid::robot::mdh;
use exid::robot::newton_euler::NewtonEuler;
use exid::robot::random::{generator, symmetric, tree};
use exid::robot::tree::{JointKind, Tree};
use exid::setup::limits::JointLimits;
use nalgebra::{Cholesky, DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::path::Path;
use std::time::Duration;

const EFFECTS: [&str; 2] = ["coulomb_friction", "viscous_friction"];

/// rad/s, where signs of velocities turn.
const WIDTH: f64 = 0.05;

/// A robot with friction in its joints and what a design of it borrows.
struct Robot {
    model: Model,
    base: BaseParameters,
    columns: Columns,
    values: DVector<f64>,
    bounds: Vec<JointLimits>,
    noise: Vec<f64>,
}

impl Robot {
    fn new(tree: Tree, bounds: Vec<JointLimits>, (ids, noise): (&[&str], Vec<f64>)) -> Self {
        let n = tree.len();
        let effects: Vec<_> = ids.iter().map(|id| find(id).unwrap()).collect();
        let mut values = tree.parameters();
        let mut model = Model::new(ModelSettings {
            effects: vec![effects; n],
            ..ModelSettings::bodies(tree, Signal::Torque)
        })
        .unwrap();
        for k in values.len()..model.parameters().len() {
            let parameter = &model.parameters()[k];
            if parameter.name.ends_with(".w") {
                values.push(WIDTH);
                model.fix(k, WIDTH).unwrap();
            } else {
                values.push(parameter.scale);
            }
        }
        let none = DMatrix::zeros(0, values.len());
        let base = BaseParameters::structural(&model, &[false], &none);
        Self {
            columns: Columns::new(&model, base.kept(), &[false], &noise),
            values: DVector::from_vec(values),
            base,
            model,
            bounds,
            noise,
        }
    }

    fn experiment(&self, criterion: &'static dyn Criterion, series: Series) -> Experiment<'_> {
        let n = self.bounds.len();
        let count = self.columns.len();
        let plan = Plan {
            model: &self.model,
            columns: &self.columns,
            values: &self.values,
            loads: &[false],
            joints: Joints {
                series,
                count: n,
                moving: (0..n).collect(),
                harmonics: vec![series.harmonics; n],
                standing: vec![0.0; n],
                trajectories: 1,
                loops: None,
            },
            samples: 200,
            bounds: self.bounds.clone(),
            rules: Vec::new(),
            target: Target {
                criterion,
                wanted: None,
                prior: DMatrix::zeros(count, count),
                scale: Scale::None,
            },
            rivals: None,
        };
        plan.experiment()
    }
}

fn designed(
    experiment: &Experiment<'_>,
    rows: &LinearRows,
    starts: usize,
) -> inter_sample_limits::VerifiedMotion {
    let settings = Settings {
        starts: Some(starts),
        ..Settings::default()
    };
    let search = Search {
        experiment,
        rows,
        settings: &settings,
        shrink: 1.0,
    };
    inter_sample_limits::run(&search, &Control::default(), |_| ()).unwrap()
}

/// Uniform between two numbers.
fn between(rng: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    0.5 * (low + high) + symmetric(rng, 0.5 * (high - low))
}

/// A random robot of 3 to 7 joints with random limits; its motors can hold it where it stands.
fn random_robot(seed: u64) -> Robot {
    let mut rng = generator(seed);
    let n = 3 + (seed % 5) as usize;
    let tree = tree(&mut rng, n);
    let mut bounds: Vec<JointLimits> = tree
        .joints()
        .iter()
        .map(|joint| {
            let size = if joint.kind == JointKind::Revolute {
                1.0
            } else {
                0.2
            };
            JointLimits {
                lower: -size * between(&mut rng, 0.3, 2.8),
                upper: size * between(&mut rng, 0.3, 2.8),
                velocity: size * between(&mut rng, 0.5, 3.0),
                acceleration: size * between(&mut rng, 2.0, 15.0),
                jerk: seed
                    .is_multiple_of(2)
                    .then(|| size * between(&mut rng, 30.0, 200.0)),
                torque: None,
            }
        })
        .collect();
    let mut dynamics = NewtonEuler::new(&tree);
    let (zero, parameters) = (vec![0.0; n], tree.parameters());
    let mut largest = vec![0.0_f64; n];
    for _ in 0..50 {
        let q: Vec<f64> = bounds
            .iter()
            .map(|b| between(&mut rng, b.lower, b.upper))
            .collect();
        let mut torque = vec![0.0; n];
        dynamics.torque(&tree, &parameters, [&q, &zero, &zero], &mut torque);
        largest
            .iter_mut()
            .zip(&torque)
            .for_each(|(m, t)| *m = m.max(t.abs()));
    }
    for (bound, torque) in bounds.iter_mut().zip(&largest) {
        bound.torque = Some(between(&mut rng, 1.1, 2.0) * torque + 2.0);
    }
    Robot::new(tree, bounds, (&EFFECTS, vec![1.0; n]))
}

/// Designs for a random robot and checks all limits on a grid 50 times finer.
fn assert_feasible(seed: u64) {
    let robot = random_robot(seed);
    let series = Series {
        harmonics: 4,
        period: 8.0,
    };
    let experiment = robot.experiment(&DOptimal, series);
    let ends = if seed.is_multiple_of(3) {
        Ends::Free
    } else {
        Ends::AtRest
    };
    let rows = joint_limits::rows(&experiment.joints, &experiment.bounds, ends);
    let inter_sample_limits::VerifiedMotion { found, margins, .. } =
        designed(&experiment, &rows, 1);
    assert!(found.is_feasible(), "robot {seed}: {}", found.infeasibility);
    assert!(found.value.is_finite(), "robot {seed}");
    let violation = verify::violation(&margins);
    assert!(violation <= 1e-3, "robot {seed}: {violation}");
}

#[test]
fn invariant_designs_for_random_robots_keep_every_limit_between_samples() {
    (0..10).for_each(assert_feasible);
}

/// The search takes the torques for five times what they are, and has no time to mend it.
#[test]
fn searches_that_have_no_time_left_give_motions_that_keep_every_limit() {
    let series = Series {
        harmonics: 4,
        period: 8.0,
    };
    let smaller = (0..10).filter(|&seed| {
        let mut robot = random_robot(seed);
        for bound in &mut robot.bounds {
            bound.velocity *= 4.0;
            bound.acceleration *= 10.0;
        }
        let experiment = robot.experiment(&DOptimal, series);
        let rows = joint_limits::rows(&experiment.joints, &experiment.bounds, Ends::Free);
        let settings = Settings {
            budget: Some(Duration::ZERO),
            ..Settings::default()
        };
        let search = Search {
            experiment: &experiment,
            rows: &rows,
            settings: &settings,
            shrink: 5.0,
        };
        let found = inter_sample_limits::run(&search, &Control::default(), |_| ()).unwrap();
        assert!(found.found.is_feasible(), "robot {seed}");
        let violation = found.violation();
        assert!(violation <= 1e-9, "robot {seed}: {violation}");
        found.amplitude_share < 1.0
    });
    assert!(smaller.count() > 0, "all random motions keep the limits");
}

/// `cargo test --release --test excitation -- --ignored`
#[test]
#[ignore = "takes minutes"]
fn invariant_designs_for_a_hundred_random_robots_keep_every_limit_between_samples() {
    (0..100).for_each(assert_feasible);
}

/// The shipped seven-joint arm with its limits.
fn seven_joints(effects: &[&str]) -> Robot {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let tree = mdh::read(&root.join("problems/panda_like/panda_like.mdh.toml")).unwrap();
    let acceleration = [15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0];
    let joints = tree.joints().iter().zip(acceleration);
    let bounds = joints
        .map(|(joint, acceleration)| JointLimits {
            lower: joint.limits.lower.unwrap(),
            upper: joint.limits.upper.unwrap(),
            velocity: joint.limits.velocity.unwrap(),
            acceleration,
            jerk: None,
            torque: joint.limits.effort,
        })
        .collect();
    Robot::new(tree, bounds, (effects, vec![0.5; 7]))
}

const TEN_SECONDS: Series = Series {
    harmonics: 5,
    period: 10.0,
};

/// Median of the largest tenth of the standard deviations.
fn worst_tenth(information: &DMatrix<f64>) -> f64 {
    let size = information.diagonal().map(f64::sqrt);
    let unit = DMatrix::from_fn(size.len(), size.len(), |i, j| {
        information[(i, j)] / (size[i] * size[j])
    });
    let inverse = Cholesky::new(unit).unwrap().inverse();
    let mut deviations: Vec<f64> = (0..size.len())
        .map(|k| inverse[(k, k)].sqrt() / size[k])
        .collect();
    deviations.sort_by(|a, b| b.total_cmp(a));
    deviations.truncate(deviations.len().div_ceil(10));
    median(&mut deviations)
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// A motion whose amplitudes grow about the middle until a limit is active.
fn scaled(
    (x, middle): (&DVector<f64>, &DVector<f64>),
    rows: &LinearRows,
    problem: &Excitation<'_>,
) -> DVector<f64> {
    let step = (x - middle) * 100.0;
    let (mut low, mut high) = (0.0, rows.longest_step(middle, &step));
    let holds = |share: f64| problem.constraints(&(middle + &step * share)).min() >= 0.0;
    if holds(high) {
        low = high;
    }
    while high - low > 1e-9 * high {
        let half = 0.5 * (low + high);
        if holds(half) {
            low = half;
        } else {
            high = half;
        }
    }
    middle + step * low
}

#[test]
fn a_shifted_joint_keeps_its_amplitudes_and_the_others_keep_everything() {
    let robot = seven_joints(&[]);
    let experiment = robot.experiment(&DOptimal, TEN_SECONDS);
    let rows = joint_limits::rows(&experiment.joints, &experiment.bounds, Ends::Free);
    let problem = Excitation::new(&experiment, 1.0, 1.0);
    let starts = Starts::of(&experiment, &problem, &rows);
    let mut rng = generator(5);
    let x = starts.random(&mut rng);
    let shifted = starts.shifted(&x, &mut rng);
    let (harmonics, width) = (TEN_SECONDS.harmonics, TEN_SECONDS.width());
    let own = |x: &DVector<f64>, k: usize| x.rows(k * width, width).into_owned();
    let moved: Vec<usize> = (0..7).filter(|&k| own(&x, k) != own(&shifted, k)).collect();
    let [joint] = moved[..] else {
        panic!("{moved:?}")
    };
    let (before, after) = (own(&x, joint), own(&shifted, joint));
    assert_eq!(before[0], after[0]);
    let amplitude = |x: &DVector<f64>, l: usize| x[l].hypot(x[harmonics + l]);
    for l in 1..=harmonics {
        assert!((amplitude(&before, l) / amplitude(&after, l) - 1.0).abs() < 1e-12);
    }
    // The same motion a part of the period earlier, which the first harmonic tells.
    let angle = |x: &DVector<f64>| x[harmonics + 1].atan2(x[1]);
    let phase = angle(&before) - angle(&after);
    let at = |x: &DVector<f64>, t: f64| -> f64 {
        let functions = TEN_SECONDS.functions(0, t);
        x.iter().zip(&functions).map(|(c, f)| c * f).sum()
    };
    let earlier = phase / std::f64::consts::TAU * TEN_SECONDS.period;
    for t in [0.0, 1.3, 4.9] {
        assert!((at(&after, t) - at(&before, t + earlier)).abs() < 1e-12);
    }
}

/// Normal coefficients of all harmonics alike, about the middle.
fn normal_coefficients(middle: &DVector<f64>, rng: &mut ChaCha8Rng) -> DVector<f64> {
    let width = TEN_SECONDS.width();
    DVector::from_fn(middle.len(), |k, _| match k % width {
        0 => middle[k],
        _ => StandardNormal.sample(rng),
    })
}

/// Of the inertial base parameters: friction comes out of any motion that reaches its speeds. Random motions whose
/// joints have each been fitted to their own limits, as the search's own starts are, come closer.
#[test]
fn invariant_a_designed_motion_beats_random_ones_threefold_in_the_worst_tenth_of_the_parameters() {
    let robot = seven_joints(&[]);
    let experiment = robot.experiment(&AOptimal, TEN_SECONDS);
    let rows = joint_limits::rows(&experiment.joints, &experiment.bounds, Ends::Free);
    let inter_sample_limits::VerifiedMotion { found, .. } = designed(&experiment, &rows, 2);
    let own = worst_tenth(&experiment.information(&found.x));
    let problem = Excitation::new(&experiment, 1.0, 1.0);
    let starts = Starts::of(&experiment, &problem, &rows);
    let middle = starts.middle();
    let over = |draw: &dyn Fn(&mut ChaCha8Rng) -> DVector<f64>| {
        let one = |seed| {
            let x = scaled((&draw(&mut generator(seed)), &middle), &rows, &problem);
            worst_tenth(&experiment.information(&x)) / own
        };
        median(&mut (0..100).map(one).collect::<Vec<f64>>())
    };
    let ratio = over(&|rng| normal_coefficients(&middle, rng));
    let fitted = over(&|rng| starts.random(rng));
    println!(
        "standard deviations of the worst tenth, random over designed: {ratio:.2}; every joint fitted to its own limits \
         first: {fitted:.2}"
    );
    assert!(ratio >= 3.0, "{ratio}");
    assert!(fitted >= 2.5, "{fitted}");
}

/// ExpectedEstimate torques of a motion without noise, from Newton and Euler's equations and the laws of friction.
fn torques(robot: &Robot, motion: &Motion) -> Vec<Vec<f64>> {
    let (tree, n) = (robot.model.tree(), robot.bounds.len());
    let mut dynamics = NewtonEuler::new(tree);
    let parameters = tree.parameters();
    let mut out = vec![Vec::new(); n];
    for k in 0..motion.len() {
        let [q, dq, ddq] =
            [0, 1, 2].map(|o| motion.values[o].iter().map(|s| s[k]).collect::<Vec<f64>>());
        let mut torque = vec![0.0; n];
        dynamics.torque(tree, &parameters, [&q, &dq, &ddq], &mut torque);
        for j in 0..n {
            let of = |name: &str| {
                let name = format!("{}.{name}", tree.joints()[j].name);
                robot.values[robot.model.find(&name).unwrap()]
            };
            let (fc, fv) = (of("coulomb_friction.Fc"), of("viscous_friction.Fv"));
            out[j].push(torque[j] + fc * dq[j] / (dq[j].abs() + WIDTH) + fv * dq[j]);
        }
    }
    out
}

/// The estimator of the base parameters, whitened, as a matrix of parameters by rows.
fn estimator(robot: &Robot, motion: &Motion) -> DMatrix<f64> {
    let (samples, kept) = (motion.len(), robot.base.kept());
    let [q, dq, ddq] = &motion.values;
    let mut evaluator = Evaluator::along(&robot.model, &robot.values, &kept, samples);
    let block = evaluator.evaluate_whole(Segment::states(Trajectory { q, dq, ddq }, false));
    let w = DMatrix::from_fn(robot.noise.len() * samples, kept.len(), |row, k| {
        let (c, s) = (row / samples, row % samples);
        block
            .derivative(c, k)
            .map_or(0.0, |d| d[s] / robot.noise[c])
    });
    w.clone().svd(true, true).pseudo_inverse(0.0).unwrap()
}

/// Mean and standard deviation of the estimates from noisy recordings of a motion.
fn spread(robot: &Robot, motion: &Motion, trials: usize) -> (DVector<f64>, DVector<f64>) {
    let (clean, inverse) = (torques(robot, motion), estimator(robot, motion));
    let whitened = clean.iter().zip(&robot.noise);
    let whitened: Vec<f64> = whitened
        .flat_map(|(series, noise)| series.iter().map(move |t| t / noise))
        .collect();
    let mut rng = generator(1);
    let count = inverse.nrows();
    let (mut sum, mut squares) = (DVector::zeros(count), DVector::zeros(count));
    for _ in 0..trials {
        let noisy = whitened.iter().map(|row| {
            let normal: f64 = StandardNormal.sample(&mut rng);
            row + normal
        });
        let estimate = &inverse * DVector::from_iterator(whitened.len(), noisy);
        squares += estimate.component_mul(&estimate);
        sum += estimate;
    }
    let mean = sum / trials as f64;
    let variance = squares / trials as f64 - mean.component_mul(&mean);
    (mean, variance.map(f64::sqrt))
}

#[test]
fn recovers_known_truth_with_the_spread_that_was_expected() {
    const TRIALS: usize = 200;
    let robot = seven_joints(&EFFECTS);
    let experiment = robot.experiment(&DOptimal, TEN_SECONDS);
    let rows = joint_limits::rows(&experiment.joints, &experiment.bounds, Ends::Free);
    let inter_sample_limits::VerifiedMotion { found, .. } = designed(&experiment, &rows, 1);
    let motion = Motion::of(&experiment.joints, &experiment.basis, &found.x);
    let recorded = ExpectedEstimate {
        model: &robot.model,
        base: &robot.base,
        prior: &Prior::none(robot.values.len()),
        values: &robot.values,
        loads: &[false],
        noise: &robot.noise,
    };
    let expected = recorded.deviations(&motion);
    assert_eq!(expected.len(), robot.base.base.len());
    let (mean, spread) = spread(&robot, &motion, TRIALS);
    let mut ratios = Vec::new();
    for (k, base) in robot.base.base.iter().enumerate() {
        let expected = expected[k].std_dev.unwrap();
        let others = base.others.iter().map(|(p, c)| c * robot.values[*p]);
        let truth = others.sum::<f64>() + robot.values[base.parameter];
        // The mean of many estimates is unbiased: five of its standard deviations.
        let error = (mean[k] - truth).abs();
        assert!(
            error < 5.0 * expected / (TRIALS as f64).sqrt(),
            "parameter {k}: {error}"
        );
        ratios.push(spread[k] / expected);
    }
    // The spread of 200 estimates is known within 5 %, so the largest of 57 lies within 20 %.
    assert!(ratios.iter().all(|r| (0.8..1.2).contains(r)), "{ratios:?}");
    let middle = median(&mut ratios);
    println!("observed over expected standard deviation: median {middle:.3}");
    assert!((middle - 1.0).abs() < 0.05, "{middle}");
}

/// The load of an industrial arm: within the same limits, period, samples and noise as a motion that was chosen
/// by hand and published, every one of the ten parameters comes out better.
#[test]
fn invariant_every_parameter_of_a_load_comes_out_better_than_with_a_published_motion() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = root.join("problems/kr150_excitation/problem.toml");
    let ids: Vec<&str> = exid::chain::effect::EFFECTS.iter().map(|e| e.id).collect();
    let overrides = ["design.starts=1".to_string()];
    let problem = ProblemFile::read(&path, &overrides, &ids).unwrap();
    let designed = task::run(&problem, 0, &Control::default(), |_| ()).unwrap();
    assert_eq!(designed.end, End::Feasible);
    let reference = designed.design.reference.unwrap();
    let of_load = |name: &str| name.starts_with("payload.");
    let mut compared = 0;
    for (own, other) in designed
        .design
        .expected_std_dev
        .iter()
        .zip(&reference.expected_std_dev)
    {
        assert_eq!(own.name, other.name);
        if of_load(&own.name) {
            let ratio = own.std_dev.unwrap() / other.std_dev.unwrap();
            println!("{}: {ratio:.3}", own.name);
            assert!(ratio < 1.0, "{}: {ratio}", own.name);
            compared += 1;
        }
    }
    assert_eq!(compared, 10);
}
