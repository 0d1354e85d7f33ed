//! What the errors of estimated parameters add to sums over residuals.

use nalgebra::{DMatrix, DVector};

/// Errors δθ of the estimated parameters of the poorer model, which move its residuals by J δθ.
#[derive(Debug, Clone)]
pub struct EstimationError {
    /// J, `[channel][parameter][row]`; `None` where a channel does not depend on a parameter.
    pub derivatives: Vec<Vec<Option<Vec<f64>>>>,
    /// Of the parameters; those of infinite variance are left out.
    pub covariance: DMatrix<f64>,
}

impl EstimationError {
    /// `gᵀ C g`, `g = Jᵀ w`: the variance of the sum of residuals times weights `[channel][row]`.
    pub fn variance(&self, weights: &[Vec<f64>]) -> f64 {
        let of = |k: usize| {
            let channels = self.derivatives.iter().zip(weights);
            let products = channels.filter_map(|(columns, weights)| {
                let column = columns[k].as_ref()?;
                Some(column.iter().zip(weights).map(|(j, w)| j * w).sum::<f64>())
            });
            match self.covariance[(k, k)].is_finite() {
                true => products.sum(),
                false => 0.0,
            }
        };
        let product = DVector::from_fn(self.covariance.nrows(), |k, _| of(k));
        let determined = self
            .covariance
            .map(|entry| if entry.is_finite() { entry } else { 0.0 });
        product.dot(&(determined * &product)).max(0.0)
    }
}
