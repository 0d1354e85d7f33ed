//! Whether the training motion shows what the model's friction asks: range, both directions, several speeds.

use crate::chain::dataset::Dataset;
use crate::recording::split::Split;
use crate::chain::model::Model;
use crate::check::finding;
use crate::check::regression::still;
use crate::check::setting::Setting;
use crate::fault::Place;
use crate::outcome::check::{Finding, Severity};

/// Share of the largest speed from which a row is in motion.
const MOVING: f64 = 0.05;

/// Share of the moving rows that one direction needs.
const DIRECTION_SHARE: f64 = 0.02;

/// Coefficient of variation of |q̇| below which Coulomb and viscous friction are one column.
const ONE_SPEED: f64 = 0.15;

/// Speeds up to this many transition speeds w show friction only on its way up.
const WIDTHS: f64 = 5.0;

pub(super) fn check(setting: &Setting<'_>, model: &Model, data: &Dataset) -> Vec<Finding> {
    let joints = setting.moving.iter().copied();
    joints
        .filter_map(|joint| of_joint(setting, (model, joint), data))
        .collect()
}

fn of_joint(
    setting: &Setting<'_>,
    (model, joint): (&Model, usize),
    data: &Dataset,
) -> Option<Finding> {
    let description = &model.joints()[joint];
    let place = || Place::file(&setting.problem.path).key(&description.name);
    let warn = |code: &str, message: String, remedy: &str| {
        Some(finding(
            Severity::Warning,
            place(),
            (code, message, remedy.to_string()),
        ))
    };
    let unit = description.kind.position_unit();
    let motion = || data.of(Split::Train).map(|r| &r.experiment.motion);
    let positions = motion().flat_map(|m| m.position[joint].iter());
    let ends = |(low, high): (f64, f64), q: &f64| (low.min(*q), high.max(*q));
    let (low, high) = positions.fold((f64::INFINITY, f64::NEG_INFINITY), ends);
    if high - low < still(description.kind) {
        return warn(
            "joint-hardly-moves",
            format!(
                "the joint moves by {:.5} {unit} in all training recordings",
                high - low
            ),
            "move it in a training recording, or state it under robot.locked",
        );
    }
    let has_friction = |id: &str| {
        description
            .effects
            .iter()
            .any(|(effect, _)| effect.id == id)
    };
    if !has_friction("coulomb_friction") {
        return None;
    }
    let velocities: Vec<f64> = motion()
        .flat_map(|m| m.velocity[joint].iter().copied())
        .collect();
    let fastest = velocities.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let moving: Vec<f64> = velocities
        .into_iter()
        .filter(|v| v.abs() > MOVING * fastest)
        .collect();
    let forward = moving.iter().filter(|v| **v > 0.0).count() as f64 / moving.len().max(1) as f64;
    if !(DIRECTION_SHARE..=1.0 - DIRECTION_SHARE).contains(&forward) {
        return warn(
            "one-direction",
            format!(
                "the joint moves {:.1} % of the time in the positive direction",
                100.0 * forward
            ),
            "move it both ways: otherwise Coulomb friction is the same as an offset or a gravity torque",
        );
    }
    let width = description
        .width
        .map_or(0.0, |w| model.parameters()[w].value);
    if fastest < WIDTHS * width {
        return warn(
            "too-slow-for-friction",
            format!(
                "the joint never exceeds {fastest:.4} {unit}/s, its friction's transition speed w is {width} \
                 {unit}/s"
            ),
            "move it faster, or give a smaller w under drive.values",
        );
    }
    let mean = moving.iter().map(|v| v.abs()).sum::<f64>() / moving.len() as f64;
    let squares = moving.iter().map(|v| (v.abs() - mean).powi(2)).sum::<f64>();
    let variation = (squares / moving.len() as f64).sqrt() / mean;
    if has_friction("viscous_friction") && variation < ONE_SPEED {
        return warn(
            "one-speed",
            format!("the joint moves at {mean:.4} {unit}/s nearly all the time"),
            "move it slowly and fast: otherwise Coulomb and viscous friction cannot be told apart",
        );
    }
    None
}
