//! What is concealed in a trial: an effect of the vocabulary on a joint, with values of physical size.
//!
//! Sizes are a share `f` of the torque that the joint usually bears, so that all effects are swept over the same
//! range; what the declared model cannot absorb of them is measured, not assumed.

use crate::chain::effect::{
    Catalogue, EFFECTS, Effect, Memory, coulomb_friction, viscous_friction,
};
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::robot::random::between;
use crate::trials::robot::RandomRobot;
use crate::trials::stated;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{PI, TAU};

/// An effect that acts and is not declared.
#[derive(Debug, Clone, PartialEq)]
pub struct Concealed {
    /// The hypothesis that is the truth.
    pub hypothesis: Hypothesis,
    /// Parameters by their names in `[simulate.values]`.
    pub values: Vec<(String, f64)>,
}

impl Concealed {
    /// Joints that a finding has to name.
    pub fn joints(&self) -> Vec<usize> {
        self.hypothesis.named_joints()
    }

    /// Whether it changes from period to period, which averages hide.
    pub fn changes_with_time(&self) -> bool {
        self.hypothesis.effect.needs.memory == Memory::Time
    }
}

/// The effects that can be concealed: all of the vocabulary that are looked for unasked but those that are declared, and of others those whose size can be
/// told from their formula.
pub fn effects(catalogue: &Catalogue) -> impl Iterator<Item = &'static Effect> {
    let declared = [coulomb_friction::EFFECT.id, viscous_friction::EFFECT.id];
    let all = catalogue.effects().iter().copied();
    all.filter(move |e| match is_of_vocabulary(e) {
        true => !declared.contains(&e.id) && e.law.is_sought(),
        false => stated::has_size(e),
    })
}

fn is_of_vocabulary(effect: &Effect) -> bool {
    EFFECTS.iter().any(|known| known.id == effect.id)
}

/// How long a recording lasts: so many periods, or as long where the motion does not repeat.
#[derive(Debug, Clone, Copy)]
pub struct Course {
    /// s.
    pub period: f64,
    pub periods: usize,
}

impl Course {
    fn duration(self) -> f64 {
        self.period * self.periods as f64
    }
}

/// A joint with the figures that sizes are shares of.
struct Site<'a> {
    robot: &'a RandomRobot,
    joint: usize,
    course: Course,
    /// Size of the effect as a share of the usual torque.
    share: f64,
}

