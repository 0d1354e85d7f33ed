//! The plan of a trial, which follows from the seed and the number of the trial.

use crate::chain::effect::knowledge::JointTerm;
use crate::chain::effect::{Catalogue, Law};
use crate::robot::random::{between, generator, index};
use crate::trials::concealed_effect::{self, Concealed, RecordingLength, Scale};
use crate::trials::motion::{Motion, Noise};
use crate::trials::outside_law::OutsideLaw;
use crate::trials::robot::{KINDS, RandomRobot};
use crate::trials::unmodelled_physics::{Neighbours, Unmodelled, UnmodelledLaw};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;
use std::str::FromStr;

/// One trial of so many conceals nothing.
const CONTROL: u64 = 5;

/// Share of the others with two effects, and with physics outside the vocabulary.
const PAIRS: f64 = 0.12;
const OUTSIDE: f64 = 0.08;

/// Smallest size of one of several effects, as a share of the usual torque of its joint.
const LEAST_OF_SEVERAL: f64 = 0.05;

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
    /// Laws outside the vocabulary are concealed in the place of effects.
    pub outside: bool,
    /// Kinds of robots.
    pub robots: Vec<&'static str>,
    /// Kinds of motions.
    pub motions: Vec<Motion>,
    /// Kinds of noise.
    pub noises: Vec<Noise>,
    /// How many effects a trial conceals; one, now and then two, where nothing is said.
    pub at_once: Option<AtOnce>,
}

/// The least and the largest number of effects that are concealed in one robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AtOnce {
    /// At least one.
    pub least: usize,
    /// Not below the least.
    pub most: usize,
}

impl AtOnce {
    fn draw(self, rng: &mut ChaCha8Rng) -> usize {
        self.least + index(rng, self.most - self.least + 1)
    }
}

impl FromStr for AtOnce {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (least, most) = text.split_once('-').unwrap_or((text, text));
        let [least, most] = [least, most].map(|n| n.trim().parse::<usize>().ok());
        least
            .zip(most)
            .map(|(least, most)| Self { least, most })
            .filter(|counts| counts.least >= 1 && counts.least <= counts.most)
            .ok_or_else(|| format!("`{text}` is no number of effects: write 3 or 3-8"))
    }
}

impl Display for AtOnce {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}-{}", self.least, self.most)
    }
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
            outside: false,
            robots: KINDS.to_vec(),
            motions: Motion::ALL.to_vec(),
            noises: Noise::ALL.to_vec(),
            at_once: None,
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
    /// A law outside the vocabulary that was drawn from a grammar.
    pub law: Option<OutsideLaw>,
    /// Formulas that are proposed are counted.
    pub counts_formulas: bool,
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
            period: [5.0, 6.0, 8.0][index(&mut rng, 3)],
            periods: [3, 3, 4][index(&mut rng, 3)],
        };
        let mut plan = Self {
            number,
            laws: scope.laws.clone(),
            length,
            concealed: Vec::new(),
            outside: None,
            law: None,
            counts_formulas: scope.outside,
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

    /// The joint of what the robot has beyond the vocabulary.
    pub fn outside_joint(&self) -> Option<usize> {
        let drawn = self.law.as_ref().map(|law| law.joint);
        self.outside.map(|outside| outside.at.joint).or(drawn)
    }

    /// Samples of which a row is the average: the periods of a motion that repeats.
    pub fn averaged(&self) -> f64 {
        match self.motion.repeats() {
            true => self.length.periods as f64,
            false => 1.0,
        }
    }

    fn conceal(&mut self, rng: &mut ChaCha8Rng, scope: &Scope, shrink: f64) {
        let n = self.robot.tree.len();
        if scope.outside {
            let joint = index(rng, n);
            let neighbour = (joint + 1 + index(rng, n - 1)) % n;
            let least = SHARES.0;
            let share = Sizes { least, shrink }.draw(rng);
            let at = Neighbours { joint, neighbour };
            self.law = Some(OutsideLaw::draw(rng, &self.robot, at, share));
            return;
        }
        if let Some(counts) = scope.at_once {
            let count = counts.draw(rng);
            let ids: Vec<&'static str> = pick_apart(rng, &scope.effects, count);
            let sizes = Sizes {
                least: LEAST_OF_SEVERAL,
                shrink,
            };
            self.conceal_each(rng, scope, &ids, sizes);
            return;
        }
        let kind = rng.random::<f64>();
        if kind < OUTSIDE && scope.effects.len() > 1 {
            let joint = index(rng, n);
            let neighbour = if joint == 0 { 1 } else { joint - 1 };
            let law = pick(rng, &UnmodelledLaw::ALL);
            let least = SHARES.0;
            self.outside = Some(Unmodelled {
                law,
                at: Neighbours { joint, neighbour },
                share: Sizes { least, shrink }.draw(rng),
            });
            return;
        }
        let pair = kind < OUTSIDE + PAIRS && scope.effects.len() > 1;
        let mut ids: Vec<&'static str> = scope.effects.clone();
        // Singles go through all effects in turn, so that none is rare.
        let turn = (self.number - self.number / CONTROL) as usize % ids.len();
        let mut chosen = vec![ids.remove(turn)];
        if pair {
            chosen.push(pick(rng, &ids));
        }
        let least = if pair { LEAST_OF_SEVERAL } else { SHARES.0 };
        self.conceal_each(rng, scope, &chosen, Sizes { least, shrink });
    }

    /// Conceals effects, each on joints of its own, as long as there are joints.
    fn conceal_each(&mut self, rng: &mut ChaCha8Rng, scope: &Scope, ids: &[&str], sizes: Sizes) {
        let n = self.robot.tree.len();
        let mut joints: Vec<usize> = (0..n).collect();
        for effect in ids.iter().filter_map(|id| scope.catalogue.find(id)) {
            let joint = joints.remove(index(rng, joints.len()));
            let scale = Scale {
                robot: &self.robot,
                length: self.length,
                share: sizes.draw(rng),
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

/// Sizes of what is concealed, as shares of the usual torque of a joint.
#[derive(Clone, Copy)]
struct Sizes {
    least: f64,
    /// By what they are made smaller where a robot could not follow.
    shrink: f64,
}

impl Sizes {
    /// Spread evenly in its logarithm.
    fn draw(self, rng: &mut ChaCha8Rng) -> f64 {
        let (low, high) = (self.least.ln(), SHARES.1.ln());
        self.shrink * between(rng, low, high).exp()
    }
}

/// Some of the values in random order, none twice.
fn pick_apart<T: Copy>(rng: &mut ChaCha8Rng, from: &[T], count: usize) -> Vec<T> {
    let mut left = from.to_vec();
    let mut picked = Vec::new();
    while picked.len() < count && !left.is_empty() {
        picked.push(left.remove(index(rng, left.len())));
    }
    picked
}

fn pick<T: Copy>(rng: &mut ChaCha8Rng, from: &[T]) -> T {
    from[index(rng, from.len())]
}
