//! A four-jointed arm with friction, its simulated recording and its problem file.

use crate::chain::effect::{EFFECTS, Effect, find};
use crate::chain::evaluate::{BLOCK, Evaluator, Segment};
use crate::chain::model::{Model, ModelSettings, Signal};
use crate::problem_file::ProblemFile;
use crate::robot::batch::Trajectory;
use crate::robot::random::{generator, symmetric};
use crate::robot::urdf;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::ops::Range;
use std::path::Path;

const JOINTS: usize = 4;
pub const RATE_HZ: f64 = 200.0;
const PERIOD_S: f64 = 5.0;
const PERIODS: usize = 5;

/// Amplitude of every harmonic of the motion, rad.
const AMPLITUDE: f64 = 0.35;

/// Half the range of the noise on torques, N·m.
const NOISE: f64 = 0.1;

/// What every joint loses: Fc in N·m, w in rad/s, Fv in N·m·s/rad.
const FRICTION: [f64; 3] = [2.0, 0.005, 3.0];

/// Gravity of an arm that stands upright, m/s².
const UPRIGHT: [f64; 3] = [0.0, 0.0, -9.81];

const URDF: &str = include_str!("arm.urdf");

/// A recording in memory.
#[derive(Clone)]
pub struct Recorded {
    pub t: Vec<f64>,
    pub q: Vec<Vec<f64>>,
    pub dq: Vec<Vec<f64>>,
    pub tau: Vec<Vec<f64>>,
}

impl Recorded {
    pub fn remove(&mut self, samples: Range<usize>) {
        self.t.drain(samples.clone());
        for series in self.q.iter_mut().chain(&mut self.dq).chain(&mut self.tau) {
            series.drain(samples.clone());
        }
    }
}

/// A problem that has not been written yet.
pub struct Problem {
    pub train: Recorded,
    pub urdf: String,
    pub robot_keys: String,
    pub recordings_keys: String,
    pub validation: String,
    /// Effects of all joints, quoted.
    pub effects: &'static str,
    velocity: &'static str,
}

impl Problem {
    /// The recording also has velocities.
    pub fn with_velocity(&mut self) {
        self.velocity = "velocity = \"dq{n}\"\n";
    }

    /// Writes the files of the problem and reads the problem.
    pub fn write(&self, folder: &Path) -> ProblemFile {
        std::fs::write(folder.join("arm.urdf"), &self.urdf).unwrap();
        std::fs::write(folder.join("train.csv"), self.csv()).unwrap();
        let text = format!(
            "[robot]\nurdf = \"arm.urdf\"\n{}[drive]\neffects = [{}]\n[recordings]\nsignal = \"torque\"\ntrain = [\"train.csv\"]\n{}{}\
             [recordings.columns]\ntime = \"t\"\nposition = \"q{{n}}\"\ntorque = \"tau{{n}}\"\n{}",
            self.robot_keys, self.effects, self.recordings_keys, self.validation, self.velocity
        );
        let ids: Vec<&str> = EFFECTS.iter().map(|e| e.id).collect();
        ProblemFile::parse(&folder.join("problem.toml"), &text, &[], &ids).unwrap()
    }

    fn csv(&self) -> String {
        let mut text = String::from("t");
        for name in ["q", "dq", "tau"] {
            (1..=JOINTS).for_each(|n| write!(text, ",{name}{n}").unwrap());
        }
        for k in 0..self.train.t.len() {
            write!(text, "\n{}", self.train.t[k]).unwrap();
            let series = self
                .train
                .q
                .iter()
                .chain(&self.train.dq)
                .chain(&self.train.tau);
            series.for_each(|s| write!(text, ",{}", s[k]).unwrap());
        }
        text
    }
}

/// The arm with a recording of it.
pub struct Arm {
    recorded: Recorded,
}

impl Arm {
    pub fn new() -> Self {
        Self::simulated([1.0; JOINTS], UPRIGHT)
    }

    /// With gravity along another direction.
    pub fn under(gravity: [f64; 3]) -> Self {
        Self::simulated([1.0; JOINTS], gravity)
    }

