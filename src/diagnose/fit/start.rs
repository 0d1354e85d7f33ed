//! Initial values of a fit.

/// Parameter values by name.
pub type Start = Vec<(String, f64)>;

/// Values from which a fit begins, and the deviations of the residuals of each channel that weight it until its own are
/// known.
#[derive(Debug, Clone)]
pub struct WarmStart {
    /// By names of parameters.
    pub values: Start,
    /// Of each channel, in the unit of its signal.
    pub deviations: Vec<f64>,
}

impl WarmStart {
    /// The same with other values for some parameters, or values of further ones.
    pub fn with(&self, values: &[(String, f64)]) -> Self {
        let mut all = self.clone();
        all.values.extend_from_slice(values);
        all
    }
}
