//! Condition number of the observation matrix: `√(λ_max/λ_min)` of the information matrix.

use nalgebra::DMatrix;

use crate::design::criterion::eigenvalues::{Eigen, assemble, decompose, eigenvalues, log_mean};
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
        let [high, low] = [exponent, -exponent].map(|rho| log_mean(&values, rho).value);
        Some(0.5 * (high - low))
    }

    fn graded(&self, information: &DMatrix<f64>, exponent: f64) -> Option<Graded> {
        let Eigen { values, vectors } = decompose(information)?;
        let [high, low] = [exponent, -exponent].map(|rho| log_mean(&values, rho));
        Some(Graded {
            value: 0.5 * (high.value - low.value),
            gradient: assemble(&vectors, &((high.slopes - low.slopes) * 0.5)),
        })
    }

    fn exponents(&self) -> &'static [f64] {
        &[8.0, 32.0, 128.0, 512.0]
    }
}
