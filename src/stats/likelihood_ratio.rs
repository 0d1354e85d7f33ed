//! The test of a likelihood ratio: whether a model fits better than parameters without a meaning would make it (Wilks 1938).

use crate::stats::distribution::Distribution;

/// Twice the logarithm of the likelihood ratio, or the weighted squares, that one parameter without a meaning takes in the mean (Wilks
/// 1938): searches that end closer have come to one optimum, as far as data tell.
pub const BY_CHANCE: f64 = 1.0;

/// Whether twice the logarithm of a likelihood ratio is larger than further parameters without a meaning make it with a
/// probability: the quantile of χ² of as many degrees of freedom.
pub fn is_beyond_chance(twice_logarithm: f64, parameters: usize, confidence: f64) -> bool {
    let freedom = parameters as f64;
    twice_logarithm > Distribution::ChiSquared { freedom }.quantile(confidence)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Percentage points of χ²: 6.635 and 9.210 at 99 %, 3.841 at 95 % (Abramowitz and Stegun 1964, table 26.8).
    #[test]
    fn the_bound_is_that_of_the_tables() {
        for (bound, parameters, confidence) in
            [(6.635, 1, 0.99), (9.210, 2, 0.99), (3.841, 1, 0.95)]
        {
            assert!(is_beyond_chance(bound + 1e-3, parameters, confidence));
            assert!(!is_beyond_chance(bound - 1e-3, parameters, confidence));
        }
    }
}
