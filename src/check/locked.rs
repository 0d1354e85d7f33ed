//! Joints that the problem locks and the recording moves.

use crate::check::context::CheckContext;
use crate::check::extent::extent;
use crate::check::report::finding;
use crate::fault::{Description, Place};
use crate::outcome::check::{Mistake, Severity};
use crate::setup::recording_file::NamedRecording;
use crate::setup::recordings::read_one;
use crate::setup::robot::Robot;

/// A locked joint may be this far from where it is locked, rad or m: what bodies weigh about the other joints then
/// changes by a hundredth.
pub(crate) const STILL: f64 = 0.01;

/// Compares positions of locked joints, where the file has them, with those that are stated.
pub(super) fn check(context: &CheckContext<'_>, named: &NamedRecording<'_>) -> Vec<Mistake> {
    let locked = &context.robot.locked;
    if context.robot.mechanism.is_some() || locked.iter().all(Option::is_none) {
        return Vec::new();
    }
    let unlocked = Robot {
        locked: vec![None; locked.len()],
        ..context.robot.clone()
    };
    // Most files do not have columns of joints that are locked.
    let Ok(recording) = read_one(context.table, &unlocked, named.path) else {
        return Vec::new();
    };
    let mut recorded = context.robot.position.clone();
    recorded.sort_unstable();
    let of_joint = |k: usize, at: f64| {
        // Joints that follow others have no channel.
        let channel = recorded.binary_search(&k).ok()?;
        let (low, high) = extent(recording.position[channel].iter().copied());
        let farthest = (high - at).abs().max((low - at).abs());
        (farthest > STILL).then(|| {
            finding(
                Severity::Error,
                Place::file(&named.path.resolved).key(&context.robot.tree.joints()[k].name),
                Description::new(
                    "locked-joint-moves",
                    format!("the joint is locked at {at} and goes from {low:.4} to {high:.4} in the recording"),
                    "take it out of `robot.locked`, or lock it where it stands",
                ),
            )
        })
    };
    let stated = locked.iter().enumerate();
    stated.filter_map(|(k, at)| of_joint(k, (*at)?)).collect()
}
