//! Joints with motors of one type: whether their torque constants are equal.

use crate::stats::distribution::Distribution;

/// A torque constant with its standard deviation, N·m/A.
pub type Constant = (f64, f64);

/// The test that the torque constants of several joints are equal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Equality {
    /// Mean, weighted by the variances.
    pub mean: f64,
    /// Σ (k − mean)² / σ², chi-squared with one degree of freedom less than joints.
    pub chi_squared: f64,
    /// Probability of such a sum, or a larger one, where the constants are equal.
    pub p_value: f64,
}

/// None for fewer than two constants, or one without uncertainty.
pub fn equality(constants: &[Constant]) -> Option<Equality> {
    if constants.len() < 2 || constants.iter().any(|c| c.1 <= 0.0) {
        return None;
    }
    let weight: f64 = constants.iter().map(|c| c.1.powi(-2)).sum();
    let mean = constants.iter().map(|c| c.0 * c.1.powi(-2)).sum::<f64>() / weight;
    let chi_squared = constants
        .iter()
        .map(|(k, sigma)| ((k - mean) / sigma).powi(2))
        .sum();
    let freedom = (constants.len() - 1) as f64;
    Some(Equality {
        mean,
        chi_squared,
        p_value: Distribution::ChiSquared { freedom }.upper_tail(chi_squared),
    })
}

/// The constant that a further joint of the type has, with the spread from joint to joint; None without
/// a joint to go by.
pub fn of_same_type(constants: &[Constant]) -> Option<Constant> {
    if constants.is_empty() {
        return None;
    }
    let count = constants.len() as f64;
    let mean = constants.iter().map(|c| c.0).sum::<f64>() / count;
    let own = constants.iter().map(|c| c.1 * c.1).sum::<f64>() / count;
    let spread: f64 = constants.iter().map(|c| (c.0 - mean).powi(2)).sum();
    let between = if count > 1.0 {
        spread / (count - 1.0)
    } else {
        0.0
    };
    // The further joint scatters like the others, and the mean of the others has its own error.
    Some((mean, (between * (1.0 + 1.0 / count) + own / count).sqrt()))
}
