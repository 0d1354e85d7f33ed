//! Gradient of `⟨G, Y(q, q̇, q̈)⟩` for a given matrix G (n x 10n): what excitation design needs, since
//! every criterion c(Y) has a gradient `⟨∂c/∂Y, ∂Y⟩`.
//!
//! Reverse mode by hand over the recursion of the regressor. Read the ten entries of G at (i, j) as a
//! body with mass m, first moment h and inertia I; with its functional (w, v) on link j the value is
//! `v·f + w·n` of [`crate::robot::newton_euler`], and its adjoints are
//!
//! ```text
//! v̄ = f     w̄ = n     d̄ = m v + w × h     ω̇̄ = h × v + I w
//! ω̄ = v (ω·h) + h (ω·v) − 2 ω (v·h) + I (w × ω) + (I ω) × w
//! ```
//!
//! which then travel inward against the recursion. The cost is a small multiple of one regressor.

use crate::linalg::lanes::scalar::Scalar;
use crate::robot::motion::{JointState, LinkMotion, advance, base_acceleration};
use crate::robot::newton_euler::{Load, body_load};
use crate::robot::regressor::Functional;
use crate::robot::tree::{Link, Tree};
use crate::robot::vector::{Mat3, Vec3};

/// Adjoints of what a link does.
#[derive(Clone, Copy, Debug)]
struct Adjoint<T> {
    spin: Vec3<T>,
    spin_rate: Vec3<T>,
    acceleration: Vec3<T>,
}

/// Gradient with respect to the motion of the joints.
#[derive(Clone, Debug)]
pub struct MotionGradient<T> {
    /// ∂/∂q_j, per rad (m), one entry per joint.
    pub q: Vec<T>,
    /// ∂/∂q̇_j, per rad/s (m/s).
    pub dq: Vec<T>,
    /// ∂/∂q̈_j, per rad/s² (m/s²).
    pub ddq: Vec<T>,
}

/// Memory of the recursion, reused from sample to sample.
#[derive(Clone, Debug)]
pub struct RegressorGradient<T> {
    motions: Vec<LinkMotion<T>>,
    functionals: Vec<Functional<T>>,
    functional_adjoints: Vec<Functional<T>>,
    adjoints: Vec<Adjoint<T>>,
    gradient: MotionGradient<T>,
}

impl<T: Scalar> RegressorGradient<T> {
    /// Memory for the recursion over a tree; computes nothing yet.
    pub fn new(tree: &Tree) -> Self {
        let n = tree.len();
        let (zero, none) = (T::constant(0.0), Vec3::zero());
        Self {
            motions: vec![LinkMotion::rest(); n],
            functionals: vec![Functional::zero(); tree.pairs()],
            functional_adjoints: vec![Functional::zero(); tree.pairs()],
            adjoints: vec![
                Adjoint {
                    spin: none,
                    spin_rate: none,
                    acceleration: none,
                };
                n
            ],
            gradient: MotionGradient {
                q: vec![zero; n],
                dq: vec![zero; n],
                ddq: vec![zero; n],
            },
        }
    }

    /// Gradient of `Σ G_ij Y_ij` with respect to q, q̇ and q̈ at one sample. `weights(i, j)` gives the
    /// ten entries of G in row i and the columns of link j; it is asked only where joint i moves
    /// link j.
    #[inline(always)]
    pub fn evaluate(
        &mut self,
        tree: &Tree,
        [q, dq, ddq]: [&[T]; 3],
        mut weights: impl FnMut(usize, usize) -> [T; 10],
    ) -> &MotionGradient<T> {
        let base = base_acceleration(tree);
        for (j, link) in tree.links().iter().enumerate() {
            let state = JointState::of(link, q[j], dq[j], ddq[j]);
            let parent = link.parent.map(|p| &self.motions[p]);
            let motion = advance(link, parent, base, state);
            let first = link.own + 1 - link.ancestors.len();
            if let Some(p) = link.parent {
                let inherited = tree.links()[p].own + 1 - (link.ancestors.len() - 1);
                for k in 0..link.ancestors.len() - 1 {
                    self.functionals[first + k] =
                        self.functionals[inherited + k].carried(&motion.turn, motion.offset);
                }
            }
            self.functionals[link.own] = Functional::of_joint(link.revolute, link.axis);
            self.motions[j] = motion;
            self.adjoints[j] = self.pair_adjoints(j, link, &mut weights);
        }
        for (j, link) in tree.links().iter().enumerate().rev() {
            self.inward(tree, j, link, dq[j]);
        }
        &self.gradient
    }

