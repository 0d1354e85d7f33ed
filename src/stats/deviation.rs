//! Root mean squares and ranges of series and of several channels.

/// Root mean square; 0 of none.
pub fn rms(series: &[f64]) -> f64 {
    let squares: f64 = series.iter().map(|x| x * x).sum();
    (squares / series.len().max(1) as f64).sqrt()
}

/// Root mean square; 1 where there is nothing.
pub fn deviation(series: &[f64]) -> f64 {
    match rms(series) {
        deviation if deviation > 0.0 => deviation,
        _ => 1.0,
    }
}

/// Deviations of the residuals of each channel.
pub fn deviations(residuals: &[Vec<f64>]) -> Vec<f64> {
    residuals.iter().map(|e| deviation(e)).collect()
}

/// Highest less lowest value; −∞ of none.
pub fn range(series: &[f64]) -> f64 {
    let low = series.iter().copied().fold(f64::INFINITY, f64::min);
    let high = series.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    high - low
}

/// Mean square of the differences of rows so many rows apart, halved: the variance of noise that forgets within them,
/// which what changes slowly does not enter (von Neumann 1941).
pub fn of_steps(series: &[f64], apart: usize) -> f64 {
    let pairs = series.iter().zip(series.get(apart..).unwrap_or_default());
    let squares: f64 = pairs.map(|(a, b)| (b - a).powi(2)).sum();
    0.5 * squares / (series.len().max(apart + 1) - apart) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matches_roots_of_means_of_squares() {
        assert_eq!(rms(&[3.0, -4.0, 0.0, 5.0]), 12.5_f64.sqrt());
        assert_eq!(rms(&[]), 0.0);
        assert_eq!(range(&[3.0, -4.0, 0.0, 5.0]), 9.0);
        assert_eq!(deviation(&[0.0, 0.0]), 1.0);
        assert_eq!(deviations(&[vec![2.0; 9], Vec::new()]), [2.0, 1.0]);
    }
}
