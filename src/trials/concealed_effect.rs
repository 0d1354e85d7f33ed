//! The concealed effect of a trial: an effect of the vocabulary on a joint, with values of physical size.
//!
//! Sizes are a share `f` of the torque that the joint usually bears, so that all effects are swept over the same
//! range; what the declared model cannot absorb of them is measured, not assumed.

use crate::chain::effect::knowledge::{Drawn, Trial};
use crate::chain::effect::site::Site;
use crate::chain::effect::{Catalogue, Effect, Law, Memory};
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::robot::random::index;
use crate::trials::law_size;
use crate::trials::robot::RandomRobot;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

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

/// The effects that can be concealed: those that say how, and of others those whose size can be told from their formula; none
/// that is declared.
pub fn effects(catalogue: &Catalogue) -> impl Iterator<Item = &'static Effect> {
    let all = catalogue.effects().iter().copied();
    all.filter(|effect| match effect.knowledge.trial {
        Trial::Declared => false,
        Trial::Drawn(_) => true,
        Trial::FromLaw => law_size::has_size(effect),
    })
}

/// How long a recording lasts: so many periods, or as long where the motion does not repeat.
#[derive(Debug, Clone, Copy)]
pub struct RecordingLength {
    /// s.
    pub period: f64,
    /// How many; 1 is a recording of one period's length.
    pub periods: usize,
}

impl RecordingLength {
    fn duration(self) -> f64 {
        self.period * self.periods as f64
    }
}

/// The robot of a trial, and how large its concealed effects are.
#[derive(Clone, Copy)]
pub struct Scale<'a> {
    /// Whose joints bear it.
    pub robot: &'a RandomRobot,
    /// How long the recording lasts.
    pub length: RecordingLength,
    /// Size of an effect as a share of the usual torque.
    pub share: f64,
}

/// Share of the trials of a late signal in which one cable or one clock carries the channels of all joints.
const COMMON_DELAYS: f64 = 0.7;

/// Draws an effect on a joint.
pub fn draw(
    rng: &mut ChaCha8Rng,
    effect: &'static Effect,
    joint: usize,
    scale: Scale<'_>,
) -> Concealed {
    let name = |joint: usize| scale.robot.name(joint);
    let of_joint = |joint: usize| format!("{}.{}", name(joint), effect.id);
    let all: Vec<usize> = (0..scale.robot.tree.len()).collect();
    let (joints, other, values) = match effect.law {
        Law::Tilt => {
            let values = named(effect.id, &scale.values(rng, effect, joint));
            (all, None, values)
        }
        Law::Delay if rng.random::<f64>() < COMMON_DELAYS => {
            let of = |&j: &usize| named(&of_joint(j), &scale.values(rng, effect, j));
            let values = all.iter().flat_map(of).collect();
            (all, None, values)
        }
        Law::Coupling | Law::Crosstalk => {
            let other = match effect.law {
                // Any two channels may lie side by side.
                Law::Crosstalk => (joint + 1 + index(rng, all.len() - 1)) % all.len(),
                _ if joint == 0 => 1,
                _ => joint - 1,
            };
            let entries = scale.values(rng, effect, joint).into_iter();
            let entry =
                |entry: Drawn| (format!("{}.{}", of_joint(joint), name(other)), entry.value);
            (vec![joint], Some(other), entries.map(entry).collect())
        }
        Law::Body => {
            let last = scale.robot.tree.len() - 1;
            let values = named(&of_joint(last), &scale.values(rng, effect, last));
            (vec![last], None, values)
        }
        _ => {
            let values = named(&of_joint(joint), &scale.values(rng, effect, joint));
            (vec![joint], None, values)
        }
    };
    let hypothesis = Hypothesis {
        effect,
        joints,
        other,
    };
    Concealed { hypothesis, values }
}

fn named(prefix: &str, values: &[Drawn]) -> Vec<(String, f64)> {
    let full = |drawn: &Drawn| (format!("{prefix}.{}", drawn.parameter), drawn.value);
    values.iter().map(full).collect()
}

impl Scale<'_> {
    fn site(&self, joint: usize) -> Site {
        let robot = self.robot;
        let (middle, half_range) = robot.range(joint);
        Site {
            share: self.share,
            usual_torque: robot.torque[joint],
            dry_friction: robot.friction[joint][0],
            fastest: robot.speed(joint),
            middle,
            half_range,
            inertia: robot.mass[joint],
            link_mass: robot.tree.joints()[joint].inertia.mass(),
            torque_constant: robot.torque_constant[joint],
            duration: self.length.duration(),
        }
    }

    /// Values of the parameters of an effect at a joint.
    fn values(&self, rng: &mut ChaCha8Rng, effect: &'static Effect, joint: usize) -> Vec<Drawn> {
        let site = self.site(joint);
        match effect.knowledge.trial {
            Trial::Drawn(sized) => sized(&site, rng),
            Trial::Declared | Trial::FromLaw => law_size::values(rng, effect, &site),
        }
    }
}
