//! The robot that a run identified, complete in numbers: geometry, bodies, drives and losses.
//!
//! It stands in the result so that a results folder is enough to export or reuse the model: no robot file
//! and no problem file has to be found again.

use serde::{Deserialize, Serialize};

use crate::outcome::number;
use crate::robot::inertia::{Inertia, PER_LINK};
use crate::robot::tree::{Frame, Joint, JointKind, Limits, Tree};
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

/// A robot with its identified bodies and drives, joints in the order of the tree, parents first.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// Name of the robot.
    pub name: String,
    /// Name of the base link.
    pub base: String,
    /// m/s², in the base frame as it stands.
    pub gravity: [f64; 3],
    /// Roll and pitch of the base, rad, by which `gravity` differs from the declared one; absent where no tilt is in
    /// the model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tilt: Option<[f64; 2]>,
    /// Parents before children.
    pub joints: Vec<MachineJoint>,
    /// Frames that are fixed to a link or to the base.
    pub frames: Vec<MachineFrame>,
    /// What closes the loops of joints without a motor; empty for a tree.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub loops: Vec<MachineLoop>,
    /// Positions of all joints at which the loops are closed, rad (m); absent for a tree.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub home: Option<Vec<f64>>,
    /// V of `q = V m + offset` by rows; absent where every motor moves its own joint alone.
    pub coupling: Option<Vec<Vec<f64>>>,
    /// The load of the run; absent without one.
    pub payload: Option<MachineLoad>,
    /// Whether every body is physically possible; absent where it was not examined.
    pub feasible: Option<bool>,
    /// What the signal of the run was: drives in front of a joint torque sensor are not in the model.
    pub signal: String,
    /// The robot file as read: shapes and meshes that the model does not know.
    pub description: Option<RobotDescription>,
}

/// Whether a joint turns or slides, in the words of robot files.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Motion {
    /// It turns about its axis.
    #[default]
    Revolute,
    /// It slides along its axis.
    Prismatic,
}

/// Where a frame stands in another: `x_other = rotation x + translation`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// By rows.
    pub rotation: [[f64; 3]; 3],
    /// m
    pub translation: [f64; 3],
}

/// A joint, the link that it carries, and its drive.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct MachineJoint {
    /// Name of the joint.
    pub name: String,
    /// Name of the link that it carries.
    pub link: String,
    /// Position of the joint that carries the parent link; absent for the base.
    pub parent: Option<usize>,
    /// Whether it turns or slides.
    pub motion: Motion,
    /// Unit vector in the link's frame.
    pub axis: [f64; 3],
    /// The link's frame in its parent's at position 0.
    pub pose: Pose,
    /// Lower and upper position, rad (m); absent where the robot file states none.
    pub lower: Option<f64>,
    /// As `lower`, at the other end.
    pub upper: Option<f64>,
    /// rad/s (m/s)
    pub velocity: Option<f64>,
    /// N·m (N)
    pub effort: Option<f64>,
    /// m, m·cx, m·cy, m·cz, Ixx, Ixy, Iyy, Ixz, Iyz, Izz about the origin of the link's frame, kg, kg·m, kg·m².
    pub body: [f64; PER_LINK],
    /// Position at which the joint stood still in every recording.
    pub locked: Option<f64>,
    /// The loops move this joint, which has no motor of its own.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub passive: bool,
    /// The joint that moves this one, which has no motor of its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub follows: Option<MachineLeader>,
    /// N·m/A (N/A) at joint scale; absent where the signal is a torque.
    pub torque_constant: Option<f64>,
    /// The position controller of the motor; absent where the signal is a current or a torque.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub controller: Option<MachineController>,
    /// Constant of `q = V m + offset`, rad (m).
    pub offset: f64,
    /// Friction, elasticity and other physics of its drive, in the order of the vocabulary.
    pub effects: Vec<MachineEffect>,
}

/// Gains of `kp (command − position) + kd (commanded speed − speed) + feed-forward`, the torque of a motor at joint scale.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct MachineController {
    /// N·m/rad (N/m).
    pub kp: f64,
    /// N·m·s/rad (N·s/m).
    pub kd: f64,
}

/// What closes a loop of the tree.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "joint", rename_all = "lowercase")]
pub enum MachineLoop {
    /// Two points are one.
    Ball {
        /// The two points, each on its link.
        ends: [MachineAnchor; 2],
    },
    /// Two points are one and two axes, unit vectors in the links' frames, are parallel.
    Hinge {
        /// The two points, each on its link.
        ends: [MachineAnchor; 2],
        /// Their axes, unit vectors in the frames of the links.
        axes: [[f64; 3]; 2],
    },
    /// A massless rod between two points, m.
    Rod {
        /// The two points, each on its link.
        ends: [MachineAnchor; 2],
        /// Length of the rod, m.
        length: f64,
    },
    /// Two joints have one position.
    Equal {
        /// Positions of the two among the joints.
        joints: [usize; 2],
    },
}

/// A point that is fixed to a link.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MachineAnchor {
    /// Position of the joint that carries the link; absent for the base.
    pub link: Option<usize>,
    /// In the link's frame, m.
    pub point: [f64; 3],
}

