//! What the errors of estimated parameters add to sums over residuals.

use nalgebra::DVector;
use std::borrow::Cow;

/// Errors δθ of the estimated parameters of the poorer model, which move its residuals by J δθ.
#[derive(Clone, Copy)]
pub struct EstimationError<'a> {
    /// J, `[channel][parameter][row]`; `None` where a channel does not depend on a parameter.
    pub derivatives: &'a [Vec<Option<Vec<f64>>>],
    /// Rows of J that the residuals are of, per channel; all where there is no list.
    pub kept: &'a [Option<Vec<bool>>],
    /// `gᵀ C g`, with the covariance C of the parameters that the data determine.
    pub variance: &'a dyn Fn(&DVector<f64>) -> f64,
}

impl EstimationError<'_> {
    /// `gᵀ C g`, `g = Jᵀ w`: the variance of the sum of residuals times weights `[channel][row]`.
    pub fn variance(&self, weights: &[Vec<f64>]) -> f64 {
        let parameters = self.derivatives.iter().map(Vec::len).max().unwrap_or(0);
        let mut product = DVector::zeros(parameters);
        let channels = self.derivatives.iter().zip(weights).zip(self.kept);
        for ((columns, weights), kept) in channels {
            let weights = in_place(weights, kept.as_deref());
            for (k, column) in columns.iter().enumerate() {
                let column = column.as_deref().unwrap_or_default();
                let products = column.iter().zip(weights.iter()).map(|(j, w)| j * w);
                product[k] += products.sum::<f64>();
            }
        }
        (self.variance)(&product).max(0.0)
    }
}

/// Weights of kept rows among all rows; the others have none.
fn in_place<'w>(weights: &'w [f64], kept: Option<&[bool]>) -> Cow<'w, [f64]> {
    let Some(kept) = kept else {
        return Cow::Borrowed(weights);
    };
    let mut own = weights.iter();
    let of = |kept: &bool| if *kept { own.next().copied() } else { None };
    kept.iter().map(of).map(Option::unwrap_or_default).collect()
}
