//! A robot as a tree of moving links: joint k carries link k, its parent comes before it.
//!
//! Frames are those of the robot's description: the frame of link k is fixed to it, with the joint's
//! axis (any direction) through its origin. With q_k = 0 it stands in its parent's frame at
//! `translation`, turned by `rotation`.

use crate::robot::inertia::Inertia;
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

/// How a joint moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Turns about its axis, rad.
    Revolute,
    /// Slides along its axis, m.
    Prismatic,
}

impl JointKind {
    /// Unit of the joint's position.
    pub fn position_unit(self) -> &'static str {
        match self {
            Self::Revolute => "rad",
            Self::Prismatic => "m",
        }
    }

    /// Unit of the joint's generalised force.
    pub fn effort_unit(self) -> &'static str {
        match self {
            Self::Revolute => "N·m",
            Self::Prismatic => "N",
        }
    }
}

/// Limits of a joint as its description states them; `None` where it states none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    /// Least position, rad (m).
    pub lower: Option<f64>,
    /// Greatest position, rad (m).
    pub upper: Option<f64>,
    /// Greatest speed, rad/s (m/s), > 0.
    pub velocity: Option<f64>,
    /// Greatest torque or force, N·m (N), > 0.
    pub effort: Option<f64>,
}

/// A moving joint and the link that it carries.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Name of the joint in the robot's description.
    pub name: String,
    /// Name of the link that it carries.
    pub link: String,
    /// Joint that carries the parent link; `None` for the base.
    pub parent: Option<usize>,
    /// Whether the link turns about the axis or slides along it.
    pub kind: JointKind,
    /// Unit vector in the link's frame.
    pub axis: Vector3<f64>,
    /// Frame of the link in its parent's frame at q = 0.
    pub rotation: Rotation3<f64>,
    /// Origin of the link's frame in its parent's frame at q = 0, m.
    pub translation: Vector3<f64>,
    /// What the description allows the joint.
    pub limits: Limits,
    /// Inertial parameters of the link, rigidly attached parts included, about its frame's origin.
    pub inertia: Inertia,
}

/// A named frame that is fixed to a link or to the base: links behind fixed joints keep theirs.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Name of the link or fixed frame.
    pub name: String,
    /// Joint whose link carries the frame; `None` for the base.
    pub joint: Option<usize>,
    /// Its pose in the frame of that joint's link, or of the base; m.
    pub placement: Isometry3<f64>,
}

/// Constants of one joint as the recursions want them: `E(q) = A + B cos q + C sin q` turns parent
/// coordinates into link coordinates.
#[derive(Clone, Debug)]
pub(crate) struct Link {
    pub parent: Option<usize>,
    pub revolute: bool,
    pub axis: [f64; 3],
    /// The axis in the parent's frame.
    pub parent_axis: [f64; 3],
    pub translation: [f64; 3],
    pub constant: [[f64; 3]; 3],
    pub cosine: [[f64; 3]; 3],
    pub sine: [[f64; 3]; 3],
    /// Position of the link's own functional in the packed list of ancestors.
    pub own: usize,
    /// The joints from the root to this one, this one included.
    pub ancestors: Vec<usize>,
}

/// A robot on a fixed base.
#[derive(Clone, Debug)]
pub struct Tree {
    name: String,
    base: String,
    gravity: Vector3<f64>,
    joints: Vec<Joint>,
    frames: Vec<Frame>,
    links: Vec<Link>,
}

/// Standard gravity in the base frame when nothing else is said, m/s².
pub const STANDARD_GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

impl Tree {
    /// A tree from its joints, each after its parent. Axes are normalised.
    ///
    /// # Panics
    /// When a joint's parent does not come before it; readers of robot files make sure of that.
    pub fn new(name: impl Into<String>, base: impl Into<String>, mut joints: Vec<Joint>) -> Self {
        for joint in &mut joints {
            // First by the largest entry: squares of very small ones are zero.
            joint.axis /= joint.axis.amax();
            joint.axis.normalize_mut();
        }
        let links = pack(&joints);
        Self {
            name: name.into(),
            base: base.into(),
            gravity: Vector3::from(STANDARD_GRAVITY),
            joints,
            frames: Vec::new(),
            links,
        }
    }

    /// The same robot with named frames.
    pub fn with_frames(mut self, frames: Vec<Frame>) -> Self {
        self.frames = frames;
        self
    }

    /// The same robot under another gravity, m/s² in the base frame.
    pub fn with_gravity(mut self, gravity: [f64; 3]) -> Self {
        self.gravity = Vector3::from(gravity);
        self
    }

