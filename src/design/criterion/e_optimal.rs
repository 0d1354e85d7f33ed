//! E-optimality: the largest variance of any combination, one over the least eigenvalue of the information.

use nalgebra::DMatrix;

use crate::design::criterion::eigenvalues::{
    Eigen, LogMean, assemble, decompose, eigenvalues, log_mean,
};
use crate::design::criterion::{Criterion, Graded};

/// Smallest longest axis of the confidence ellipsoid.
#[derive(Debug)]
pub struct EOptimal;

impl Criterion for EOptimal {
    fn id(&self) -> &'static str {
        "e_optimal"
    }

    fn meaning(&self) -> &'static str {
        "largest variance of a unit combination of the (scaled) parameters"
    }

    fn value(&self, information: &DMatrix<f64>) -> f64 {
        eigenvalues(information).map_or(f64::INFINITY, |l| 1.0 / l.min())
    }

    fn minimised(&self, information: &DMatrix<f64>, exponent: f64) -> Option<f64> {
        let values = eigenvalues(information)?;
        Some(-log_mean(&values, -exponent).value)
    }

    fn graded(&self, information: &DMatrix<f64>, exponent: f64) -> Option<Graded> {
        let Eigen { values, vectors } = decompose(information)?;
        let LogMean { value: low, slopes } = log_mean(&values, -exponent);
        Some(Graded {
            value: -low,
            gradient: assemble(&vectors, &-slopes),
        })
    }

    fn exponents(&self) -> &'static [f64] {
        &[8.0, 32.0, 128.0, 512.0]
    }
}
