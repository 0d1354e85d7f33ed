//! Limits of motions: `[design.limits]`, else the robot file, else usual figures.

use crate::fault::Place;
use crate::problem_file::ProblemFile;
use crate::robot::tree::JointKind;
use crate::setup::error::{Mismatch, SetupError};
use crate::setup::robot::Robot;
use std::f64::consts::FRAC_PI_2;

/// Limits of one joint, rad or m and seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointLimits {
    /// Least position, rad (m).
    pub lower: f64,
    /// Greatest position, rad (m).
    pub upper: f64,
    /// Greatest speed, rad/s (m/s).
    pub velocity: f64,
    /// Greatest size of the acceleration, rad/s² (m/s²).
    pub acceleration: f64,
    /// Greatest size of the jerk, rad/s³ (m/s³); none where it is not limited.
    pub jerk: Option<f64>,
    /// Of the motor torque at joint scale, N·m or N.
    pub torque: Option<f64>,
}

impl JointLimits {
    /// No limits.
    pub const NONE: Self = Self {
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        velocity: f64::INFINITY,
        acceleration: f64::INFINITY,
        jerk: None,
        torque: None,
    };

    /// The middle of the positions.
    pub fn middle(&self) -> f64 {
        0.5 * (self.lower + self.upper)
    }

    /// Half of the range of positions.
    pub fn half_range(&self) -> f64 {
        0.5 * (self.upper - self.lower)
    }
}

/// Figures for joints of which nothing is known.
struct Usual {
    /// Half of the range of positions.
    half_range: f64,
    velocity: f64,
    acceleration: f64,
}

/// rad, rad/s, rad/s²: what an industrial arm reaches without effort.
const TURNING: Usual = Usual {
    half_range: FRAC_PI_2,
    velocity: 2.0,
    acceleration: 10.0,
};

/// m, m/s, m/s².
const SLIDING: Usual = Usual {
    half_range: 0.25,
    velocity: 0.3,
    acceleration: 3.0,
};

/// The limits of every joint in the order of the tree.
///
/// # Errors
/// A list of the wrong length; a range without width.
pub fn of_joints(problem: &ProblemFile, robot: &Robot) -> Result<Vec<JointLimits>, SetupError> {
    let given = &problem.design.limits;
    let lower = robot.per_joint(&given.position_lower)?;
    let upper = robot.per_joint(&given.position_upper)?;
    let velocity = robot.per_joint(&given.velocity)?;
    let acceleration = robot.per_joint(&given.acceleration)?;
    let jerk = robot.per_joint(&given.jerk)?;
    let torque = robot.per_joint(&given.torque)?;
    let of = |values: &Option<Vec<f64>>, k: usize| values.as_ref().map(|v| v[k]);
    let mut limits = Vec::with_capacity(robot.tree.len());
    for (k, joint) in robot.tree.joints().iter().enumerate() {
        let usual = match joint.kind {
            JointKind::Revolute => TURNING,
            JointKind::Prismatic => SLIDING,
        };
        let stated = joint.limits;
        let range = 2.0 * usual.half_range;
        let (lower, upper) = match (
            of(&lower, k).or(stated.lower),
            of(&upper, k).or(stated.upper),
        ) {
            (Some(lower), Some(upper)) => (lower, upper),
            (Some(lower), None) => (lower, lower + range),
            (None, Some(upper)) => (upper - range, upper),
            (None, None) => {
                let middle = robot.mechanism.as_ref().map_or(0.0, |m| m.home()[k]);
                (middle - usual.half_range, middle + usual.half_range)
            }
        };
        if lower >= upper && robot.locked[k].is_none() {
            return Err(SetupError::mismatch(
                &Place::file(&problem.path).key("design.limits"),
                Mismatch::NoRange {
                    joint: joint.name.clone(),
                },
            ));
        }
        // A robot file without a figure often states zero.
        let positive = |value: Option<f64>| value.filter(|v| *v > 0.0);
        limits.push(JointLimits {
            lower,
            upper,
            velocity: of(&velocity, k)
                .or(positive(stated.velocity))
                .unwrap_or(usual.velocity),
            acceleration: of(&acceleration, k).unwrap_or(usual.acceleration),
            jerk: of(&jerk, k),
            torque: of(&torque, k).or(positive(stated.effort)),
        });
    }
    for dependent in &robot.dependents {
        let (behind, leader) = (limits[dependent.joint], &mut limits[dependent.leader]);
        let ends =
            [behind.lower, behind.upper].map(|q| (q - dependent.offset) / dependent.multiplier);
        let stated = robot.tree.joints()[dependent.joint].limits;
        if stated.lower.is_some() && stated.upper.is_some() {
            leader.lower = leader.lower.max(ends[0].min(ends[1]));
            leader.upper = leader.upper.min(ends[0].max(ends[1]));
        }
    }
    Ok(limits)
}
