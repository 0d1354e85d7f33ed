//! The robot as lines between its joints: enough to draw it in any posture.

use serde::{Deserialize, Serialize};

use crate::outcome::machine::{
    Machine, MachineAnchor, MachineJoint, MachineLeader, MachineLoop, Motion, Pose,
};

/// Joints in the order of the tree, parents first.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Skeleton {
    /// Parents before children.
    pub joints: Vec<Bone>,
    /// Points at the ends of the robot.
    pub tips: Vec<Tip>,
    /// What closes the loops of joints without a motor.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub closures: Vec<Closure>,
    /// What the robot has to stay on one side of.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub walls: Vec<Wall>,
}

/// A joint and where it stands on the link before it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Bone {
    /// Name of the joint.
    pub name: String,
    /// Position of the joint before it; absent for the base.
    pub parent: Option<usize>,
    /// Whether it turns or slides.
    pub motion: Motion,
    /// Unit vector in the link's frame.
    pub axis: [f64; 3],
    /// The link's frame in its parent's at position 0.
    pub pose: Pose,
    /// Position at which the joint stands still.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub locked: Option<f64>,
    /// The joint that moves this one, which has no motor of its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub follows: Option<MachineLeader>,
    /// It slides without a motor, and stands for the free motion of what loops carry: there is no such joint to be drawn.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub free: bool,
}

/// A rod between two points, or two points that are one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Closure {
    /// The two points, each on its link.
    pub ends: [MachineAnchor; 2],
}

/// A named frame on a link that carries no further joint.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Tip {
    /// Name of the frame.
    pub name: String,
    /// Position of the joint whose link carries it.
    pub joint: usize,
    /// m, in the frame of the link.
    pub at: [f64; 3],
}

/// The half-space `normal · p >= offset` for a point of the robot, in the base frame.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Wall {
    /// Unit vector, into the space that is allowed.
    pub normal: [f64; 3],
    /// m
    pub offset: f64,
}

impl Skeleton {
    /// Joints without loops and walls, and of the frames those at the ends of the robot.
    pub fn new(joints: Vec<Bone>, frames: impl Iterator<Item = Tip>) -> Self {
        let ends = |tip: &Tip| joints.iter().all(|bone| bone.parent != Some(tip.joint));
        let tips = frames.filter(ends).collect();
        Self {
            joints,
            tips,
            closures: Vec::new(),
            walls: Vec::new(),
        }
    }
}

impl From<&Machine> for Skeleton {
    fn from(machine: &Machine) -> Self {
        let bone = |joint: &MachineJoint| Bone {
            name: joint.name.clone(),
            parent: joint.parent,
            motion: joint.motion,
            axis: joint.axis,
            pose: joint.pose,
            locked: joint.locked,
            follows: joint.follows.clone(),
            free: joint.passive && joint.motion == Motion::Prismatic,
        };
        let frames = machine.frames.iter().filter_map(|frame| {
            Some(Tip {
                name: frame.name.clone(),
                joint: frame.joint?,
                at: frame.pose.translation,
            })
        });
        Self {
            closures: machine.loops.iter().filter_map(Closure::of).collect(),
            ..Self::new(machine.joints.iter().map(bone).collect(), frames)
        }
    }
}

impl Closure {
    /// `None` of joints that have one position: nothing stands between them.
    pub fn of(closed: &MachineLoop) -> Option<Self> {
        match closed {
            MachineLoop::Ball { ends }
            | MachineLoop::Hinge { ends, .. }
            | MachineLoop::Rod { ends, .. } => Some(Self { ends: *ends }),
            MachineLoop::Equal { .. } => None,
        }
    }
}
