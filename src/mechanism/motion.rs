//! Where the links of a tree are and how they move, for conditions between them.

use crate::robot::tree::{JointKind, Tree};
use nalgebra::{Rotation3, Vector3};

/// A point fixed to a link, or to the base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Anchor {
    /// The joint that carries the link; `None` for the base.
    pub link: Option<usize>,
    /// In the link's frame, m.
    pub point: Vector3<f64>,
}

/// One link, everything in the base frame; accelerations are those at q̈ = 0.
#[derive(Debug, Clone, Copy)]
struct Link {
    rotation: Rotation3<f64>,
    origin: Vector3<f64>,
    /// Of the joint that carries it.
    axis: Vector3<f64>,
    spin: Vector3<f64>,
    velocity: Vector3<f64>,
    spin_rate: Vector3<f64>,
    acceleration: Vector3<f64>,
}

const REST: Link = Link {
    rotation: Rotation3::from_matrix_unchecked(nalgebra::Matrix3::new(
        1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0,
    )),
    origin: Vector3::new(0.0, 0.0, 0.0),
    axis: Vector3::new(0.0, 0.0, 0.0),
    spin: Vector3::new(0.0, 0.0, 0.0),
    velocity: Vector3::new(0.0, 0.0, 0.0),
    spin_rate: Vector3::new(0.0, 0.0, 0.0),
    acceleration: Vector3::new(0.0, 0.0, 0.0),
};

/// A vector with its first two derivatives in time at q̈ = 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct TimeDerivatives {
    pub value: Vector3<f64>,
    pub rate: Vector3<f64>,
    pub second: Vector3<f64>,
}

/// All links of a tree at one state.
#[derive(Debug)]
pub(super) struct Links<'a> {
    tree: &'a Tree,
    links: Vec<Link>,
    pub q: &'a [f64],
}

impl<'a> Links<'a> {
    /// Links at positions q and velocities q̇ (both of n entries).
    pub fn at(tree: &'a Tree, q: &'a [f64], dq: &[f64]) -> Self {
        let mut links: Vec<Link> = Vec::with_capacity(tree.len());
        for (k, joint) in tree.joints().iter().enumerate() {
            let parent = joint.parent.map_or(REST, |p| links[p]);
            let fixed = parent.rotation * joint.rotation;
            let axis = fixed * joint.axis;
            let slides = joint.kind == JointKind::Prismatic;
            let (slide, turn) = if slides { (dq[k], 0.0) } else { (0.0, dq[k]) };
            let mut arm = parent.rotation * joint.translation;
            if slides {
                arm += axis * q[k];
            }
            let spin = parent.spin;
            let swing = spin.cross(&arm);
            links.push(Link {
                rotation: match joint.kind {
                    JointKind::Prismatic => fixed,
                    JointKind::Revolute => fixed * Rotation3::new(joint.axis * q[k]),
                },
                origin: parent.origin + arm,
                axis,
                spin: spin + axis * turn,
                velocity: parent.velocity + swing + axis * slide,
                spin_rate: parent.spin_rate + spin.cross(&axis) * turn,
                acceleration: parent.acceleration
                    + parent.spin_rate.cross(&arm)
                    + spin.cross(&swing)
                    + spin.cross(&axis) * (2.0 * slide),
            });
        }
        Self { tree, links, q }
    }

    fn link(&self, link: Option<usize>) -> Link {
        link.map_or(REST, |k| self.links[k])
    }

    /// A point of a link.
    pub fn point(&self, anchor: &Anchor) -> TimeDerivatives {
        let link = self.link(anchor.link);
        let arm = link.rotation * anchor.point;
        let swing = link.spin.cross(&arm);
        TimeDerivatives {
            value: link.origin + arm,
            rate: link.velocity + swing,
            second: link.acceleration + link.spin_rate.cross(&arm) + link.spin.cross(&swing),
        }
    }

    /// A direction fixed to a link.
    pub fn direction(&self, link: Option<usize>, direction: &Vector3<f64>) -> TimeDerivatives {
        let link = self.link(link);
        let value = link.rotation * direction;
        let rate = link.spin.cross(&value);
        TimeDerivatives {
            value,
            rate,
            second: link.spin_rate.cross(&value) + link.spin.cross(&rate),
        }
    }

    fn carries(&self, joint: usize, link: Option<usize>) -> bool {
        link.is_some_and(|link| self.tree.moves(joint, link))
    }

    /// Velocity of a point at unit speed of one joint, the others at rest.
    pub fn point_by(&self, joint: usize, anchor: &Anchor) -> Vector3<f64> {
        if !self.carries(joint, anchor.link) {
            return Vector3::zeros();
        }
        let moved = &self.links[joint];
        match self.tree.joints()[joint].kind {
            JointKind::Prismatic => moved.axis,
            JointKind::Revolute => {
                let arm = self.point(anchor).value - moved.origin;
                moved.axis.cross(&arm)
            }
        }
    }

    /// Rate of a direction at unit speed of one joint, the others at rest.
    pub fn direction_by(
        &self,
        joint: usize,
        link: Option<usize>,
        direction: &Vector3<f64>,
    ) -> Vector3<f64> {
        let turns = self.tree.joints()[joint].kind == JointKind::Revolute;
        if !turns || !self.carries(joint, link) {
            return Vector3::zeros();
        }
        let value = self.link(link).rotation * direction;
        self.links[joint].axis.cross(&value)
    }
}