/// Draws an effect of size `share` on a joint.
pub fn draw(
    rng: &mut ChaCha8Rng,
    (effect, joint): (&'static Effect, usize),
    (robot, course, share): (&RandomRobot, Course, f64),
) -> Concealed {
    let site = Site {
        robot,
        joint,
        course,
        share,
    };
    let (joints, other, values) = match effect.id {
        "base_tilt" => site.tilt(rng),
        "time_delay" if rng.random::<f64>() < 0.7 => site.common_delay(),
        "kinematic_coupling" => site.coupling(rng),
        "unmodelled_payload" => site.load(rng),
        id if !is_of_vocabulary(effect) => {
            let (middle, half_range) = robot.range(joint);
            let course = stated::Course {
                middle,
                half_range,
                fastest: robot.speed(joint),
            };
            let values = stated::values(rng, effect, course, site.torque());
            (vec![joint], None, site.own(id, values))
        }
        id => (vec![joint], None, site.own(id, site.values(rng, id))),
    };
    let hypothesis = Hypothesis {
        effect,
        joints,
        other,
    };
    Concealed { hypothesis, values }
}

/// Joints of an effect, the other motor of a coupling, and the values by name.
type Sited = (Vec<usize>, Option<usize>, Vec<(String, f64)>);

fn named(prefix: &str, values: Vec<(&str, f64)>) -> Vec<(String, f64)> {
    let full = |(name, value): (&str, f64)| (format!("{prefix}.{name}"), value);
    values.into_iter().map(full).collect()
}

fn sign(rng: &mut ChaCha8Rng) -> f64 {
    if rng.random::<bool>() { 1.0 } else { -1.0 }
}

impl Site<'_> {
    fn all(&self) -> Vec<usize> {
        (0..self.robot.tree.len()).collect()
    }

    /// Values of an effect of the joint by their full names.
    fn own(&self, effect: &str, values: Vec<(&str, f64)>) -> Vec<(String, f64)> {
        named(&format!("{}.{effect}", self.robot.name(self.joint)), values)
    }

    fn tilt(&self, rng: &mut ChaCha8Rng) -> Sited {
        let mut angle = || 0.2 * self.share * sign(rng);
        let angles = vec![("roll", angle()), ("pitch", angle())];
        (self.all(), None, named("base_tilt", angles))
    }

    /// One cable or one clock carries the channels of all joints.
    fn common_delay(&self) -> Sited {
        let of = |&j: &usize| {
            let name = format!("{}.time_delay.delay", self.robot.name(j));
            (name, 0.05 * self.share)
        };
        let values = self.all().iter().map(of).collect();
        (self.all(), None, values)
    }

    fn coupling(&self, rng: &mut ChaCha8Rng) -> Sited {
        let other = if self.joint == 0 { 1 } else { self.joint - 1 };
        let entry = vec![(self.robot.name(other), self.share * sign(rng))];
        let values = self.own("kinematic_coupling", entry);
        (vec![self.joint], Some(other), values)
    }

    /// N·m (N) of the effect.
    fn torque(&self) -> f64 {
        self.share * self.robot.torque[self.joint]
    }

    fn values(&self, rng: &mut ChaCha8Rng, effect: &str) -> Vec<(&'static str, f64)> {
        match effect {
            "asymmetric_friction"
            | "stribeck_friction"
            | "viscous_nonlinearity"
            | "sigmoid_friction"
            | "presliding_hysteresis"
            | "position_dependent_friction" => self.friction(rng, effect),
            "joint_elasticity" | "backlash" | "joint_spring" | "torque_ripple" => {
                self.of_position(rng, effect)
            }
            _ => self.of_drive(rng, effect),
        }
    }

    fn friction(&self, rng: &mut ChaCha8Rng, effect: &str) -> Vec<(&'static str, f64)> {
        let (torque, fastest) = (self.torque(), self.robot.speed(self.joint));
        let (middle, half_range) = self.robot.range(self.joint);
        match effect {
            "asymmetric_friction" => vec![
                ("dFc", torque * sign(rng)),
                ("dFv", between(rng, -1.0, 1.0) * torque / fastest),
            ],
            "stribeck_friction" => {
                vec![("Fs", torque), ("vs", between(rng, 0.02, 0.15) * fastest)]
            }
            "viscous_nonlinearity" => {
                let power = match rng.random::<bool>() {
                    true => between(rng, 1.6, 3.0),
                    false => between(rng, 0.3, 0.6),
                };
                vec![("Fn", torque / (0.5 * fastest).powf(power)), ("p", power)]
            }
            "sigmoid_friction" => vec![
                ("psi1", 2.0 * torque),
                ("psi2", between(rng, 5.0, 40.0) / fastest),
                ("psi3", between(rng, -0.2, 0.2) * fastest),
            ],
            "presliding_hysteresis" => {
                let dry = self.robot.friction[self.joint][0];
                let stiffness = dry / (between(rng, 0.05, 0.5) * self.share * half_range);
                vec![
                    ("sigma0", stiffness),
                    ("sigma1", 0.002 * stiffness),
                    ("Fs", between(rng, 0.1, 0.5) * dry),
                    ("vs", between(rng, 0.02, 0.15) * fastest),
                ]
            }
            _ => vec![
                ("dF", torque),
                ("q0", middle + between(rng, -0.4, 0.4) * half_range),
                ("width", between(rng, 0.15, 0.4) * half_range),
            ],
        }
    }

    fn of_position(&self, rng: &mut ChaCha8Rng, effect: &str) -> Vec<(&'static str, f64)> {
        let (middle, half_range) = self.robot.range(self.joint);
        let inertia = self.robot.mass[self.joint];
        match effect {
            "joint_elasticity" => {
                // Links of robots swing above 8 Hz.
                let softest = inertia * (TAU * 8.0).powi(2);
                let bend = 0.02 * self.share * half_range;
                let stiffness = (self.robot.torque[self.joint] / bend).max(softest);
                let damping = 0.2 * (stiffness * inertia).sqrt();
                vec![("K", stiffness), ("D", damping)]
            }
            "backlash" => vec![("gap", 0.02 * self.share * half_range)],
            "joint_spring" => vec![
                ("k", self.torque() / half_range),
                ("q0", middle + between(rng, -1.0, 1.0) * half_range),
            ],
            _ => {
                let cycles = between(rng, 1.5, 20.0);
                vec![
                    ("order", PI * cycles / half_range),
                    ("amplitude", self.torque()),
                    ("phase", between(rng, -PI, PI)),
                    ("amplitude2", between(rng, 0.0, 0.5) * self.torque()),
                    ("phase2", between(rng, -PI, PI)),
                ]
            }
        }
    }

    fn of_drive(&self, rng: &mut ChaCha8Rng, effect: &str) -> Vec<(&'static str, f64)> {
        let constant = self.robot.torque_constant[self.joint];
        let duration = self.course.duration();
        match effect {
            "transmission_efficiency" => vec![("R", 1.0 - self.share)],
            "load_dependent_friction" => vec![("mu", self.share)],
            "torque_current_nonlinearity" => {
                // Torque grows with the current up to five times the usual one.
                let largest = 5.0 * self.robot.torque[self.joint] / constant;
                let bend = self.share * constant / (3.0 * largest.powi(2));
                vec![("c0", 0.0), ("c1", constant), ("c2", 0.0), ("c3", -bend)]
            }
            "drive_gain" => vec![("gain", 1.0 + self.share * sign(rng))],
            "torque_offset" => vec![("offset", self.torque() * sign(rng))],
            "rotor_inertia" => {
                vec![("Jm", self.share * self.robot.mass[self.joint])]
            }
            "thermal_drift" => vec![
                ("gain", -(2.0 * self.share).min(0.8)),
                ("time_constant", between(rng, 0.2, 0.8) * duration),
            ],
            "external_contact" => {
                let from = between(rng, 0.1, 0.7) * duration;
                vec![
                    ("torque", self.torque() * sign(rng)),
                    ("from", from),
                    ("to", from + between(rng, 0.04, 0.2) * duration),
                ]
            }
            _ => vec![("delay", 0.05 * self.share)],
        }
    }

    /// A load on the last link.
    fn load(&self, rng: &mut ChaCha8Rng) -> Sited {
        let last = Site {
            joint: self.robot.tree.len() - 1,
            ..*self
        };
        let link = &self.robot.tree.joints()[last.joint];
        let mass = 5.0 * self.share * link.inertia.mass();
        let inertia = 0.06_f64.powi(2) * mass;
        let mut offset = || between(rng, -0.1, 0.1);
        let values = vec![
            ("mass", mass),
            ("com_x", offset()),
            ("com_y", offset()),
            ("com_z", offset()),
            ("inertia_xx", inertia),
            ("inertia_yy", inertia),
            ("inertia_zz", inertia),
        ];
        let values = last.own("unmodelled_payload", values);
        (vec![last.joint], None, values)
    }
}
