//! Values of many groups that scatter more than their own errors: mean and spread of the population, and what one group
//! borrows from it.
//!
//! ```text
//! x_r ~ N(θ_r, v_r),   θ_r ~ N(μ, τ²)
//! ```
//!
//! τ² solves the estimating equation of Paule and Mandel (1982), with the median of the squares in the place of their
//! mean: `median (x_r − μ)²/(v_r + τ²) = median of χ²₁`. Up to half of the groups may then be anything (Hampel 1974, on the
//! median absolute deviation). μ is Huber's M-estimate with weights `1/(v_r + τ²)` (Huber and Ronchetti 2009). The
//! estimate of a group given the population is empirical Bayes (Morris 1983).

use crate::stats::change_point::Mean;
use crate::stats::robust::{HUBER_THRESHOLD, huber_weight, median};

/// Median of χ² with one degree of freedom: Φ⁻¹(3/4)².
const MEDIAN_OF_SQUARE: f64 = 0.454_936_423_119_572_8;

/// A squared difference, the variance that is known of it, and how often the unknown variance is in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Square {
    /// Square of the difference.
    pub square: f64,
    /// Known part of its variance, in the unit of the square.
    pub variance: f64,
    /// Times that ω² is in its variance: 1 of a value about a known mean, 2 between two values.
    pub times: f64,
}

/// The variance beyond what is known: the least ω² ≥ 0 with `median square/(variance + times·ω²) ≤ median of χ²₁`;
/// 0 without squares.
pub fn excess_variance(squares: &[Square]) -> f64 {
    let middle = |excess: f64| {
        let ratios = squares
            .iter()
            .map(|s| s.square / (s.variance + s.times * excess));
        median(&ratios.collect::<Vec<f64>>()).unwrap_or(0.0)
    };
    if middle(0.0) <= MEDIAN_OF_SQUARE {
        return 0.0;
    }
    let largest = squares.iter().map(|s| s.square / s.times);
    let (mut low, mut high) = (0.0, largest.fold(0.0, f64::max) / MEDIAN_OF_SQUARE);
    // To the last digits that an estimate of a variance can use.
    while high - low > 1e-9 * high {
        let half = 0.5 * (low + high);
        if middle(half) > MEDIAN_OF_SQUARE {
            low = half;
        } else {
            high = half;
        }
    }
    high
}

/// The groups of one kind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Population {
    /// μ and the variance of its estimate.
    pub mean: Mean,
    /// τ.
    pub spread: f64,
    /// How many groups it is of.
    pub groups: usize,
}

/// Groups from which on a spread is estimated: the median of fewer squares about their own mean says nothing.
pub const LEAST_GROUPS: usize = 5;

/// Rounds between mean and spread, which settle within a few.
const ROUNDS: usize = 20;

/// Efficiency of the median absolute deviation as a scale, of Huber's mean about one.
const EFFICIENCY_OF_MEDIAN: f64 = 0.37;

impl Population {
    /// Of groups by their own means; `None` of fewer than [`LEAST_GROUPS`].
    pub fn of(groups: &[Mean]) -> Option<Self> {
        if groups.len() < LEAST_GROUPS {
            return None;
        }
        let values: Vec<f64> = groups.iter().map(|g| g.value).collect();
        let count = groups.len() as f64;
        let mut mean = Mean {
            value: median(&values)?,
            variance: 0.0,
        };
        let mut excess = 0.0;
        for _ in 0..ROUNDS {
            let square = |group: &Mean| Square {
                // About a mean that the group itself has a part in.
                square: (group.value - mean.value).powi(2) * count / (count - 1.0),
                variance: group.variance,
                times: 1.0,
            };
            excess = excess_variance(&groups.iter().map(square).collect::<Vec<_>>());
            mean = huber_mean(groups, excess, mean.value);
        }
        Some(Self {
            mean,
            spread: excess.sqrt(),
            groups: groups.len(),
        })
    }

    /// How many degrees of freedom the spread is worth.
    pub fn freedom(&self) -> f64 {
        (EFFICIENCY_OF_MEDIAN * (self.groups as f64 - 1.0)).max(1.0)
    }

    /// A group's value given its own estimate and the population. That μ and τ are estimates takes from the share and adds to
    /// the variance as in Morris 1983, "Parametric empirical Bayes inference", J. Am. Stat. Assoc. 78, section 5, with
    /// the degrees of freedom ν of [`Self::freedom`]:
    ///
    /// ```text
    /// B = (ν − 2)/ν · v/(v + τ²),   θ̂ = x + B·(μ − x),   var = (1 − B)·v + B²·var μ + (2/ν)·B²·(x − μ)²
    /// ```
    pub fn pool(&self, own: Mean) -> Pooled {
        let (among, freedom) = (self.spread.powi(2), self.freedom());
        let certain = (freedom - 2.0).max(0.0) / freedom;
        let share = certain * own.variance / (own.variance + among);
        let apart = self.mean.value - own.value;
        let of_estimates = self.mean.variance + 2.0 / freedom * apart.powi(2);
        Pooled {
            share,
            mean: Mean {
                value: own.value + share * apart,
                variance: (1.0 - share) * own.variance + share.powi(2) * of_estimates,
            },
        }
    }
}

/// A group's value that leans on the population.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pooled {
    /// Weight of the population's mean, 0 to 1.
    pub share: f64,
    /// The group's value after leaning, and its variance.
    pub mean: Mean,
}

