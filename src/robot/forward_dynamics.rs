//! Forward dynamics: `q̈ = M(q)⁻¹ (τ − h(q, q̇))`, with h the torque at zero acceleration.

use crate::robot::derivatives::Derivatives;
use crate::robot::tree::Tree;

/// Memory of the solution, reused from call to call.
#[derive(Clone, Debug)]
pub struct ForwardDynamics {
    derivatives: Derivatives,
    zero: Vec<f64>,
    /// Lower Cholesky factor, row after row.
    factor: Vec<f64>,
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
    pub pivot: f64,
}

impl ForwardDynamics {
    pub fn new(tree: &Tree) -> Self {
        let n = tree.len();
        Self {
            derivatives: Derivatives::new(tree),
            zero: vec![0.0; n],
            factor: vec![0.0; n * n],
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
        self.derivatives
            .evaluate(tree, parameters, [q, dq, &self.zero]);
        let n = tree.len();
        for i in 0..n {
            ddq[i] = torque[i] - self.derivatives.torque[i];
            for j in 0..=i {
                let mut sum = self.derivatives.mass[(i, j)];
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
}
