//! Inverse dynamics by the recursive Newton-Euler algorithm: `τ = ID(q, q̇, q̈; π)`.
//!
//! Inward, with mass m, first moment h and inertia I about the link's origin (Luh, Walker and Paul
//! 1980, in first moments):
//!
//! ```text
//! f = m d + ω̇ × h + ω × (ω × h)        n = I ω̇ + ω × I ω + h × d
//! f_p += Eᵀ f        n_p += Eᵀ n + r × Eᵀ f        τ = z·n (revolute), z·f (prismatic)
//! ```

use crate::linalg::lanes::scalar::Scalar;
use crate::robot::motion::{JointState, LinkMotion, advance, base_acceleration, centripetal};
use crate::robot::tree::{Link, Tree};
use crate::robot::vector::{Mat3, Vec3};

/// Force and moment about a frame's origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Load<T> {
    pub force: Vec3<T>,
    pub moment: Vec3<T>,
}

impl<T: Scalar> Load<T> {
    pub fn zero() -> Self {
        Self {
            force: Vec3::zero(),
            moment: Vec3::zero(),
        }
    }

    /// The same load about the parent's origin in the parent's axes, for a link that moves so.
    #[inline(always)]
    pub fn carried(self, motion: &LinkMotion<T>) -> Self {
        let force = motion.turn.transpose_times(self.force);
        Self {
            force,
            moment: motion.turn.transpose_times(self.moment) + motion.offset.cross(force),
        }
    }

    /// What the joint of the link bears of it: the force or moment along its axis.
    #[inline(always)]
    pub fn along(self, link: &Link) -> T {
        let borne = if link.revolute {
            self.moment
        } else {
            self.force
        };
        Vec3::constant(link.axis).dot(borne)
    }
}

/// Memory of the recursion, reused from sample to sample.
#[derive(Clone, Debug)]
pub struct NewtonEuler<T> {
    motions: Vec<LinkMotion<T>>,
    loads: Vec<Load<T>>,
    /// Whether a joint whose torque is asked for bears the load of each link.
    is_borne: Vec<bool>,
}

impl<T: Scalar> NewtonEuler<T> {
    /// Memory for the recursion over a tree; computes nothing yet.
    pub fn new(tree: &Tree) -> Self {
        Self::of_joints(tree, &vec![true; tree.len()])
    }

    /// The same where the torques of some joints alone are asked for.
    pub fn of_joints(tree: &Tree, wanted: &[bool]) -> Self {
        let is_borne = |link: &Link| link.ancestors.iter().any(|&joint| wanted[joint]);
        Self {
            motions: vec![LinkMotion::rest(); tree.len()],
            loads: vec![Load::zero(); tree.len()],
            is_borne: tree.links().iter().map(is_borne).collect(),
        }
    }

    /// Joint torques (N·m; N for sliding joints), n values; those of joints that are not asked for mean nothing.
    /// `parameters` are the 10 n inertial parameters; `q`, `dq`, `ddq` have n values each.
    #[inline(always)]
    pub fn torque(
        &mut self,
        tree: &Tree,
        parameters: &[f64],
        [q, dq, ddq]: [&[T]; 3],
        torque: &mut [T],
    ) {
        let base = base_acceleration(tree);
        for (j, link) in tree.links().iter().enumerate() {
            let state = JointState::of(link, q[j], dq[j], ddq[j]);
            let parent = link.parent.map(|p| &self.motions[p]);
            self.motions[j] = advance(link, parent, base, state);
            if !self.is_borne[j] {
                continue;
            }
            let body = &parameters[10 * j..10 * j + 10];
            self.loads[j] = body_load(
                &self.motions[j],
                std::array::from_fn(|k| T::constant(body[k])),
            );
        }
        for (j, link) in tree.links().iter().enumerate().rev() {
            let load = self.loads[j];
            torque[j] = load.along(link);
            if let Some(parent) = link.parent.filter(|&parent| self.is_borne[parent]) {
                let carried = load.carried(&self.motions[j]);
                self.loads[parent].force += carried.force;
                self.loads[parent].moment += carried.moment;
            }
        }
    }

    /// How every link moved in the last evaluation.
    pub(crate) fn motions(&self) -> &[LinkMotion<T>] {
        &self.motions
    }
}

/// Inertial load of one body, with its ten parameters, about the origin of its frame.
#[inline(always)]
pub(crate) fn body_load<T: Scalar>(motion: &LinkMotion<T>, body: [T; 10]) -> Load<T> {
    let [m, hx, hy, hz, xx, xy, yy, xz, yz, zz] = body;
    let (h, tensor) = (
        Vec3([hx, hy, hz]),
        Mat3::symmetric([xx, xy, yy, xz, yz, zz]),
    );
    let (spin, rate, d) = (motion.spin, motion.spin_rate, motion.acceleration);
    Load {
        force: (rate.cross(h) + centripetal(spin, h)).plus_scaled(m, d),
        moment: tensor.times(rate) + spin.cross(tensor.times(spin)) + h.cross(d),
    }
}
