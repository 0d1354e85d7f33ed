//! Scales and weights that a few gross errors do not move.
//!
//! A weight is psi(u) / u of the normalised residual u = r / scale. Source: Huber and Ronchetti (2009).

/// Makes the median absolute deviation of normal noise its standard deviation: 1 / Φ⁻¹(3/4).
const MAD_TO_SIGMA: f64 = 1.482_602_218_505_602;

/// Huber's threshold for 95 % efficiency under normal noise, in standard deviations.
pub const HUBER_THRESHOLD: f64 = 1.345;

/// Tukey's threshold for 95 % efficiency under normal noise, in standard deviations.
pub const TUKEY_THRESHOLD: f64 = 4.685;

/// The median; `None` without values or with one that is NaN.
pub fn median(values: &[f64]) -> Option<f64> {
    if values.is_empty() || values.iter().any(|v| v.is_nan()) {
        return None;
    }
    let mut values = values.to_vec();
    let count = values.len();
    let (below, upper, _) = values.select_nth_unstable_by(count / 2, f64::total_cmp);
    let upper = *upper;
    if count % 2 == 1 {
        return Some(upper);
    }
    let lower = below.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Some(0.5 * (lower + upper))
}

/// The value up to which a share of some values lies, of at least one.
pub fn quantile(values: &mut [f64], share: f64) -> f64 {
    let at = (share * (values.len() - 1) as f64) as usize;
    ranked(values, at)
}

/// The value that has so many others below it, in the order of [`f64::total_cmp`]; puts the values in another order.
pub fn ranked(values: &mut [f64], below: usize) -> f64 {
    *values.select_nth_unstable_by(below, f64::total_cmp).1
}

/// Standard deviation of normal noise from the median absolute deviation about the median.
pub fn mad_scale(values: &[f64]) -> Option<f64> {
    let centre = median(values)?;
    let deviations: Vec<f64> = values.iter().map(|v| (v - centre).abs()).collect();
    Some(normal_scale(median(&deviations)?))
}

/// Standard deviation of normal noise that forgets from row to row, by the median size of the steps from one to the next:
/// what changes slowly does not enter it, nor do jumps of a few rows.
pub fn scale_of_steps(series: &[f64]) -> Option<f64> {
    let steps: Vec<f64> = series.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
    Some(normal_scale(median(&steps)?) / std::f64::consts::SQRT_2)
}

/// Standard deviation of normal values whose sizes have this median.
pub fn normal_scale(median_size: f64) -> f64 {
    MAD_TO_SIGMA * median_size
}

/// 1 for |u| <= threshold, else threshold / |u|.
pub fn huber_weight(u: f64, threshold: f64) -> f64 {
    if u.abs() <= threshold {
        1.0
    } else {
        threshold / u.abs()
    }
}

/// (1 - (u / threshold)²)² for |u| <= threshold, else 0.
pub fn tukey_weight(u: f64, threshold: f64) -> f64 {
    let ratio = u / threshold;
    if ratio.abs() <= 1.0 {
        (1.0 - ratio * ratio).powi(2)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::distribution::Distribution;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    /// Noise about a slow sine, with jumps at a hundredth of the rows. The scale of n independent steps has the deviation
    /// 1.17 σ / √n (Rousseeuw and Croux 1993); every second step shares no row with another. Two steps in a hundred lead to or
    /// from a jump, so the scale is that of 51 in 100 of the others: 2.4 % larger.
    #[test]
    fn recovers_the_noise_beside_what_is_slow_and_what_jumps() {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let (count, sigma) = (4000, 0.2);
        let series: Vec<f64> = (0..count)
            .map(|k| {
                let noise: f64 = rng.sample(StandardNormal);
                let jump = if k % 100 == 50 { 10.0 } else { 0.0 };
                (0.002 * k as f64).sin() + sigma * noise + jump
            })
            .collect();
        let scale = scale_of_steps(&series).unwrap();
        let error = 3.0 * 1.17 * sigma / (count as f64 / 2.0).sqrt();
        assert!((scale - 1.024 * sigma).abs() < error, "{scale}");
        assert_eq!(scale_of_steps(&[1.0]), None);
    }

    #[test]
    fn matches_closed_forms_of_the_median() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), Some(2.5));
        assert_eq!(median(&[5.0]), Some(5.0));
        assert_eq!(median(&[]), None);
        assert_eq!(median(&[1.0, f64::NAN]), None);
    }

    #[test]
    fn recovers_known_scale_of_normal_quantiles_with_gross_errors() {
        let count = 2001;
        let level = |i: usize| (i as f64 + 0.5) / count as f64;
        let mut values: Vec<f64> = (0..count)
            .map(|i| 3.0 + 2.0 * Distribution::Normal.quantile(level(i)))
            .collect();
        // The quartile is met to a spacing of 1 / count over the density 0.32 there.
        assert!((mad_scale(&values).unwrap() / 2.0 - 1.0).abs() <= 5.0 / count as f64);
        for value in values.iter_mut().take(100) {
            *value = 1e9;
        }
        assert!((mad_scale(&values).unwrap() / 2.0 - 1.0).abs() <= 0.1);
    }

    #[test]
    fn matches_the_definitions_of_the_weights() {
        assert_eq!(huber_weight(-2.69, HUBER_THRESHOLD), 0.5);
        assert_eq!(huber_weight(1.0, HUBER_THRESHOLD), 1.0);
        assert_eq!(tukey_weight(0.0, TUKEY_THRESHOLD), 1.0);
        assert_eq!(tukey_weight(2.0, 4.0), 0.5625);
        assert_eq!(tukey_weight(4.7, TUKEY_THRESHOLD), 0.0);
    }
}
