//! The interval of a ratio θ = n/d of two estimates with normal errors (Fieller 1954): all θ with
//!
//! ```text
//! (n − θ d)² ≤ z² (V_nn − 2 θ V_nd + θ² V_dd)
//! ```
//!
//! It is not symmetric about n/d, and holds the truth as often as it says however uncertain d is, where n/d ± z σ from
//! derivatives does not.

/// Two estimates with their variances and covariance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ratio {
    /// n
    pub numerator: f64,
    /// d
    pub denominator: f64,
    /// V_nn
    pub numerator_variance: f64,
    /// V_dd
    pub denominator_variance: f64,
    /// V_nd
    pub covariance: f64,
}

impl Ratio {
    /// The interval for the two-sided quantile z of the normal distribution; `None` where the interval of the denominator
    /// holds zero, and that of the ratio is not bounded.
    pub fn interval(&self, quantile: f64) -> Option<[f64; 2]> {
        let z2 = quantile * quantile;
        let a = self.denominator.powi(2) - z2 * self.denominator_variance;
        let b = self.numerator * self.denominator - z2 * self.covariance;
        let c = self.numerator.powi(2) - z2 * self.numerator_variance;
        let root = b * b - a * c;
        // Rounding may leave less than nothing of an interval that is a point.
        (a > 0.0).then(|| {
            let half = root.max(0.0).sqrt();
            [(b - half) / a, (b + half) / a]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    const QUANTILE: f64 = 1.959_963_984_540_054;

    #[test]
    fn a_certain_denominator_leaves_the_normal_interval() {
        let ratio = Ratio {
            numerator: 3.0,
            denominator: 2.0,
            numerator_variance: 0.04,
            denominator_variance: 0.0,
            covariance: 0.0,
        };
        let [low, high] = ratio.interval(QUANTILE).unwrap();
        let half = QUANTILE * 0.2 / 2.0;
        assert!((low - (1.5 - half)).abs() < 1e-12 && (high - (1.5 + half)).abs() < 1e-12);
    }

    #[test]
    fn the_ends_of_an_inverse_are_the_inverses_of_the_ends() {
        let ratio = |denominator: f64| Ratio {
            numerator: 1.0,
            denominator,
            numerator_variance: 0.0,
            denominator_variance: 0.01,
            covariance: 0.0,
        };
        let [low, high] = ratio(0.3).interval(QUANTILE).unwrap();
        let half = QUANTILE * 0.1;
        assert!((low - 1.0 / (0.3 + half)).abs() < 1e-9);
        assert!((high - 1.0 / (0.3 - half)).abs() < 1e-9);
        assert_eq!(ratio(0.19).interval(QUANTILE), None);
    }

    #[test]
    fn intervals_hold_the_truth_as_often_as_they_say() {
        // Errors of a third of the denominator, correlated with those of the numerator.
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let (truth, draws) = ([2.0, 1.0], 4000);
        let holds = (0..draws).filter(|_| {
            let (u, v): (f64, f64) = (rng.sample(StandardNormal), rng.sample(StandardNormal));
            let ratio = Ratio {
                numerator: truth[0] + 0.3 * u + 0.1 * v,
                denominator: truth[1] + 0.3 * v,
                numerator_variance: 0.1,
                denominator_variance: 0.09,
                covariance: 0.03,
            };
            // Without bounds it holds everything.
            let interval = ratio.interval(QUANTILE);
            interval.is_none_or(|[low, high]| (low..=high).contains(&(truth[0] / truth[1])))
        });
        let share = holds.count() as f64 / f64::from(draws);
        // Four standard deviations of a share of so many; the unbounded ones add at most what exceeds 95 %.
        assert!(
            share > 0.95 - 4.0 * (0.95 * 0.05 / f64::from(draws)).sqrt(),
            "{share}"
        );
        assert!(share < 0.985, "{share}");
    }
}
