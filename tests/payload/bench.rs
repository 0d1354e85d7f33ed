//! The shipped arm with recordings made in memory: one period of Table 1 at the rate of the problem file,
//! noise and encoder counts of its `[simulate]` table.

use exid::chain::dataset::Dataset;
use exid::chain::evaluate::{BLOCK, Evaluator, Segment};
use exid::chain::model::Model;
use exid::outcome::parameter::Parameter;
use exid::problem_file::ProblemFile;
use exid::recording::samples::Recording;
use exid::robot::batch::Trajectory;
use exid::robot::random::generator;
use exid::setup;
use exid::setup::model_spec::ModelSpec;
use exid::setup::recording_file::RecordedRobot;
use exid::setup::robot::Robot;
use exid::simulate::truth;
use nalgebra::DVector;
use rand::RngExt;
use rand_distr::StandardNormal;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

pub const SEEDS: u64 = 1000;

/// Periods of a recording.
const PERIODS: usize = 10;

/// Samples of a period: 36.96 s at 24 ms.
const SAMPLES: usize = 1540;

const PERIOD: f64 = 36.96;

/// Per turn.
const COUNTS: f64 = 1_048_576.0;

/// The reported parameters of a load.
pub const NAMES: [&str; 10] = [
    "mass",
    "com_x",
    "com_y",
    "com_z",
    "inertia_xx",
    "inertia_xy",
    "inertia_xz",
    "inertia_yy",
    "inertia_yz",
    "inertia_zz",
];

/// Values of [`NAMES`], with their intervals where they have some.
#[derive(Debug, Clone)]
pub struct Payload {
    pub value: Vec<f64>,
    pub ci95: Vec<Option<[f64; 2]>>,
}

impl Payload {
    pub fn of(parameters: &[Parameter]) -> Self {
        let own = |name: &&str| {
            let wanted = format!("payload.{name}");
            parameters.iter().find(|p| p.name == wanted).unwrap()
        };
        Self {
            value: NAMES.iter().map(|n| own(n).value.unwrap()).collect(),
            ci95: NAMES.iter().map(|n| own(n).ci95).collect(),
        }
    }
}

pub fn problem_path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/kr150_payload/problem.toml")
}

pub fn open(overrides: &[String]) -> ProblemFile {
    ProblemFile::read(&problem_path(), overrides, &exid::chain::effect::ids()).unwrap()
}

pub struct Bench {
    problem: ProblemFile,
    robot: Robot,
    /// The model as a user declares it.
    pub model: Model,
    pub truth: Payload,
    /// One period of the joints that move.
    position: Vec<Vec<f64>>,
    signal: Vec<Vec<f64>>,
    noise: Vec<f64>,
    /// Standard deviation of one angle, rad, beside the counts.
    pub encoder_noise: f64,
}

impl Bench {
    pub fn new(overrides: &[String]) -> Self {
        let mut problem = open(overrides);
        problem.recordings.as_mut().unwrap().validation.clear();
        let robot = setup::robot::open(&problem).unwrap();
        let model = ModelSpec::without_prior(&problem, &robot)
            .unwrap()
            .build()
            .unwrap()
            .model;
        let truth = truth::build(&problem, &robot).unwrap();
        let moving: Vec<usize> = (0..6).filter(|&j| robot.locked[j].is_none()).collect();
        let motion = motion(&moving);
        let noise = problem.simulate.noise.as_ref().unwrap();
        Self {
            signal: signal(&truth.recorded, &motion, &moving),
            truth: Payload::of(&truth.parameters),
            noise: moving
                .iter()
                .map(|&j| noise.value.get(j).unwrap())
                .collect(),
            position: moving
                .iter()
                .map(|&j| joint(&model, &motion[0], j))
                .collect(),
            problem,
            robot,
            model,
            encoder_noise: 0.0,
        }
    }

