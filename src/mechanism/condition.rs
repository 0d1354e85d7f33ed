//! What closes a loop: the gap g, its derivatives G by the joints, and Ġ q̇.

use crate::mechanism::motion::Links;
use nalgebra::Vector3;

pub use crate::mechanism::motion::Anchor;

/// A closed joint, or a tie between two joints.
#[derive(Debug, Clone, PartialEq)]
pub enum Condition {
    /// A ball joint: two points are one. Three rows, m.
    Ball {
        /// The two points, each on its link.
        ends: [Anchor; 2],
    },
    /// A hinge: two points are one and two axes (unit vectors in the links' frames) are parallel. Six rows,
    /// m and without unit, of which five are independent.
    Hinge {
        /// The two points, each on its link.
        ends: [Anchor; 2],
        /// Their axes, unit vectors in the frames of the links.
        axes: [Vector3<f64>; 2],
    },
    /// A massless rod with a ball joint at both ends: `(|p_b − p_a|² − L²) / 2L = 0`. One row, m.
    Rod {
        /// The two points, p_a and p_b, each on its link.
        ends: [Anchor; 2],
        /// L, m, > 0.
        length: f64,
    },
    /// Two joints move alike: `q_b − q_a = 0`. One row, rad or m.
    Equal {
        /// Indices of the two joints in the tree.
        joints: [usize; 2],
    },
}

impl Condition {
    /// Rows of g.
    pub fn rows(&self) -> usize {
        match self {
            Self::Ball { .. } => 3,
            Self::Hinge { .. } => 6,
            Self::Rod { .. } | Self::Equal { .. } => 1,
        }
    }

    /// Writes g of a state.
    pub(super) fn gap(&self, links: &Links<'_>, out: &mut [f64]) {
        match self {
            Self::Ball { ends } => out.copy_from_slice(between(links, ends).as_slice()),
            Self::Hinge { ends, axes } => {
                out[..3].copy_from_slice(between(links, ends).as_slice());
                let [a, b] = [0, 1].map(|k| links.direction(ends[k].link, &axes[k]).value);
                out[3..].copy_from_slice(a.cross(&b).as_slice());
            }
            Self::Rod { ends, length } => {
                let apart = between(links, ends).norm_squared();
                out[0] = (apart - length * length) / (2.0 * length);
            }
            Self::Equal { joints: [a, b] } => out[0] = links.q[*b] - links.q[*a],
        }
    }

    /// Writes the column of G that belongs to one joint.
    pub(super) fn column(&self, links: &Links<'_>, joint: usize, out: &mut [f64]) {
        let apart_by = |ends: &[Anchor; 2]| -> Vector3<f64> {
            links.point_by(joint, &ends[1]) - links.point_by(joint, &ends[0])
        };
        match self {
            Self::Ball { ends } => out.copy_from_slice(apart_by(ends).as_slice()),
            Self::Hinge { ends, axes } => {
                out[..3].copy_from_slice(apart_by(ends).as_slice());
                let of = |k: usize| links.direction(ends[k].link, &axes[k]).value;
                let by = |k: usize| links.direction_by(joint, ends[k].link, &axes[k]);
                let turned = by(0).cross(&of(1)) + of(0).cross(&by(1));
                out[3..].copy_from_slice(turned.as_slice());
            }
            Self::Rod { ends, length } => {
                out[0] = between(links, ends).dot(&apart_by(ends)) / length;
            }
            Self::Equal { joints: [a, b] } => {
                out[0] = f64::from(u8::from(joint == *b)) - f64::from(u8::from(joint == *a));
            }
        }
    }

    /// Writes Ġ q̇: the second derivative of g in time at q̈ = 0.
    pub(super) fn bias(&self, links: &Links<'_>, out: &mut [f64]) {
        let second = |ends: &[Anchor; 2]| {
            let [a, b] = ends.map(|end| links.point(&end));
            (b.rate - a.rate, b.second - a.second)
        };
        match self {
            Self::Ball { ends } => out.copy_from_slice(second(ends).1.as_slice()),
            Self::Hinge { ends, axes } => {
                out[..3].copy_from_slice(second(ends).1.as_slice());
                let [a, b] = [0, 1].map(|k| links.direction(ends[k].link, &axes[k]));
                let turned = a.second.cross(&b.value)
                    + a.rate.cross(&b.rate) * 2.0
                    + a.value.cross(&b.second);
                out[3..].copy_from_slice(turned.as_slice());
            }
            Self::Rod { ends, length } => {
                let (rate, second) = second(ends);
                out[0] = (rate.norm_squared() + between(links, ends).dot(&second)) / length;
            }
            Self::Equal { .. } => out[0] = 0.0,
        }
    }
}

fn between(links: &Links<'_>, ends: &[Anchor; 2]) -> Vector3<f64> {
    links.point(&ends[1]).value - links.point(&ends[0]).value
}
