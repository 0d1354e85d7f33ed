//! The skeleton of a robot as the problem file has it: which joints stand still, which follow others.

use crate::outcome::machine::{MachineLeader, Pose};
use crate::outcome::skeleton::{Bone, Skeleton, Tip};
use crate::setup::robot::Robot;

/// Lines between the joints of a robot.
pub fn of(robot: &Robot) -> Skeleton {
    let tree = &robot.tree;
    let bones = tree.joints().iter().enumerate().map(|(j, joint)| {
        let behind = robot.dependents.iter().find(|d| d.joint == j);
        let follows = behind.map(|d| MachineLeader {
            joint: d.leader,
            multiplier: d.multiplier,
            offset: d.offset,
        });
        Bone {
            name: joint.name.clone(),
            parent: joint.parent,
            motion: joint.kind.into(),
            axis: joint.axis.into(),
            pose: Pose::from_parts(&joint.rotation, &joint.translation),
            locked: robot.locked[j].filter(|_| follows.is_none()),
            follows,
        }
    });
    let frames = tree.frames().iter().filter_map(|frame| {
        Some(Tip {
            name: frame.name.clone(),
            joint: frame.joint?,
            at: frame.placement.translation.vector.into(),
        })
    });
    Skeleton::new(bones.collect(), frames)
}