    /// Adjoints that link j receives from the pairs it is the outer member of.
    #[inline(always)]
    fn pair_adjoints(
        &mut self,
        j: usize,
        link: &Link,
        weights: &mut impl FnMut(usize, usize) -> [T; 10],
    ) -> Adjoint<T> {
        let motion = &self.motions[j];
        let (spin, two) = (motion.spin, T::constant(2.0));
        let first = link.own + 1 - link.ancestors.len();
        let mut sum = Adjoint {
            spin: Vec3::zero(),
            spin_rate: Vec3::zero(),
            acceleration: Vec3::zero(),
        };
        for (k, &row) in link.ancestors.iter().enumerate() {
            let body = weights(row, j);
            let Load { force, moment } = body_load(motion, body);
            let [m, hx, hy, hz, xx, xy, yy, xz, yz, zz] = body;
            let (h, tensor) = (
                Vec3([hx, hy, hz]),
                Mat3::symmetric([xx, xy, yy, xz, yz, zz]),
            );
            let Functional {
                angular: w,
                linear: v,
            } = self.functionals[first + k];
            self.functional_adjoints[first + k] = Functional {
                angular: moment,
                linear: force,
            };
            sum.acceleration += w.cross(h).plus_scaled(m, v);
            sum.spin_rate += h.cross(v) + tensor.times(w);
            sum.spin += (tensor.times(w.cross(spin)) + tensor.times(spin).cross(w))
                .plus_scaled(spin.dot(h), v)
                .plus_scaled(spin.dot(v), h)
                .plus_scaled(-(two * v.dot(h)), spin);
        }
        sum
    }

    /// Turns the adjoints of link j into the gradient of its joint and the adjoints of its parent.
    #[inline(always)]
    fn inward(&mut self, tree: &Tree, j: usize, link: &Link, dq: T) {
        let motion = self.motions[j];
        let adjoint = self.adjoints[j];
        let axis = Vec3::constant(link.axis);
        let across = motion.carried_spin.cross(axis);
        let (mut carried_spin, mut turn_moment, mut offset) =
            (adjoint.spin, Vec3::zero(), Vec3::zero());
        if link.revolute {
            self.gradient.ddq[j] = axis.dot(adjoint.spin_rate);
            self.gradient.dq[j] = axis.dot(adjoint.spin) + across.dot(adjoint.spin_rate);
            carried_spin = carried_spin.plus_scaled(dq, axis.cross(adjoint.spin_rate));
            turn_moment = carried_spin.cross(motion.carried_spin)
                + adjoint.spin_rate.cross(motion.carried_spin_rate)
                + adjoint.acceleration.cross(motion.acceleration);
        } else {
            let twice = dq + dq;
            self.gradient.ddq[j] = axis.dot(adjoint.acceleration);
            self.gradient.dq[j] = across.dot(adjoint.acceleration) * T::constant(2.0);
            carried_spin = carried_spin.plus_scaled(twice, axis.cross(adjoint.acceleration));
        }
        let first = link.own + 1 - link.ancestors.len();
        for k in 0..link.ancestors.len() - 1 {
            let here = self.functionals[first + k];
            let bar = self.functional_adjoints[first + k];
            turn_moment += bar.angular.cross(here.angular) + bar.linear.cross(here.linear);
            let linear = motion.turn.transpose_times(bar.linear);
            let angular = motion.turn.transpose_times(bar.angular) + motion.offset.cross(linear);
            // A functional exists on this link only beside the parent's: the parent is there.
            if let Some(p) = link.parent {
                let at = tree.links()[p].own + 1 - (link.ancestors.len() - 1) + k;
                offset += linear.cross(self.functionals[at].angular);
                self.functional_adjoints[at].angular += angular;
                self.functional_adjoints[at].linear += linear;
            }
        }
        let through = motion.turn.transpose_times(adjoint.acceleration);
        if let Some(p) = link.parent {
            let (spin, r) = (self.motions[p].spin, motion.offset);
            offset += through.cross(self.motions[p].spin_rate) + spin.cross(spin.cross(through));
            let parent = &mut self.adjoints[p];
            parent.acceleration += through;
            parent.spin_rate += motion.turn.transpose_times(adjoint.spin_rate) + r.cross(through);
            parent.spin += motion.turn.transpose_times(carried_spin)
                + through
                    .scale(spin.dot(r))
                    .plus_scaled(spin.dot(through), r)
                    .plus_scaled(-(through.dot(r) + through.dot(r)), spin);
        }
        self.gradient.q[j] = if link.revolute {
            axis.dot(turn_moment)
        } else {
            Vec3::constant(link.parent_axis).dot(offset)
        };
    }
}
