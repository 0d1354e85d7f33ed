//! The plan of a trial, which follows from the seed and the number of the trial.

use crate::chain::effect::knowledge::JointTerm;
use crate::chain::effect::{Catalogue, Law};
use crate::robot::random::{between, generator};
use crate::trials::concealed_effect::{self, Concealed, RecordingLength, Scale};
use crate::trials::motion::{Motion, Noise};
use crate::trials::robot::{KINDS, RandomRobot};
use crate::trials::unmodelled_physics::{Neighbours, Unmodelled, UnmodelledLaw};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::path::PathBuf;

/// One trial of so many conceals nothing.
const CONTROL: u64 = 5;

/// Share of the others with two effects, and with physics outside the vocabulary.
const PAIRS: f64 = 0.12;
const OUTSIDE: f64 = 0.08;

/// Smallest and largest size of an effect, as a share of the usual torque of its joint: below the noise, and half.
const SHARES: (f64, f64) = (0.002, 0.5);

/// What the trials are drawn from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Scope {
    /// Seed of the run, from which with its number every trial follows.
    pub seed: u64,
    /// Files and folders of laws beside the vocabulary, by absolute paths, and all effects with them.
    pub laws: Vec<PathBuf>,
    /// The vocabulary with these laws.
    pub catalogue: Catalogue,
    /// Ids of the effects that are concealed.
    pub effects: Vec<&'static str>,
    /// Kinds of robots.
    pub robots: Vec<&'static str>,
    /// Kinds of motions.
    pub motions: Vec<Motion>,
    /// Kinds of noise.
    pub noises: Vec<Noise>,
}

impl Scope {
    /// All effects on all kinds of robots, in all motions and noises.
    pub fn all(seed: u64) -> Self {
        let catalogue = Catalogue::known();
        Self {
            seed,
            laws: Vec::new(),
            effects: concealed_effect::effects(&catalogue)
                .map(|e| e.id)
                .collect(),
            catalogue,
            robots: KINDS.to_vec(),
            motions: Motion::ALL.to_vec(),
            noises: Noise::ALL.to_vec(),
        }
    }

    /// The same in motions that repeat with a declared period, and white noise.
    pub fn periodic(seed: u64) -> Self {
        Self {
            motions: vec![Motion::Fourier],
            noises: vec![Noise::White],
            ..Self::all(seed)
        }
    }
}

/// One trial before it is simulated.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Its number in the run.
    pub number: u64,
    /// Files and folders of laws that its problem names.
    pub laws: Vec<PathBuf>,
    /// The robot with its drives.
    pub robot: RandomRobot,
    /// How long its recordings last.
    pub length: RecordingLength,
    /// What its declared model lacks; nothing in a control.
    pub concealed: Vec<Concealed>,
    /// What the robot has beyond the vocabulary.
    pub outside: Option<Unmodelled>,
    /// Kind of its motion.
    pub motion: Motion,
    /// Kind of its noise.
    pub noise: Noise,
    /// Correlation of the noise of neighbouring samples.
    pub correlation: f64,
    /// The seed of its motion and noise.
    pub simulation: u64,
    /// The link inertials of the robot file are known, not estimated.
    pub known_links: bool,
    /// Rotor inertias are declared.
    pub known_rotors: bool,
}

/// Streams of random numbers that motions and noises are drawn from; those of robots are below.
const APART: u64 = 1 << 63;

/// Hz.
pub const RATE: f64 = 100.0;

impl Plan {
    /// The plan of a trial; another `attempt` draws another one, with smaller effects, where a robot cannot follow.
    pub fn draw(scope: &Scope, number: u64, attempt: u64) -> Self {
        let mut apart = generator(scope.seed);
        apart.set_stream(APART | number);
        let motion = pick(&mut apart, &scope.motions);
        let noise = Noise::draw(&mut apart, &scope.noises);
        let mut rng = generator(scope.seed);
        rng.set_stream((number << 8) | attempt);
        let kind = pick(&mut rng, &scope.robots);
        let robot = RandomRobot::draw(&mut rng, kind);
        let length = RecordingLength {
            period: [5.0, 6.0, 8.0][(rng.random::<f64>() * 3.0) as usize],
            periods: [3, 3, 4][(rng.random::<f64>() * 3.0) as usize],
        };
        let mut plan = Self {
            number,
            laws: scope.laws.clone(),
            length,
            concealed: Vec::new(),
            outside: None,
            motion,
            noise,
            correlation: noise.correlation(&mut apart),
            simulation: apart.random(),
            known_links: rng.random::<f64>() < 0.25,
            known_rotors: true,
            robot,
        };
        if number % CONTROL != CONTROL - 1 {
            let shrink = 0.5_f64.powi(attempt as i32);
            plan.conceal(&mut rng, scope, shrink);
        }
        plan
    }

    fn conceal(&mut self, rng: &mut ChaCha8Rng, scope: &Scope, shrink: f64) {
        let n = self.robot.tree.len();
        let kind = rng.random::<f64>();
        let share = |rng: &mut ChaCha8Rng, low: f64| {
            let (low, high) = (f64::max(SHARES.0, low).ln(), SHARES.1.ln());
            shrink * between(rng, low, high).exp()
        };
        if kind < OUTSIDE && scope.effects.len() > 1 {
            let joint = (rng.random::<f64>() * n as f64) as usize;
            let neighbour = if joint == 0 { 1 } else { joint - 1 };
            let law = pick(rng, &UnmodelledLaw::ALL);
            self.outside = Some(Unmodelled {
                law,
                at: Neighbours { joint, neighbour },
                share: share(rng, SHARES.0),
            });
            return;
        }
        let pair = kind < OUTSIDE + PAIRS && scope.effects.len() > 1;
        let mut joints: Vec<usize> = (0..n).collect();
        let mut ids: Vec<&'static str> = scope.effects.clone();
        // Singles go through all effects in turn, so that none is rare.
        let turn = (self.number - self.number / CONTROL) as usize % ids.len();
        let first = ids.remove(turn);
        let mut chosen = vec![first];
        if pair {
            chosen.push(pick(rng, &ids));
        }
        for effect in chosen.into_iter().filter_map(|id| scope.catalogue.find(id)) {
            let joint = joints.remove((rng.random::<f64>() * joints.len() as f64) as usize);
            let size = share(rng, if pair { 0.05 } else { SHARES.0 });
            let scale = Scale {
                robot: &self.robot,
                length: self.length,
                share: size,
            };
            let drawn = concealed_effect::draw(rng, effect, joint, scale);
            self.known_links |= matches!(effect.law, Law::Body);
            self.known_rotors &= effect.knowledge.term != Some(JointTerm::RotorInertia);
            let taken = drawn.joints();
            joints.retain(|j| !taken.contains(j) || taken.len() == n);
            self.concealed.push(drawn);
            if joints.is_empty() {
                return;
            }
        }
    }
}

fn pick<T: Copy>(rng: &mut ChaCha8Rng, from: &[T]) -> T {
    from[(rng.random::<f64>() * from.len() as f64) as usize]
}
