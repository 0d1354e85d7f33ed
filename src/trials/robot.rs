//! Random robots with drives, friction and sensors of plausible size.

use crate::robot::batch::{Trajectory, torques};
use crate::robot::derivative_batch::DerivativeBatch;
use crate::robot::random::{between, body_about, index, symmetric, vector};
use crate::robot::tree::{Joint, JointKind, Limits, Tree};
use crate::robot::urdf::inertial;
use nalgebra::{Rotation3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::fmt::Write;

/// Kinds of robots by name: the number of joints behind the word; those that slide have one prismatic joint.
pub const KINDS: [&str; 10] = [
    "arm3", "arm4", "arm5", "arm6", "arm7", "slide3", "slide4", "slide5", "slide6", "slide7",
];

/// rad/s² and m/s² that a random motion reaches.
const ACCELERATION: [f64; 2] = [10.0, 3.0];

/// States at which the size of torques is looked at.
const STATES: usize = 128;

/// Counts of the encoders, a turn or 2/π of a metre: steps of 12 µrad or 3 µm.
pub const ENCODER_COUNTS: f64 = 524_288.0;

/// A robot with its drives.
#[derive(Debug, Clone)]
pub struct RandomRobot {
    /// Its name in results: one of [`KINDS`].
    pub kind: &'static str,
    /// Its joints, and links with random inertias.
    pub tree: Tree,
    /// RMS torque of the bodies in random motion, N·m (N); a twentieth of the largest at least.
    pub torque: Vec<f64>,
    /// Mean of the diagonal of the mass matrix, kg·m² (kg).
    pub mass: Vec<f64>,
    /// N·m/A at the joint.
    pub torque_constant: Vec<f64>,
    /// kg·m² (kg) at the joint.
    pub rotor_inertia: Vec<f64>,
    /// Coulomb (N·m) and viscous (N·m·s/rad) friction.
    pub friction: Vec<[f64; 2]>,
    /// Standard deviation of the current's noise, A.
    pub noise: Vec<f64>,
}

impl RandomRobot {
    /// A random robot of a kind.
    pub fn draw(rng: &mut ChaCha8Rng, kind: &'static str) -> Self {
        let count = kind
            .trim_start_matches(char::is_alphabetic)
            .parse()
            .unwrap_or(6);
        let sliding = kind.starts_with("slide").then(|| index(rng, count));
        let tree = draw_tree(rng, count, sliding);
        let (torque, mass) = sizes(rng, &tree);
        let torque_constant: Vec<f64> = torque.iter().map(|t| t / between(rng, 0.5, 2.0)).collect();
        let rotor_inertia = mass.iter().map(|m| m * between(rng, 0.2, 1.0)).collect();
        let friction = tree.joints().iter().zip(&torque).map(|(joint, torque)| {
            let usual_speed = 0.4 * joint.limits.velocity.unwrap_or(1.0);
            let dry = between(rng, 0.05, 0.15) * torque;
            [dry, between(rng, 0.05, 0.15) * torque / usual_speed]
        });
        let friction = friction.collect();
        let noise = torque.iter().zip(&torque_constant);
        let noise = noise
            .map(|(t, k)| between(rng, 0.003, 0.015) * t / k)
            .collect();
        Self {
            kind,
            tree,
            torque,
            mass,
            torque_constant,
            rotor_inertia,
            friction,
            noise,
        }
    }

    /// Name of a joint.
    pub fn name(&self, joint: usize) -> &str {
        &self.tree.joints()[joint].name
    }

    /// Largest speed of a joint, rad/s or m/s.
    pub fn speed(&self, joint: usize) -> f64 {
        self.tree.joints()[joint].limits.velocity.unwrap_or(1.0)
    }

    /// Middle and half of the range of a joint, rad or m.
    pub fn range(&self, joint: usize) -> (f64, f64) {
        let limits = &self.tree.joints()[joint].limits;
        let (lower, upper) = (limits.lower.unwrap_or(-1.0), limits.upper.unwrap_or(1.0));
        (0.5 * (lower + upper), 0.5 * (upper - lower))
    }

    /// The robot as a URDF file.
    pub fn urdf(&self) -> String {
        let mut text = String::from("<robot name=\"random\">\n<link name=\"base\"/>\n");
        for joint in self.tree.joints() {
            write_joint(&mut text, &self.tree, joint);
        }
        text.push_str("</robot>\n");
        text
    }
}

fn write_joint(text: &mut String, tree: &Tree, joint: &Joint) {
    let parent = joint
        .parent
        .map_or("base", |p| tree.joints()[p].link.as_str());
    let kind = match joint.kind {
        JointKind::Revolute => "revolute",
        JointKind::Prismatic => "prismatic",
    };
    let (roll, pitch, yaw) = joint.rotation.euler_angles();
    let [t, a] = [joint.translation, joint.axis];
    let limit = |x: Option<f64>| x.unwrap_or(0.0);
    // Writing to a string does not fail.
    let _ = writeln!(
        text,
        "<joint name=\"{}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{}\"/>\
         <origin xyz=\"{} {} {}\" rpy=\"{roll} {pitch} {yaw}\"/><axis xyz=\"{} {} {}\"/>\
         <limit lower=\"{}\" upper=\"{}\" velocity=\"{}\" effort=\"0\"/></joint>",
        joint.name,
        joint.link,
        t.x,
        t.y,
        t.z,
        a.x,
        a.y,
        a.z,
        limit(joint.limits.lower),
        limit(joint.limits.upper),
        limit(joint.limits.velocity),
    );
    let _ = writeln!(
        text,
        "<link name=\"{}\">{}</link>",
        joint.link,
        inertial(&joint.inertia)
    );
}

/// A chain whose links grow lighter outwards; neighbouring axes are parallel or at right angles, and a little off.
fn draw_tree(rng: &mut ChaCha8Rng, count: usize, sliding: Option<usize>) -> Tree {
    let shrink = between(rng, 0.55, 0.8);
    let mut mass = between(rng, 8.0, 20.0);
    let mut joints = Vec::with_capacity(count);
    for k in 0..count {
        let slides = sliding == Some(k);
        let axis = match k {
            0 if rng.random::<f64>() < 0.7 => Vector3::z(),
            _ => [Vector3::x(), Vector3::y(), Vector3::z()][index(rng, 3)],
        };
        let length = between(rng, 0.12, 0.45);
        let along = match rng.random::<f64>() < 0.7 {
            true => Vector3::z(),
            false => Vector3::x(),
        };
        let centre = along * (length * between(rng, 0.2, 0.6)) + vector(rng, 0.03);
        joints.push(Joint {
            name: format!("j{}", k + 1),
            link: format!("l{}", k + 1),
            parent: k.checked_sub(1),
            kind: if slides {
                JointKind::Prismatic
            } else {
                JointKind::Revolute
            },
            axis,
            rotation: Rotation3::new(vector(rng, 0.05)),
            translation: along * length + vector(rng, 0.05),
            limits: limits(rng, slides),
            inertia: body_about(rng, mass, centre, 0.12),
        });
        mass *= shrink;
    }
    Tree::new("random", "base", joints)
}

fn limits(rng: &mut ChaCha8Rng, slides: bool) -> Limits {
    let (half_range, velocity) = match slides {
        true => (between(rng, 0.15, 0.3), between(rng, 0.3, 0.6)),
        false => (between(rng, 1.2, 2.6), between(rng, 1.5, 3.5)),
    };
    let middle = symmetric(rng, 0.3 * half_range);
    Limits {
        lower: Some(middle - half_range),
        upper: Some(middle + half_range),
        velocity: Some(velocity),
        effort: None,
    }
}

/// RMS torque and mean mass of every joint over random states.
fn sizes(rng: &mut ChaCha8Rng, tree: &Tree) -> (Vec<f64>, Vec<f64>) {
    let n = tree.len();
    let mut motion = [0, 1, 2].map(|_| vec![Vec::with_capacity(STATES); n]);
    for _ in 0..STATES {
        for (j, joint) in tree.joints().iter().enumerate() {
            let limits = &joint.limits;
            let (lower, upper) = (limits.lower.unwrap_or(-1.0), limits.upper.unwrap_or(1.0));
            let slides = usize::from(joint.kind == JointKind::Prismatic);
            let mut normal = || -> f64 { StandardNormal.sample(rng) };
            let speed = 0.35 * limits.velocity.unwrap_or(1.0) * normal();
            motion[2][j].push(0.3 * ACCELERATION[slides] * normal());
            motion[1][j].push(speed);
            motion[0][j].push(between(rng, lower, upper));
        }
    }
    let parameters = tree.parameters();
    let [q, dq, ddq] = &motion;
    let all = torques(tree, &parameters, Trajectory { q, dq, ddq });
    let rms = |series: &Vec<f64>| {
        (series.iter().map(|x| x * x).sum::<f64>() / series.len() as f64).sqrt()
    };
    let mut torque: Vec<f64> = all.iter().map(rms).collect();
    let largest = torque.iter().copied().fold(0.0, f64::max);
    torque.iter_mut().for_each(|t| *t = t.max(0.05 * largest));
    let mut derivatives = DerivativeBatch::new(tree, STATES);
    let states = Trajectory { q, dq, ddq };
    derivatives.evaluate(tree, &parameters, states, 0..STATES);
    let mean = |j: usize| {
        let entries = &derivatives.slope(2, j, j)[..STATES];
        entries.iter().sum::<f64>() / STATES as f64
    };
    (torque, (0..n).map(mean).collect())
}