    /// The same robot with other inertial parameters, one per link.
    pub fn with_inertias(mut self, inertias: &[Inertia]) -> Self {
        for (joint, inertia) in self.joints.iter_mut().zip(inertias) {
            joint.inertia = *inertia;
        }
        self
    }

    /// The robot's name in its description.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Name of the base link.
    pub fn base(&self) -> &str {
        &self.base
    }

    /// Acceleration of free fall in the base frame, m/s².
    pub fn gravity(&self) -> Vector3<f64> {
        self.gravity
    }

    /// Number of joints n.
    pub fn len(&self) -> usize {
        self.joints.len()
    }

    /// Whether nothing moves.
    pub fn is_empty(&self) -> bool {
        self.joints.is_empty()
    }

    /// The moving joints, parents before children.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// Links and fixed frames by name, that of the base among them.
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// Index of a joint by name.
    pub fn joint_index(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|j| j.name == name)
    }

    /// The inertial parameters of all links, 10 n, in the project's order.
    pub fn parameters(&self) -> Vec<f64> {
        self.joints.iter().flat_map(|j| j.inertia.0).collect()
    }

    /// A link or fixed frame by name: the joint that carries it and its placement in that link.
    pub fn frame(&self, name: &str) -> Option<(Option<usize>, Isometry3<f64>)> {
        if name == self.base {
            return Some((None, Isometry3::identity()));
        }
        if let Some(k) = self.joints.iter().position(|j| j.link == name) {
            return Some((Some(k), Isometry3::identity()));
        }
        let frame = self.frames.iter().find(|f| f.name == name)?;
        Some((frame.joint, frame.placement))
    }

    /// Placement of every link in the base frame at positions q (n, rad or m).
    pub fn forward_kinematics(&self, q: &[f64]) -> Vec<Isometry3<f64>> {
        let mut poses: Vec<Isometry3<f64>> = Vec::with_capacity(self.len());
        for (joint, &q) in self.joints.iter().zip(q) {
            let parent = joint.parent.map_or(Isometry3::identity(), |p| poses[p]);
            let fixed = Isometry3::from_parts(
                Translation3::from(joint.translation),
                UnitQuaternion::from_rotation_matrix(&joint.rotation),
            );
            let motion = match joint.kind {
                JointKind::Revolute => Isometry3::rotation(joint.axis * q),
                JointKind::Prismatic => Isometry3::from(Translation3::from(joint.axis * q)),
            };
            poses.push(parent * fixed * motion);
        }
        poses
    }

    /// Whether a joint moves a link.
    pub fn moves(&self, joint: usize, link: usize) -> bool {
        self.links[link].ancestors.contains(&joint)
    }

    pub(crate) fn links(&self) -> &[Link] {
        &self.links
    }

    /// Length of the packed list of (ancestor, link) pairs.
    pub(crate) fn pairs(&self) -> usize {
        self.links.last().map_or(0, |link| link.own + 1)
    }
}

fn pack(joints: &[Joint]) -> Vec<Link> {
    let mut links: Vec<Link> = Vec::with_capacity(joints.len());
    let mut end = 0;
    for (k, joint) in joints.iter().enumerate() {
        let mut ancestors = match joint.parent {
            Some(parent) => links[parent].ancestors.clone(),
            None => Vec::new(),
        };
        ancestors.push(k);
        end += ancestors.len();
        let turned = joint.rotation.matrix().transpose();
        let axis = joint.axis;
        let along = axis * axis.transpose();
        // Rot(axis, −q) = aaᵀ + (1 − aaᵀ) cos q − [a×] sin q, applied after the fixed rotation.
        let (constant, cosine, sine) = match joint.kind {
            JointKind::Revolute => (
                along * turned,
                (Matrix3::identity() - along) * turned,
                -axis.cross_matrix() * turned,
            ),
            JointKind::Prismatic => (turned, Matrix3::zeros(), Matrix3::zeros()),
        };
        links.push(Link {
            parent: joint.parent,
            revolute: joint.kind == JointKind::Revolute,
            axis: axis.into(),
            parent_axis: (joint.rotation * axis).into(),
            translation: joint.translation.into(),
            constant: rows(&constant),
            cosine: rows(&cosine),
            sine: rows(&sine),
            own: end - 1,
            ancestors,
        });
    }
    links
}

fn rows(m: &Matrix3<f64>) -> [[f64; 3]; 3] {
    std::array::from_fn(|r| std::array::from_fn(|c| m[(r, c)]))
}
