//! D-optimality: the volume of the confidence ellipsoid, `−log det` of the information matrix.

use nalgebra::{Cholesky, DMatrix};

use crate::design::criterion::{Criterion, Graded};

/// Smallest confidence ellipsoid; does not change with the units of the parameters but for a constant.
#[derive(Debug)]
pub struct DOptimal;

impl DOptimal {
    /// log det; `None` where the matrix is singular.
    pub fn log_det(&self, information: &DMatrix<f64>) -> Option<f64> {
        self.minimised(information, 1.0).map(|v| -v)
    }
}

impl Criterion for DOptimal {
    fn id(&self) -> &'static str {
        "d_optimal"
    }

    fn meaning(&self) -> &'static str {
        "−log det of the information matrix"
    }

    fn value(&self, information: &DMatrix<f64>) -> f64 {
        self.minimised(information, 1.0).unwrap_or(f64::INFINITY)
    }

    fn minimised(&self, information: &DMatrix<f64>, _: f64) -> Option<f64> {
        let factor = Cholesky::new(information.clone())?;
        Some(value(&factor)).filter(|v| v.is_finite())
    }

    fn graded(&self, information: &DMatrix<f64>, _: f64) -> Option<Graded> {
        let factor = Cholesky::new(information.clone())?;
        let value = value(&factor);
        value.is_finite().then(|| Graded {
            value,
            gradient: -factor.inverse(),
        })
    }
}

fn value(factor: &Cholesky<f64, nalgebra::Dyn>) -> f64 {
    -2.0 * factor
        .l_dirty()
        .diagonal()
        .iter()
        .map(|d| d.ln())
        .sum::<f64>()
}
