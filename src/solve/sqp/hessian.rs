//! B, the estimate of the Lagrangian's Hessian: damped BFGS, in variables divided by their scales.

use nalgebra::{DMatrix, DVector};

/// Share of dᵀB d that the curvature along a step is raised to, so that B stays positive definite (Powell).
const DAMPING: f64 = 0.2;

/// Curvature of the first model as a share of |gradient| per unit step, and its least value.
const FIRST_CURVATURE: f64 = 1.0;
const LEAST_CURVATURE: f64 = 1e-8;

/// A positive definite matrix.
#[derive(Debug, Clone)]
pub(super) struct Hessian {
    matrix: DMatrix<f64>,
    updated: bool,
}

impl Hessian {
    /// A multiple of the identity for which the first step has about unit length.
    pub(super) fn first(gradient: &DVector<f64>) -> Self {
        let n = gradient.len();
        let curvature = (FIRST_CURVATURE * gradient.amax()).max(LEAST_CURVATURE);
        Self {
            matrix: DMatrix::identity(n, n) * curvature,
            updated: false,
        }
    }

    pub(super) fn matrix(&self) -> &DMatrix<f64> {
        &self.matrix
    }

    /// Learns from a step d along which the Lagrangian's gradient changed by y.
    pub(super) fn update(&mut self, d: &DVector<f64>, y: &DVector<f64>) {
        let squared = d.norm_squared();
        if squared.is_nan() || squared <= 0.0 || !y.iter().all(|v| v.is_finite()) {
            return;
        }
        if !self.updated {
            let along = d.dot(y);
            if along > 0.0 {
                // The size of the curvature that was met replaces the guess (Nocedal and Wright, eq. 6.20).
                let n = d.len();
                self.matrix = DMatrix::identity(n, n) * (y.norm_squared() / along);
            }
            self.updated = true;
        }
        let bd = &self.matrix * d;
        let curvature = d.dot(&bd);
        let along = d.dot(y);
        let theta = if along >= DAMPING * curvature {
            1.0
        } else {
            (1.0 - DAMPING) * curvature / (curvature - along)
        };
        let r = y * theta + &bd * (1.0 - theta);
        let change = d.dot(&r);
        if !(change > 0.0 && curvature > 0.0) {
            return;
        }
        self.matrix.ger(1.0 / change, &r, &r, 1.0);
        self.matrix.ger(-1.0 / curvature, &bd, &bd, 1.0);
    }

    /// Forgets everything.
    pub(super) fn reset(&mut self, gradient: &DVector<f64>) {
        *self = Self::first(gradient);
    }
}
