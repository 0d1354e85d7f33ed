//! The natural cubic spline through samples at increasing times: s'' is linear between knots, zero at both ends, and makes
//! s' continuous.

/// A spline through (knots, values).
pub(in crate::recording) struct Spline<'a> {
    knots: &'a [f64],
    values: &'a [f64],
    /// s'' at the knots.
    bend: Vec<f64>,
}

impl<'a> Spline<'a> {
    pub fn new(knots: &'a [f64], values: &'a [f64]) -> Self {
        Self {
            knots,
            values,
            bend: second_derivatives(knots, values),
        }
    }

    /// Values at increasing times between the first and the last knot.
    pub fn at(&self, times: &[f64]) -> Vec<f64> {
        let Self {
            knots,
            values,
            bend,
        } = self;
        let mut at = 0;
        let mut out = Vec::with_capacity(times.len());
        for &t in times {
            while at + 2 < knots.len() && knots[at + 1] <= t {
                at += 1;
            }
            let step = knots[at + 1] - knots[at];
            let (a, b) = ((knots[at + 1] - t) / step, (t - knots[at]) / step);
            let curve = (a.powi(3) - a) * bend[at] + (b.powi(3) - b) * bend[at + 1];
            out.push(a * values[at] + b * values[at + 1] + curve * step * step / 6.0);
        }
        out
    }
}

/// `h_k s''_k + 2 (h_k + h_{k+1}) s''_{k+1} + h_{k+1} s''_{k+2} = 6 (slope_{k+1} − slope_k)`, by elimination.
fn second_derivatives(knots: &[f64], values: &[f64]) -> Vec<f64> {
    let count = knots.len();
    let step = |k: usize| knots[k + 1] - knots[k];
    let slope = |k: usize| (values[k + 1] - values[k]) / step(k);
    let mut bend = vec![0.0; count];
    let mut share = vec![0.0; count];
    for k in 1..count.saturating_sub(1) {
        let pivot = 2.0 * (step(k - 1) + step(k)) - step(k - 1) * share[k - 1];
        share[k] = step(k) / pivot;
        bend[k] = (6.0 * (slope(k) - slope(k - 1)) - step(k - 1) * bend[k - 1]) / pivot;
    }
    for k in (1..count.saturating_sub(1)).rev() {
        bend[k] -= share[k] * bend[k + 1];
    }
    bend
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors of a natural spline fall with the fourth power of the step away from its ends.
    #[test]
    fn matches_a_smooth_motion_between_uneven_samples() {
        let worst = |rate: f64| {
            let knots: Vec<f64> = (0..(4.0 * rate) as usize)
                .map(|k| (k as f64 + 0.2 * (k as f64).sin()) / rate)
                .collect();
            let values: Vec<f64> = knots.iter().map(|t| (3.0 * t).sin()).collect();
            let times: Vec<f64> = (0..2000).map(|k| 1.0 + k as f64 / 1000.0).collect();
            let found = Spline::new(&knots, &values).at(&times);
            let errors = found
                .iter()
                .zip(&times)
                .map(|(s, t)| (s - (3.0 * t).sin()).abs());
            errors.fold(0.0, f64::max)
        };
        // 5/384 h⁴ |q''''| with q'''' of 81 and steps of at most 1.4 of the mean.
        let bound = |rate: f64| 5.0 / 384.0 * (1.4 / rate).powi(4) * 81.0;
        for rate in [20.0, 40.0, 80.0] {
            assert!(worst(rate) < bound(rate), "{} at {rate} Hz", worst(rate));
        }
    }

    /// s' is continuous at every knot between the ends, where s'' is zero.
    #[test]
    fn matches_its_defining_equations() {
        let knots = [0.0, 0.4, 1.0, 1.1, 2.0, 2.3];
        let values = [1.0, -2.0, 0.5, 0.7, 3.0, -1.0];
        let spline = Spline::new(&knots, &values);
        assert_eq!((spline.bend[0], spline.bend[5]), (0.0, 0.0));
        for k in 1..5 {
            let (before, after) = (knots[k] - knots[k - 1], knots[k + 1] - knots[k]);
            let slopes = [
                (values[k] - values[k - 1]) / before,
                (values[k + 1] - values[k]) / after,
            ];
            let left = before * spline.bend[k - 1]
                + 2.0 * (before + after) * spline.bend[k]
                + after * spline.bend[k + 1];
            let right = 6.0 * (slopes[1] - slopes[0]);
            assert!((left - right).abs() < 1e-10, "{k}: {left} {right}");
        }
        for (found, value) in spline.at(&knots).iter().zip(values) {
            assert!((found - value).abs() < 1e-14);
        }
    }
}
