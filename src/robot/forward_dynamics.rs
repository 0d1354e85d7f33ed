//! Forward dynamics: `q̈ = M(q)⁻¹ (τ − h(q, q̇))`, with h the torque at zero acceleration.

use crate::robot::inertia::{Inertia, PER_LINK};
use crate::robot::motion::LinkMotion;
use crate::robot::newton_euler::{NewtonEuler, body_load};
use crate::robot::tree::Tree;
use crate::robot::vector::Vec3;
use nalgebra::{Matrix3, Rotation3, Vector3};

/// Memory of the solution, reused from call to call.
#[derive(Clone, Debug)]
pub struct ForwardDynamics {
    dynamics: NewtonEuler<f64>,
    /// Every link with all that it carries, as one body in the link's frame.
    composite: Vec<Inertia>,
    zero: Vec<f64>,
    /// h
    bias: Vec<f64>,
    /// Lower triangle of M, row after row.
    mass: Vec<f64>,
    /// Lower Cholesky factor, row after row.
    factor: Vec<f64>,
}

/// `M(q) q̈ + h(q, q̇) = τ` at one state.
#[derive(Clone, Copy, Debug)]
pub struct EquationOfMotion<'a> {
    /// Lower triangle of M, row after row of n values.
    pub mass: &'a [f64],
    /// h, n values.
    pub bias: &'a [f64],
}

/// The mass matrix is not positive definite: the parameters are not those of bodies.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "the mass matrix is not positive definite at joint {joint} (pivot {pivot:e}); \
     correct the inertial parameters or give the joint a rotor inertia"
)]
pub struct SingularMass {
    /// Index of the joint at which the factorisation fails, from 0.
    pub joint: usize,
    /// The pivot of the Cholesky factorisation there, kg·m² (kg), which is not positive.
    pub pivot: f64,
}

impl ForwardDynamics {
    /// Memory for the recursions over a tree of n joints, n x n for the mass matrix; computes nothing yet.
    pub fn new(tree: &Tree) -> Self {
        let n = tree.len();
        Self {
            dynamics: NewtonEuler::new(tree),
            composite: vec![Inertia::default(); n],
            zero: vec![0.0; n],
            bias: vec![0.0; n],
            mass: vec![0.0; n * n],
            factor: vec![0.0; n * n],
        }
    }

    /// M and h at (q, q̇).
    pub fn equation(
        &mut self,
        tree: &Tree,
        parameters: &[f64],
        [q, dq]: [&[f64]; 2],
    ) -> EquationOfMotion<'_> {
        let state = [q, dq, &self.zero];
        self.dynamics
            .torque(tree, parameters, state, &mut self.bias);
        self.mass_matrix(tree, parameters);
        EquationOfMotion {
            mass: &self.mass,
            bias: &self.bias,
        }
    }

    /// Accelerations into `ddq` for joint torques `torque` at (q, q̇); `added_inertia` is added to the
    /// diagonal of the mass matrix (reflected rotor inertias, kg·m²; zeros where there are none).
    pub fn acceleration(
        &mut self,
        tree: &Tree,
        parameters: &[f64],
        [q, dq, torque, added_inertia]: [&[f64]; 4],
        ddq: &mut [f64],
    ) -> Result<(), SingularMass> {
        self.equation(tree, parameters, [q, dq]);
        let n = tree.len();
        for i in 0..n {
            ddq[i] = torque[i] - self.bias[i];
            for j in 0..=i {
                let mut sum = self.mass[i * n + j];
                if i == j {
                    sum += added_inertia[i];
                }
                for k in 0..j {
                    sum -= self.factor[i * n + k] * self.factor[j * n + k];
                }
                if i > j {
                    self.factor[i * n + j] = sum / self.factor[j * n + j];
                } else if sum > 0.0 {
                    self.factor[i * n + i] = sum.sqrt();
                } else {
                    return Err(SingularMass {
                        joint: i,
                        pivot: sum,
                    });
                }
            }
        }
        for i in 0..n {
            for k in 0..i {
                ddq[i] -= self.factor[i * n + k] * ddq[k];
            }
            ddq[i] /= self.factor[i * n + i];
        }
        for i in (0..n).rev() {
            for k in i + 1..n {
                ddq[i] -= self.factor[k * n + i] * ddq[k];
            }
            ddq[i] /= self.factor[i * n + i];
        }
        Ok(())
    }

    /// The lower triangle of M at the position of the last Newton-Euler recursion: `M_ij = S_i · F_j`, F_j
    /// the load that a unit acceleration of joint j puts on its composite body (Walker and Orin 1982,
    /// method 3).
    fn mass_matrix(&mut self, tree: &Tree, parameters: &[f64]) {
        let (links, motions) = (tree.links(), self.dynamics.motions());
        let n = links.len();
        self.mass.as_mut_slice().fill(0.0);
        for (body, own) in self
            .composite
            .iter_mut()
            .zip(parameters.chunks_exact(PER_LINK))
        {
            body.0.copy_from_slice(own);
        }
        for (j, link) in links.iter().enumerate().rev() {
            let body = self.composite[j];
            if let Some(parent) = link.parent {
                let (turn, offset) = (&motions[j].turn.0, Vector3::from(motions[j].offset.0));
                let upward = Matrix3::from_fn(|r, c| turn[c][r]);
                let upward = Rotation3::from_matrix_unchecked(upward);
                let carried = body.seen_from(&upward, &offset);
                self.composite[parent] = self.composite[parent].plus(&carried);
            }
            let mut unit = LinkMotion::rest();
            if link.revolute {
                unit.spin_rate = Vec3(link.axis);
            } else {
                unit.acceleration = Vec3(link.axis);
            }
            let mut load = body_load(&unit, body.0);
            self.mass[j * n + j] = load.along(link);
            let mut at = j;
            while let Some(parent) = links[at].parent {
                load = load.carried(&motions[at]);
                self.mass[j * n + parent] = load.along(&links[parent]);
                at = parent;
            }
        }
    }
}
