//! Central differences of sixth order over seven samples, and fourth differences.
//!
//! x' = (45 (x₁ - x₋₁) - 9 (x₂ - x₋₂) + (x₃ - x₋₃)) / (60 h),
//! x'' = (270 (x₁ + x₋₁) - 27 (x₂ + x₋₂) + 2 (x₃ + x₋₃) - 490 x₀) / (180 h²).
//!
//! A frequency f is damped by the fraction (2π f h)⁶/140 and (2π f h)⁶/560: at 7 Hz and 100 Hz by
//! 5e-5 and 1e-5, where the plain central difference loses 3 %. The gain at high frequencies does
//! not matter, as the series is low-passed before. Source: Fornberg (1988), tables 1 and 2.

/// Differences of successive values.
pub(in crate::recording) fn steps(series: &[f64]) -> Vec<f64> {
    series.windows(2).map(|pair| pair[1] - pair[0]).collect()
}

/// First derivative of an even series with step h.
pub(in crate::recording) fn first(series: &[f64], step: f64) -> Vec<f64> {
    let scale = 1.0 / (60.0 * step);
    let combine =
        |x: [f64; 7]| (45.0 * (x[4] - x[2]) - 9.0 * (x[5] - x[1]) + (x[6] - x[0])) * scale;
    over_windows(series, combine)
}

/// Second derivative of an even series with step h.
pub(in crate::recording) fn second(series: &[f64], step: f64) -> Vec<f64> {
    let scale = 1.0 / (180.0 * step * step);
    let combine = |x: [f64; 7]| {
        let pairs = 270.0 * (x[4] + x[2]) - 27.0 * (x[5] + x[1]) + 2.0 * (x[6] + x[0]);
        (pairs - 490.0 * x[3]) * scale
    };
    over_windows(series, combine)
}

/// Fourth difference `Δ⁴x` of every `apart`-th sample from the first on, which hardly contains a motion; of white noise it
/// has 70 times the variance.
pub(in crate::recording) fn fourth(x: &[f64], apart: usize) -> f64 {
    x[0] - 4.0 * x[apart] + 6.0 * x[2 * apart] - 4.0 * x[3 * apart] + x[4 * apart]
}

/// Applies a seven-sample formula everywhere; beyond the ends the series is reflected oddly, which
/// touches three samples that the filter's edge covers.
fn over_windows(series: &[f64], combine: impl Fn([f64; 7]) -> f64) -> Vec<f64> {
    let n = series.len();
    let at = |index: isize| {
        let last = n as isize - 1;
        let inside = |index: isize| series[index.max(0).min(last) as usize];
        match index {
            i if i < 0 => 2.0 * series[0] - inside(-i),
            i if i > last => 2.0 * series[n - 1] - inside(2 * last - i),
            i => series[i as usize],
        }
    };
    (0..n as isize)
        .map(|k| {
            let interior = k >= 3 && k + 3 < n as isize;
            let start = (k - 3) as usize;
            combine(std::array::from_fn(|i| match interior {
                true => series[start + i],
                false => at(k + i as isize - 3),
            }))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matches_closed_form_derivatives_of_a_polynomial_of_sixth_degree() {
        let step = 0.1;
        let x = |k: usize| k as f64 * step;
        let series: Vec<f64> = (0..20).map(|k| x(k).powi(6) - x(k).powi(3)).collect();
        let (d, dd) = (first(&series, step), second(&series, step));
        for k in 3..17 {
            // The formulas are exact for this degree; rounding of 64 over a step of 0.1 or 0.01.
            assert!((d[k] - (6.0 * x(k).powi(5) - 3.0 * x(k).powi(2))).abs() < 1e-11);
            assert!((dd[k] - (30.0 * x(k).powi(4) - 6.0 * x(k))).abs() < 1e-9);
        }
    }

    /// Of t⁴ it is 24 h⁴, of a cubic nothing; of a single sample its binomial coefficients, whose squares add up to 70.
    #[test]
    fn matches_the_fourth_difference_of_powers() {
        let of = |power: i32| {
            let x: Vec<f64> = (0..9).map(|k| f64::from(k).powi(power)).collect();
            fourth(&x, 2)
        };
        assert_eq!(of(4), 24.0 * 16.0);
        assert_eq!((of(3), of(2), of(1), of(0)), (0.0, 0.0, 0.0, 0.0));
        let single = |at: usize| {
            let mut x = [0.0; 5];
            x[at] = 1.0;
            fourth(&x, 1)
        };
        assert_eq!([0, 1, 2, 3, 4].map(single), [1.0, -4.0, 6.0, -4.0, 1.0]);
    }
}
