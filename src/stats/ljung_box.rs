//! The test of Ljung and Box (1978) that a series is white:
//! Q = n (n + 2) Σ rho_k² / (n - k), k = 1..lags, chi-squared with lags - fitted degrees of freedom.

use crate::stats::distribution::Distribution;

/// The outcome of the test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LjungBox {
    /// Q.
    pub statistic: f64,
    /// Degrees of freedom, lags less fitted parameters.
    pub freedom: f64,
    /// Probability of a statistic at least as large for a white series.
    pub p_value: f64,
}

/// Tests a series of mean zero, `fitted` parameters of its own model having been estimated.
///
/// `None` if lags <= fitted, lags >= n, or the series is constant zero.
pub fn ljung_box(series: &[f64], lags: usize, fitted: usize) -> Option<LjungBox> {
    let count = series.len();
    if lags <= fitted || lags >= count {
        return None;
    }
    let power: f64 = series.iter().map(|v| v * v).sum();
    if power <= 0.0 || !power.is_finite() {
        return None;
    }
    let n = count as f64;
    let correlation = |k: usize| {
        let products = series[k..].iter().zip(series).map(|(a, b)| a * b);
        products.sum::<f64>() / power
    };
    let sum: f64 = (1..=lags)
        .map(|k| correlation(k).powi(2) / (n - k as f64))
        .sum();
    let (statistic, freedom) = (n * (n + 2.0) * sum, (lags - fitted) as f64);
    let p_value = Distribution::ChiSquared { freedom }.upper_tail(statistic);
    Some(LjungBox {
        statistic,
        freedom,
        p_value,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matches_closed_form_of_an_alternating_series() {
        // rho_1 = -(n - 1) / n, so Q = n (n + 2) (n - 1) / n² with one lag.
        let series: Vec<f64> = (0..10)
            .map(|i| if i % 2 == 0 { 1.0 } else { -1.0 })
            .collect();
        let found = ljung_box(&series, 1, 0).unwrap();
        assert!((found.statistic - 10.8).abs() <= 1e-12);
        assert!(found.p_value < 0.002);
    }

    /// rho_2 = (n - 2) / n beside it: Q = 120 (0.81/9 + 0.64/8); with one of two degrees of freedom taken, that is the square of
    /// a normal number of 4.5166, whose tails are 6.28e-6.
    #[test]
    fn matches_closed_form_of_two_lags_with_a_parameter_fitted() {
        let series: Vec<f64> = (0..10)
            .map(|i| if i % 2 == 0 { 3.0 } else { -3.0 })
            .collect();
        let found = ljung_box(&series, 2, 1).unwrap();
        assert!((found.statistic - 20.4).abs() <= 1e-12);
        assert_eq!(found.freedom, 1.0);
        let tails = 2.0 * Distribution::Normal.upper_tail(20.4_f64.sqrt());
        assert!((found.p_value / tails - 1.0).abs() < 1e-9, "{found:?}");
        assert!((found.p_value / 6.28e-6 - 1.0).abs() < 1e-2, "{found:?}");
    }

    #[test]
    fn refuses_what_cannot_be_tested() {
        assert_eq!(ljung_box(&[1.0, 2.0], 2, 0), None);
        assert_eq!(ljung_box(&[0.0; 9], 2, 0), None);
        assert_eq!(ljung_box(&[1.0; 9], 2, 2), None);
    }
}
