//! What a robot file says beside its tree: joints that follow others, drives, and what the reader made of elements that a
//! tree on a fixed base has no place for.

use crate::fault::{Description as Words, Place};
use crate::robot::tree::Tree;
use std::fmt;
use std::path::PathBuf;

/// A robot file, read.
#[derive(Debug, Clone)]
pub struct Description {
    /// The moving joints, with links behind fixed joints merged into theirs.
    pub tree: Tree,
    /// Joints without a motor of their own, each behind another joint.
    pub dependents: Vec<Dependent>,
    /// Joints that the file holds at a position.
    pub held: Vec<Held>,
    /// What the file says of the drives, one per joint of the tree; empty where it says nothing.
    pub drives: Vec<DeclaredDrive>,
    /// What was made of elements in another way than the file may mean.
    pub notes: Vec<Note>,
    /// Every file that was read, the named one first.
    pub files: Vec<PathBuf>,
}

impl Description {
    /// A description that is a tree alone.
    pub fn of_tree(tree: Tree, file: PathBuf) -> Self {
        Self {
            tree,
            dependents: Vec::new(),
            held: Vec::new(),
            drives: Vec::new(),
            notes: Vec::new(),
            files: vec![file],
        }
    }
}

/// A joint that follows another: `q_joint = multiplier · q_leader + offset`, rad or m.
///
/// Its torque reaches the motor of the leader: `τ_leader += multiplier · τ_joint` (virtual work).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dependent {
    /// Index in the tree of the joint that follows.
    pub joint: usize,
    /// A joint that follows none.
    pub leader: usize,
    /// Its motion per motion of the leader, signed.
    pub multiplier: f64,
    /// Its position where the leader stands at zero, rad (m).
    pub offset: f64,
}

/// A joint that the file holds at a position, rad or m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Held {
    /// Index of the joint in the tree.
    pub joint: usize,
    /// rad (m).
    pub position: f64,
}

/// What a robot file says of the drive of one joint, at joint scale. `None` where it says nothing.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DeclaredDrive {
    /// kg·m² (kg)
    pub rotor_inertia: Option<f64>,
    /// N·m·s/rad (N·s/m)
    pub viscous_friction: Option<f64>,
    /// N·m (N)
    pub coulomb_friction: Option<f64>,
    /// What pulls the joint to a position of rest.
    pub spring: Option<DeclaredSpring>,
    /// The controller within the actuator.
    pub servo: Option<DeclaredServo>,
}

/// A spring at a joint: torque `stiffness · (q − rest)` against the motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeclaredSpring {
    /// N·m/rad (N/m)
    pub stiffness: f64,
    /// rad (m)
    pub rest: f64,
}

/// The actuator of a joint: torque `gear · (gain · command − kp · gear · q − kv · gear · q̇)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeclaredServo {
    /// Torque of the joint per force of the actuator.
    pub gear: f64,
    /// Force of the actuator per length of its transmission; 0 of a motor.
    pub kp: f64,
    /// Force of the actuator per speed of its transmission; 0 of a motor.
    pub kv: f64,
}

/// What a reader made of an element, for a user to know.
#[derive(Debug, Clone, PartialEq)]
pub struct Note {
    /// The element in the robot file.
    pub place: Place,
    /// What was read, and what was made of it.
    pub words: Words,
    /// Whether it changes torques.
    pub weight: Weight,
}

/// Whether a note is of something that changes torques.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weight {
    /// The model is that of the file as long as the robot stands as the note says.
    Remark,
    /// Physics of the file is not in the model.
    LeftOut,
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words = &self.words;
        write!(f, "{}: {}; {}", self.place, words.message, words.remedy)
    }
}
