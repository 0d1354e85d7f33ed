//! Excitation of friction by the training motion: range, both directions, several speeds.

use crate::chain::dataset::Dataset;
use crate::chain::effect::knowledge::JointTerm;
use crate::chain::model::{JointModel, Model};
use crate::check::context::CheckContext;
use crate::check::extent::extent;
use crate::check::regression::still;
use crate::check::report::finding;
use crate::fault::{Description, Place};
use crate::outcome::check::{Mistake, Severity};
use crate::recording::split::Split;

/// Share of the largest speed from which a row is in motion.
const MOVING: f64 = 0.05;

/// Share of the moving rows that one direction needs.
const DIRECTION_SHARE: f64 = 0.02;

/// Coefficient of variation of |q̇| below which Coulomb and viscous friction are one column.
const ONE_SPEED: f64 = 0.15;

/// Speeds up to this many transition speeds w show friction only on its way up.
const WIDTHS: f64 = 5.0;

pub(super) fn check(context: &CheckContext<'_>, model: &Model, data: &Dataset) -> Vec<Mistake> {
    let joints = context.moving.iter().copied();
    joints
        .filter_map(|joint| of_joint(context, model, joint, data))
        .collect()
}

fn of_joint(
    context: &CheckContext<'_>,
    model: &Model,
    joint: usize,
    data: &Dataset,
) -> Option<Mistake> {
    let description = &model.joints()[joint];
    let motion = || data.of(Split::Train).map(|r| &r.experiment.motion);
    let (low, high) = extent(motion().flat_map(|m| m.position[joint].iter().copied()));
    let velocities = motion().flat_map(|m| m.velocity[joint].iter().copied());
    let words = if high - low < still(description.kind) {
        Some(Description::new(
            "joint-hardly-moves",
            format!(
                "the joint moves by {:.5} {} in all training recordings",
                high - low,
                description.kind.position_unit()
            ),
            "move it in a training recording, or state it under robot.locked",
        ))
    } else {
        of_speeds(description, model, velocities.collect())
    };
    let place = Place::file(&context.problem.path).key(&description.name);
    words.map(|words| finding(Severity::Warning, place, words))
}

/// What Coulomb friction asks of the speeds of its joint.
fn of_speeds(joint: &JointModel, model: &Model, velocities: Vec<f64>) -> Option<Description> {
    if !joint.has_term(JointTerm::DryFriction) {
        return None;
    }
    let unit = joint.kind.position_unit();
    let fastest = velocities.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let moves = |v: &f64| v.abs() > MOVING * fastest;
    let moving: Vec<f64> = velocities.into_iter().filter(moves).collect();
    let count = moving.len().max(1) as f64;
    let forward = moving.iter().filter(|v| **v > 0.0).count() as f64 / count;
    if !(DIRECTION_SHARE..=1.0 - DIRECTION_SHARE).contains(&forward) {
        return Some(Description::new(
            "one-direction",
            format!(
                "the joint moves {:.1} % of the time in the positive direction",
                100.0 * forward
            ),
            "move it both ways: otherwise Coulomb friction is the same as an offset or a gravity torque",
        ));
    }
    let width = joint.width.map_or(0.0, |w| model.parameters()[w].value);
    if fastest < WIDTHS * width {
        return Some(Description::new(
            "too-slow-for-friction",
            format!(
                "the joint never exceeds {fastest:.4} {unit}/s, its friction's transition speed w is {width} \
                 {unit}/s"
            ),
            "move it faster, or give a smaller w under drive.values",
        ));
    }
    let mean = moving.iter().map(|v| v.abs()).sum::<f64>() / count;
    let squares = moving.iter().map(|v| (v.abs() - mean).powi(2)).sum::<f64>();
    let one_speed = (squares / count).sqrt() < ONE_SPEED * mean;
    (joint.has_term(JointTerm::ViscousFriction) && one_speed).then(|| {
        Description::new(
            "one-speed",
            format!("the joint moves at {mean:.4} {unit}/s nearly all the time"),
            "move it slowly and fast: otherwise Coulomb and viscous friction cannot be told apart",
        )
    })
}