    /// With one joint at rest.
    pub fn standing(joint: usize) -> Self {
        let mut sizes = [1.0; JOINTS];
        sizes[joint] = 0.0;
        Self::simulated(sizes, UPRIGHT)
    }

    pub fn problem(&self) -> Problem {
        Problem {
            train: self.recorded.clone(),
            urdf: URDF.to_string(),
            robot_keys: String::new(),
            recordings_keys: format!("period = {PERIOD_S}\n"),
            validation: String::new(),
            effects: "\"coulomb_friction\", \"viscous_friction\"",
            velocity: "",
        }
    }

    fn simulated(sizes: [f64; JOINTS], gravity: [f64; 3]) -> Self {
        let samples = (PERIODS as f64 * PERIOD_S * RATE_HZ).round() as usize;
        let t: Vec<f64> = (0..samples).map(|k| k as f64 / RATE_HZ).collect();
        let mut rng = generator(17);
        let phases: Vec<Vec<f64>> = (0..JOINTS)
            .map(|_| (0..5).map(|_| symmetric(&mut rng, TAU / 2.0)).collect())
            .collect();
        // The k-th derivative of a sine of rate w is w^k times the sine a quarter turn later.
        let series = |j: usize, order: usize| -> Vec<f64> {
            let at = |t: &f64| -> f64 {
                let term = |(h, phase): (usize, &f64)| {
                    let w = TAU * (h + 1) as f64 / PERIOD_S;
                    let angle = w * t + phase + 0.25 * TAU * order as f64;
                    w.powi(order as i32) * angle.sin() / (h + 1) as f64
                };
                let sum: f64 = phases[j].iter().enumerate().map(term).sum();
                let rest = if order == 0 { 0.3 } else { 0.0 };
                sizes[j] * AMPLITUDE * sum + rest
            };
            t.iter().map(at).collect()
        };
        let motion = [0, 1, 2].map(|order| (0..JOINTS).map(|j| series(j, order)).collect());
        let tau = torques(&model(gravity), &motion, &mut rng);
        let [mut q, dq, _]: [Vec<Vec<f64>>; 3] = motion;
        // An encoder of 2^19 counts to the turn.
        let count = TAU / 524_288.0;
        q.iter_mut()
            .flatten()
            .for_each(|q| *q = (*q / count).round() * count);
        Self {
            recorded: Recorded { t, q, dq, tau },
        }
    }
}

fn torques(
    model: &Model,
    [q, dq, ddq]: &[Vec<Vec<f64>>; 3],
    rng: &mut rand_chacha::ChaCha8Rng,
) -> Vec<Vec<f64>> {
    let mut values = model.values();
    for (p, value) in model.tree().parameters().into_iter().enumerate() {
        values[p] = value;
    }
    for joint in model.joints() {
        let mut numbers = FRICTION.iter();
        for (effect, first) in &joint.effects {
            for k in 0..effect.parameters.len() {
                values[first + k] = *numbers.next().unwrap();
            }
        }
    }
    let samples = q[0].len();
    let mut tau = vec![Vec::new(); JOINTS];
    let mut evaluator = Evaluator::new(model, &values, &[]);
    let segment = Segment::states(Trajectory { q, dq, ddq }, false);
    for start in (0..samples).step_by(BLOCK) {
        let block = evaluator.evaluate(segment, start..samples.min(start + BLOCK));
        for (c, series) in tau.iter_mut().enumerate() {
            series.extend(block.value(c).iter().map(|x| x + symmetric(rng, NOISE)));
        }
    }
    tau
}

fn model(gravity: [f64; 3]) -> Model {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm.urdf");
    std::fs::write(&path, URDF).unwrap();
    let effects: Vec<&'static Effect> = ["coulomb_friction", "viscous_friction"]
        .iter()
        .filter_map(|id| find(id))
        .collect();
    let tree = urdf::read(&path).unwrap().with_gravity(gravity);
    Model::new(ModelSettings {
        effects: vec![effects; JOINTS],
        ..ModelSettings::bodies(tree, Signal::Torque)
    })
    .unwrap()
}
