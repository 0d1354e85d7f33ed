//! Condition number of the observation matrix: `√(λ_max/λ_min)` of the information matrix.

use nalgebra::DMatrix;

use crate::design::criterion::eigenvalues::{assemble, decompose, eigenvalues, log_mean};
use crate::design::criterion::{Criterion, Graded};

/// Smallest ratio of the largest to the least singular value (Gautier and Khalil 1992).
#[derive(Debug)]
pub struct Condition;

impl Condition {
    /// `√(λ_max/λ_min)`; infinite where the matrix is singular.
    pub fn ratio(&self, information: &DMatrix<f64>) -> f64 {
        eigenvalues(information).map_or(f64::INFINITY, |l| (l.max() / l.min()).sqrt())
    }
}

impl Criterion for Condition {
    fn id(&self) -> &'static str {
        "condition"
    }

    fn meaning(&self) -> &'static str {
        "condition number of the observation matrix"
    }

    fn value(&self, information: &DMatrix<f64>) -> f64 {
        self.ratio(information)
    }

    fn minimised(&self, information: &DMatrix<f64>, exponent: f64) -> Option<f64> {
        let values = eigenvalues(information)?;
        Some(0.5 * (log_mean(&values, exponent).0 - log_mean(&values, -exponent).0))
    }

    fn graded(&self, information: &DMatrix<f64>, exponent: f64) -> Option<Graded> {
        let (values, vectors) = decompose(information)?;
        let (high, up) = log_mean(&values, exponent);
        let (low, down) = log_mean(&values, -exponent);
        Some(Graded {
            value: 0.5 * (high - low),
            gradient: assemble(&vectors, &((up - down) * 0.5)),
        })
    }

    fn exponents(&self) -> &'static [f64] {
        &[8.0, 32.0, 128.0, 512.0]
    }
}
