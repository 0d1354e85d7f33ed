//! A-optimality: the sum of the variances, the trace of the inverse of the information matrix.

use nalgebra::{Cholesky, DMatrix};

use crate::design::criterion::{Criterion, Graded};

/// Smallest sum of the variances.
#[derive(Debug)]
pub struct AOptimal;

impl Criterion for AOptimal {
    fn id(&self) -> &'static str {
        "a_optimal"
    }

    fn meaning(&self) -> &'static str {
        "sum of the variances of the (scaled) parameters"
    }

    fn value(&self, information: &DMatrix<f64>) -> f64 {
        let log = self.minimised(information, 1.0);
        log.map_or(f64::INFINITY, f64::exp)
    }

    fn minimised(&self, information: &DMatrix<f64>, _: f64) -> Option<f64> {
        let covariance = Cholesky::new(information.clone())?.inverse();
        Some(covariance.trace().ln()).filter(|v| v.is_finite())
    }

    fn graded(&self, information: &DMatrix<f64>, _: f64) -> Option<Graded> {
        let covariance = Cholesky::new(information.clone())?.inverse();
        let trace = covariance.trace();
        trace.is_finite().then(|| Graded {
            value: trace.ln(),
            gradient: &covariance * &covariance / -trace,
        })
    }
}