fn huber_mean(groups: &[Mean], excess: f64, about: f64) -> Mean {
    let (mut weights, mut sum) = (0.0, 0.0);
    for group in groups {
        let variance = group.variance + excess;
        if variance > 0.0 {
            let u = (group.value - about) / variance.sqrt();
            let weight = huber_weight(u, HUBER_THRESHOLD) / variance;
            weights += weight;
            sum += weight * group.value;
        }
    }
    if weights > 0.0 {
        return Mean {
            value: sum / weights,
            variance: 1.0 / weights,
        };
    }
    Mean {
        value: about,
        variance: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    fn normal(rng: &mut ChaCha8Rng) -> f64 {
        StandardNormal.sample(rng)
    }

    #[test]
    fn matches_the_quantile_that_it_is_made_from() {
        use crate::stats::distribution::Distribution;
        let quartile = Distribution::Normal.quantile(0.75);
        assert!((MEDIAN_OF_SQUARE - quartile * quartile).abs() < 1e-15);
    }

    /// Five per cent of far groups put the median of the others at their quantile 0.526, 6.4 % beyond their own in scale: τ comes
    /// out 6.8 % too long where s = 0.1 alone counts and 15.7 % where s = 0.5 does. The scale from a median has a standard error
    /// of 1.17/sqrt(2n) = 1.3 %, of which τ feels at most 2.6 times as much.
    #[test]
    fn recovers_known_mean_and_spread_with_one_group_in_twenty_far_away() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let groups: Vec<Mean> = (0..4000)
            .map(|k| {
                let variance = if k % 2 == 0 { 0.01 } else { 0.25 };
                let far = if k % 20 == 0 { 30.0 } else { 0.0 };
                let truth = 5.0 + 0.4 * normal(&mut rng);
                Mean {
                    value: truth + far + f64::sqrt(variance) * normal(&mut rng),
                    variance,
                }
            })
            .collect();
        let population = Population::of(&groups).unwrap();
        let excess = population.spread / 0.4 - 1.0;
        let three_errors = 3.0 * 2.6 * 1.17 / f64::sqrt(8000.0);
        assert!(
            excess > 0.068 - three_errors && excess < 0.157 + three_errors,
            "{population:?}"
        );
        // Huber's bias is threshold · share / deviation of far groups, over the mean weight of all and the share 0.82 of them
        // within the threshold: 1.345 · 0.05/0.412/(4.16 · 0.82) = 0.048. Three standard errors are 0.023.
        assert!(
            (population.mean.value - 5.0).abs() < 0.071,
            "{population:?}"
        );
    }

    /// 2000 fleets of 40 groups: errors of pooled values against those of groups alone, and their 95 % intervals.
    #[test]
    fn pooled_values_are_better_and_their_intervals_cover() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let (mut alone, mut pooled, mut covered, mut count) = (0.0, 0.0, 0.0, 0.0);
        for _ in 0..2000 {
            let truths: Vec<f64> = (0..40).map(|_| 1.0 + 0.2 * normal(&mut rng)).collect();
            let groups: Vec<Mean> = truths
                .iter()
                .map(|truth| Mean {
                    value: truth + 0.3 * normal(&mut rng),
                    variance: 0.09,
                })
                .collect();
            let population = Population::of(&groups).unwrap();
            let k = rng.random_range(0..40);
            let leaning = population.pool(groups[k]).mean;
            alone += (groups[k].value - truths[k]).powi(2);
            pooled += (leaning.value - truths[k]).powi(2);
            covered +=
                f64::from((leaning.value - truths[k]).abs() < 1.96 * leaning.variance.sqrt());
            count += 1.0;
        }
        assert!(
            f64::sqrt(pooled / alone) < 0.7,
            "{}",
            f64::sqrt(pooled / alone)
        );
        assert!(covered / count > 0.93, "{}", covered / count);
    }

    #[test]
    fn nothing_beyond_the_errors_is_no_excess() {
        let squares = [0.1, 0.3, 2.0].map(|square| Square {
            square,
            variance: 1.0,
            times: 2.0,
        });
        assert_eq!(excess_variance(&squares), 0.0);
        assert_eq!(excess_variance(&[]), 0.0);
        let squares = [4.0; 5].map(|square| Square {
            square,
            variance: 1.0,
            times: 2.0,
        });
        let expected = 0.5 * (4.0 / MEDIAN_OF_SQUARE - 1.0);
        assert!((excess_variance(&squares) / expected - 1.0).abs() < 1e-6);
        // In whatever unit.
        let small = squares.map(|square| Square {
            square: 1e-8 * square.square,
            variance: 1e-8 * square.variance,
            ..square
        });
        assert!((excess_variance(&small) / (1e-8 * expected) - 1.0).abs() < 1e-6);
    }

    /// Groups that all lie within the threshold and scatter less than their errors have the mean of their values, weighted by
    /// 1/variance; groups without errors that agree have their value.
    #[test]
    fn matches_the_weighted_mean_of_groups_that_agree() {
        let groups = [(1.0, 1.0), (1.5, 0.25), (0.5, 1.0), (1.2, 0.5), (0.9, 2.0)];
        let groups = groups.map(|(value, variance)| Mean { value, variance });
        let population = Population::of(&groups).unwrap();
        let weights: f64 = groups.iter().map(|g| 1.0 / g.variance).sum();
        let sum: f64 = groups.iter().map(|g| g.value / g.variance).sum();
        assert_eq!(population.spread, 0.0);
        assert!((population.mean.value - sum / weights).abs() < 1e-12);
        assert!((population.mean.variance - 1.0 / weights).abs() < 1e-12);
        let certain = [3.0; 5].map(|value| Mean {
            value,
            variance: 0.0,
        });
        let expected = Mean {
            value: 3.0,
            variance: 0.0,
        };
        assert_eq!(Population::of(&certain).unwrap().mean, expected);
    }
}
