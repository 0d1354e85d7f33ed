//! The skeleton of a robot as the problem file has it: which joints stand still, which follow others.

use crate::outcome::machine::{MachineLeader, Pose};
use crate::outcome::skeleton::{Bone, Closure, Skeleton, Tip};
use crate::robot::tree::JointKind;
use crate::setup::machine::closed;
use crate::setup::robot::Robot;

/// Lines between the joints of a robot.
pub fn of(robot: &Robot) -> Skeleton {
    let tree = &robot.tree;
    let mechanism = robot.mechanism.as_ref();
    let bones = tree.joints().iter().enumerate().map(|(j, joint)| {
        let behind = robot.dependents.iter().find(|d| d.joint == j);
        let follows = behind.map(|d| MachineLeader {
            joint: d.leader,
            multiplier: d.multiplier,
            offset: d.offset,
        });
        let passive = mechanism.is_some_and(|m| m.passive().contains(&j));
        Bone {
            name: joint.name.clone(),
            parent: joint.parent,
            motion: joint.kind.into(),
            axis: joint.axis.into(),
            pose: Pose::from_parts(&joint.rotation, &joint.translation),
            locked: robot.locked[j].filter(|_| follows.is_none() && !passive),
            follows,
            free: passive && joint.kind == JointKind::Prismatic,
        }
    });
    let frames = tree.frames().iter().filter_map(|frame| {
        Some(Tip {
            name: frame.name.clone(),
            joint: frame.joint?,
            at: frame.placement.translation.vector.into(),
        })
    });
    let conditions = mechanism.into_iter().flat_map(|m| m.conditions());
    Skeleton {
        closures: conditions
            .map(closed)
            .filter_map(|c| Closure::of(&c))
            .collect(),
        ..Skeleton::new(bones.collect(), frames)
    }
}