/// The law `q = multiplier · q_leader + offset` of a joint that follows another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MachineLeader {
    /// Position of the leader among the joints.
    pub joint: usize,
    /// Its motion per motion of the leader, signed.
    pub multiplier: f64,
    /// rad (m)
    pub offset: f64,
}

/// An effect of a joint's drive and the values of its parameters, in SI units.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct MachineEffect {
    /// Identifier of the effect.
    pub id: String,
    /// Its parameters by name.
    pub parameters: Vec<MachineValue>,
}

/// A value by name.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct MachineValue {
    /// Name of the parameter within the effect.
    pub name: String,
    /// In its SI unit.
    #[serde(with = "number::nullable")]
    pub value: f64,
}

/// A named frame and the joint whose link carries it; absent for the base.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct MachineFrame {
    /// Name of the frame.
    pub name: String,
    /// Position of the joint whose link carries it; absent for the base.
    pub joint: Option<usize>,
    /// The frame in that link's frame.
    pub pose: Pose,
}

/// A load in its own frame, which is fixed to a link.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct MachineLoad {
    /// The joint whose link carries the load.
    pub joint: usize,
    /// Name of the frame: a link or a fixed frame of the robot file.
    pub frame: String,
    /// The load's frame in the frame of the link.
    pub pose: Pose,
    /// As [`MachineJoint::body`], about the origin of the load's frame.
    pub body: [f64; PER_LINK],
}

/// The text of the robot file.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RobotDescription {
    /// Name of the file, without folder.
    pub file: String,
    /// The whole file.
    pub text: String,
}

impl Pose {
    /// Of an isometry from one frame to another, m.
    pub fn of(isometry: &Isometry3<f64>) -> Self {
        Self::from_parts(
            &isometry.rotation.to_rotation_matrix(),
            &isometry.translation.vector,
        )
    }

    /// Of a rotation and a translation, m, that is applied after it.
    pub fn from_parts(rotation: &Rotation3<f64>, translation: &Vector3<f64>) -> Self {
        let m = rotation.matrix();
        Self {
            rotation: std::array::from_fn(|r| std::array::from_fn(|c| m[(r, c)])),
            translation: (*translation).into(),
        }
    }

    /// The rotation, which is not made orthogonal anew.
    pub fn rotation(&self) -> Rotation3<f64> {
        let m = &self.rotation;
        Rotation3::from_matrix_unchecked(Matrix3::from_fn(|r, c| m[r][c]))
    }

    /// Origin of the frame in the other, m.
    pub fn translation(&self) -> Vector3<f64> {
        Vector3::from(self.translation)
    }

    /// The same as nalgebra has it.
    pub fn isometry(&self) -> Isometry3<f64> {
        Isometry3::from_parts(
            Translation3::from(self.translation()),
            UnitQuaternion::from_rotation_matrix(&self.rotation()),
        )
    }
}

impl From<JointKind> for Motion {
    fn from(kind: JointKind) -> Self {
        match kind {
            JointKind::Revolute => Self::Revolute,
            JointKind::Prismatic => Self::Prismatic,
        }
    }
}

impl From<Motion> for JointKind {
    fn from(motion: Motion) -> Self {
        match motion {
            Motion::Revolute => Self::Revolute,
            Motion::Prismatic => Self::Prismatic,
        }
    }
}

impl MachineJoint {
    /// Value of a parameter of an effect, if the joint has the effect.
    pub fn value(&self, effect: &str, parameter: &str) -> Option<f64> {
        let effect = self.effects.iter().find(|e| e.id == effect)?;
        let found = effect.parameters.iter().find(|p| p.name == parameter)?;
        Some(found.value)
    }
}

impl MachineLoad {
    /// The load's parameters about the origin of the frame of the link that carries it.
    pub fn on_link(&self) -> Inertia {
        Inertia(self.body).seen_from(&self.pose.rotation(), &self.pose.translation())
    }
}

impl Machine {
    /// The robot as a tree, with the load on its link where `loaded`.
    pub fn tree(&self, loaded: bool) -> Tree {
        let joints = self.joints.iter().map(|joint| Joint {
            name: joint.name.clone(),
            link: joint.link.clone(),
            parent: joint.parent,
            kind: joint.motion.into(),
            axis: Vector3::from(joint.axis),
            rotation: joint.pose.rotation(),
            translation: joint.pose.translation(),
            limits: Limits {
                lower: joint.lower,
                upper: joint.upper,
                velocity: joint.velocity,
                effort: joint.effort,
            },
            inertia: Inertia(joint.body),
        });
        let mut joints: Vec<Joint> = joints.collect();
        if let (Some(load), true) = (&self.payload, loaded) {
            let carrier = &mut joints[load.joint];
            carrier.inertia = carrier.inertia.plus(&load.on_link());
        }
        let frames = self.frames.iter().map(|frame| Frame {
            name: frame.name.clone(),
            joint: frame.joint,
            placement: frame.pose.isometry(),
        });
        Tree::new(&self.name, &self.base, joints)
            .with_frames(frames.collect())
            .with_gravity(self.gravity)
    }
}
