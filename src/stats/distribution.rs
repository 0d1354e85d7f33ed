//! Tails and quantiles of the distributions that tests and confidence intervals need.
//!
//! Tails are those of `statrs`. Quantiles invert them by bisection to the last bit, because the inverses of
//! that crate stop after sixteen halvings in places; small upper tails keep their relative accuracy.

use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, Normal, StudentsT};

/// A distribution with its degrees of freedom, which are > 0 and need not be integers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Distribution {
    /// Mean zero, variance one.
    Normal,
    /// Student's t: a normal value over a root of an independent χ² over its degrees of freedom.
    StudentT {
        /// Degrees of freedom.
        freedom: f64,
    },
    /// χ²: a sum of squares of independent normal values.
    ChiSquared {
        /// Degrees of freedom.
        freedom: f64,
    },
    /// Fisher's F: the ratio of two independent χ², each over its degrees of freedom.
    FisherF {
        /// Degrees of freedom above the line.
        numerator: f64,
        /// Degrees of freedom below the line.
        denominator: f64,
    },
}

/// Doublings that bracket a quantile: up to 2^1000.
const LARGEST_EXPONENT: i32 = 1000;

impl Distribution {
    /// Of the ratio of two mean squares of the same variance, with as many degrees of freedom each.
    pub fn variance_ratio(freedom: f64) -> Self {
        Self::FisherF {
            numerator: freedom,
            denominator: freedom,
        }
    }

    /// P(X > x); NaN where a degree of freedom is not a positive number or x is NaN.
    pub fn upper_tail(self, x: f64) -> f64 {
        self.tails(x).map_or(f64::NAN, |(_, upper)| upper)
    }

    /// P(X <= x); NaN as above.
    pub fn lower_tail(self, x: f64) -> f64 {
        self.tails(x).map_or(f64::NAN, |(lower, _)| lower)
    }

    /// The x with P(X > x) = tail, 0 < tail < 1; NaN outside.
    pub fn upper_quantile(self, tail: f64) -> f64 {
        if !(tail > 0.0 && tail < 1.0) || self.tails(1.0).is_none() {
            return f64::NAN;
        }
        if !self.is_symmetric() {
            return invert(|x| self.upper_tail(x) > tail);
        }
        let half = tail.min(1.0 - tail);
        let x = invert(|x| self.upper_tail(x) > half);
        if tail <= 0.5 { x } else { -x }
    }

    /// The x with P(X <= x) = level, 0 < level < 1; NaN outside.
    pub fn quantile(self, level: f64) -> f64 {
        if !(level > 0.0 && level < 1.0) || self.tails(1.0).is_none() {
            return f64::NAN;
        }
        if self.is_symmetric() {
            return -self.upper_quantile(level);
        }
        invert(|x| self.lower_tail(x) < level)
    }

    /// Half-width in standard errors of the two-sided interval with this coverage, such as 0.95.
    pub fn two_sided(self, coverage: f64) -> f64 {
        self.upper_quantile(0.5 * (1.0 - coverage))
    }

    fn is_symmetric(self) -> bool {
        matches!(self, Self::Normal | Self::StudentT { .. })
    }

    /// P(X <= x) and P(X > x).
    fn tails(self, x: f64) -> Option<(f64, f64)> {
        if x.is_nan() {
            return None;
        }
        fn of(d: &impl ContinuousCDF<f64, f64>, x: f64) -> (f64, f64) {
            (d.cdf(x), d.sf(x))
        }
        match self {
            Self::Normal => Normal::new(0.0, 1.0).ok().map(|d| of(&d, x)),
            Self::StudentT { freedom } => StudentsT::new(0.0, 1.0, freedom).ok().map(|d| of(&d, x)),
            Self::ChiSquared { freedom } => ChiSquared::new(freedom).ok().map(|d| of(&d, x)),
            Self::FisherF {
                numerator,
                denominator,
            } => FisherSnedecor::new(numerator, denominator)
                .ok()
                .map(|d| of(&d, x)),
        }
    }
}