    /// A recording with noise of its own, as a fit reads it.
    pub fn data(&self, seed: u64) -> Dataset {
        let mut rng = generator(3000 + seed);
        let step = TAU / COUNTS;
        let count = |q: &f64| (q / step).round() * step;
        let repeat = |series: &[f64]| -> Vec<f64> {
            series
                .iter()
                .cycle()
                .take(PERIODS * SAMPLES)
                .copied()
                .collect()
        };
        let mut noisy = |(series, deviation): (&Vec<f64>, &f64)| -> Vec<f64> {
            let mut error = || deviation * rng.sample::<f64, _>(StandardNormal);
            repeat(series).into_iter().map(|s| s + error()).collect()
        };
        let signal: Vec<Vec<f64>> = self
            .signal
            .iter()
            .zip(&self.noise)
            .map(&mut noisy)
            .collect();
        let angles = self
            .position
            .iter()
            .map(|q| noisy((q, &self.encoder_noise)));
        let recording = Recording::of_samples(
            format!("seed {seed}"),
            angles.map(|q| q.iter().map(count).collect()).collect(),
            signal,
        );
        let table = self.problem.recordings().unwrap();
        let named = &setup::recordings::list(table)[0];
        let recorded = RecordedRobot {
            table,
            robot: &self.robot,
            model: &self.model,
        };
        let prepared = setup::recordings::prepare_one(recording, named, recorded).unwrap();
        Dataset {
            recordings: vec![prepared],
        }
    }

    /// Of an average over the periods, by channel; 1 for axes that are locked.
    pub fn deviation_of_means(&self) -> Vec<f64> {
        let mut noise = self.noise.iter();
        let mut own = |locked: bool| match locked {
            true => 1.0,
            false => noise.next().unwrap() / (PERIODS as f64).sqrt(),
        };
        self.robot.locked.iter().map(|l| own(l.is_some())).collect()
    }
}

/// Positions of a joint: `q = V m + offset`.
fn joint(model: &Model, motors: &[Vec<f64>], i: usize) -> Vec<f64> {
    let coupling = model.coupling(&model.values());
    let at = |k: usize| -> f64 {
        let moved = (0..motors.len()).map(|j| coupling[(i, j)] * motors[j][k]);
        moved.sum::<f64>() + model.offset()[i]
    };
    (0..motors[0].len()).map(at).collect()
}

/// Number, sine and cosine of a harmonic.
type Harmonic = (f64, f64, f64);

/// Position, speed and acceleration of all motors over one period: Table 1 for those that move.
fn motion(moving: &[usize]) -> [Vec<Vec<f64>>; 3] {
    let table: [(f64, &[Harmonic]); 4] = [
        (1.57, &[(25.0, 8.72e-2, -4.62e-3)]),
        (0.0, &[(1.0, 1.57, 0.0), (18.0, 4.60e-1, -1.76e-2)]),
        (0.0, &[(1.0, -8.38e-1, 1.78e-3), (19.0, -2.10e-1, 8.52e-3)]),
        (0.0, &[(1.0, 0.0, 1.57), (15.0, 2.56e-2, 0.80)]),
    ];
    let at = |order: usize, j: usize, k: usize| -> f64 {
        if !moving.contains(&j) {
            return 0.0;
        }
        let (offset, terms) = table[j - 2];
        let mut sum = if order == 0 { offset } else { 0.0 };
        for (h, a, b) in terms {
            let w = TAU * h / PERIOD;
            let (s, c) = (w * PERIOD * k as f64 / SAMPLES as f64).sin_cos();
            sum += match order {
                0 => a * s + b * c,
                1 => w * (a * c - b * s),
                _ => -w * w * (a * s + b * c),
            };
        }
        sum
    };
    let series = |order, j| (0..SAMPLES).map(|k| at(order, j, k)).collect();
    [0, 1, 2].map(|order| (0..6).map(|j| series(order, j)).collect())
}

/// Signals of the motors that move, without noise.
fn signal(model: &Model, motion: &[Vec<Vec<f64>>; 3], moving: &[usize]) -> Vec<Vec<f64>> {
    let [q, dq, ddq] = motion;
    let segment = Segment::states(Trajectory { q, dq, ddq }, true);
    let values: DVector<f64> = model.values();
    let mut evaluator = Evaluator::new(model, &values, &[]);
    let mut out = vec![Vec::with_capacity(SAMPLES); moving.len()];
    for start in (0..SAMPLES).step_by(BLOCK) {
        let block = evaluator.evaluate(segment, start..SAMPLES.min(start + BLOCK));
        for (series, &j) in out.iter_mut().zip(moving) {
            series.extend_from_slice(block.value(j));
        }
    }
    out
}