/// The positive x at which `is_below` turns from true to false.
fn invert(is_below: impl Fn(f64) -> bool) -> f64 {
    let mut high = 1.0;
    for _ in 0..LARGEST_EXPONENT {
        if !is_below(high) {
            break;
        }
        high *= 2.0;
    }
    let mut low = 0.0;
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return high;
        }
        if is_below(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative accuracy of the incomplete gamma and beta functions of `statrs`.
    const ACCURACY: f64 = 1e-11;

    fn close(found: f64, expected: f64) {
        assert!(
            (found / expected - 1.0).abs() <= ACCURACY,
            "{found} {expected}"
        );
    }

    #[test]
    fn matches_published_quantiles() {
        // Abramowitz and Stegun, tables 26.1 and 26.10, with digits from the defining integrals.
        close(Distribution::Normal.quantile(0.975), 1.959963984540054);
        close(Distribution::Normal.two_sided(0.95), 1.959963984540054);
        close(
            Distribution::Normal.upper_quantile(1e-10),
            6.361340902404056,
        );
    }

    #[test]
    fn matches_closed_forms() {
        for x in [0.1, 1.0, 7.0, 60.0] {
            // Chi-squared with two degrees: exp(-x / 2); Cauchy: 1/2 - atan(x) / pi.
            close(
                Distribution::ChiSquared { freedom: 2.0 }.upper_tail(x),
                (-0.5 * x).exp(),
            );
            let cauchy = (1.0 / x).atan() / std::f64::consts::PI;
            close(
                Distribution::StudentT { freedom: 1.0 }.upper_tail(x),
                cauchy,
            );
            // F(2, n): (1 + 2 x / n)^(-n / 2).
            let f = Distribution::FisherF {
                numerator: 2.0,
                denominator: 10.0,
            };
            close(f.upper_tail(x), (1.0 + 0.2 * x).powi(-5));
        }
        let f = Distribution::FisherF {
            numerator: 2.0,
            denominator: 10.0,
        };
        for tail in [0.5, 1e-3, 1e-12] {
            close(f.upper_quantile(tail), 5.0 * (f64::powf(tail, -0.2) - 1.0));
            close(
                Distribution::ChiSquared { freedom: 2.0 }.upper_quantile(tail),
                -2.0 * tail.ln(),
            );
        }
    }

    #[test]
    fn invariant_large_freedom_is_the_normal_limit() {
        let t = Distribution::StudentT { freedom: 1e7 };
        assert!((t.quantile(0.975) - 1.959963984540054).abs() <= 1e-6);
        // F(1, n) is the square of Student's t.
        for freedom in [3.0, 1e3, 1e5] {
            let f = Distribution::FisherF {
                numerator: 1.0,
                denominator: freedom,
            };
            let t = Distribution::StudentT { freedom };
            assert!((f.upper_tail(4.0) / (2.0 * t.upper_tail(2.0)) - 1.0).abs() <= 1e-9);
        }
    }

    #[test]
    fn invariant_quantiles_invert_tails() {
        for d in [
            Distribution::Normal,
            Distribution::StudentT { freedom: 4.5 },
            Distribution::ChiSquared { freedom: 17.0 },
            Distribution::FisherF {
                numerator: 3.0,
                denominator: 40.0,
            },
        ] {
            for level in [1e-6, 0.2, 0.5, 0.9, 0.999] {
                assert!(
                    (d.lower_tail(d.quantile(level)) - level).abs() <= 1e-12,
                    "{d:?} {level}"
                );
                assert!(
                    (d.upper_tail(d.upper_quantile(level)) - level).abs() <= 1e-12,
                    "{d:?} {level}"
                );
            }
        }
    }

    #[test]
    fn input_without_meaning_gives_nan() {
        assert!(
            Distribution::StudentT { freedom: 0.0 }
                .quantile(0.9)
                .is_nan()
        );
        assert!(
            Distribution::ChiSquared { freedom: f64::NAN }
                .upper_tail(1.0)
                .is_nan()
        );
        assert!(Distribution::Normal.quantile(1.0).is_nan());
        for level in [-0.1, 0.0, 1.0, 1.1] {
            let d = Distribution::ChiSquared { freedom: 3.0 };
            assert!(d.quantile(level).is_nan() && d.upper_quantile(level).is_nan());
        }
        assert!(Distribution::Normal.upper_tail(f64::NAN).is_nan());
    }
}
