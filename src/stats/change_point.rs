//! One step in the mean of normal values whose variances are known: the likelihood ratio over all instants, and its
//! distribution without a step.
//!
//! ```text
//! x_i ~ N(μ + δ·[i ≥ k], v_i),   w_i = 1/v_i,   t_k = Σ_{i<k} w_i / Σ w_i
//! Z_k = (x̄_{i≥k} − x̄_{i<k}) · sqrt(W t_k (1 − t_k)),   W = Σ w_i
//! T = max_k |Z_k|
//! ```
//!
//! Without a step the Z_k are standard normal and a Markov chain, with correlation
//! `ρ = sqrt(t_k (1 − t_l) / (t_l (1 − t_k)))` of Z_k and Z_l, k < l, so that P(T ≥ c) is a chain of integrals over
//! [−c, c]. Source: Hawkins 1977, "Testing a sequence of observations for a shift in location", J. Am. Stat. Assoc. 72,
//! section 3; unequal variances enter by the t_k alone.

use crate::stats::distribution::Distribution;
use std::f64::consts::{PI, TAU};

/// A value and the variance that it has without a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// In any one unit.
    pub value: f64,
    /// > 0.
    pub variance: f64,
}

/// A mean and its variance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mean {
    /// In the unit of the values.
    pub value: f64,
    /// Square of the standard error of the mean, in that unit squared.
    pub variance: f64,
}

/// The step that explains a series best.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// The first observation behind it.
    pub first: usize,
    /// Z at that instant: its size in standard deviations, with its sign.
    pub z: f64,
    /// Of the observations before the step, weighted by inverse variances.
    pub before: Mean,
    /// Of those from the step on.
    pub after: Mean,
}

/// Observations at the end of a series before each of which a step may lie; of those before them every step tried lies
/// a tenth of the way further back.
const EACH: usize = 32;

/// Instants at which a step is looked for, as numbers of the first observation behind it, rising.
pub fn instants(count: usize) -> Vec<usize> {
    let mut instants = Vec::new();
    let mut back = 1;
    while back < count {
        instants.push(count - back);
        back += 1 + back.saturating_sub(EACH).div_ceil(10);
    }
    instants.reverse();
    instants
}

/// Weighted mean of observations, of which there is at least one.
pub fn mean(observations: &[Observation]) -> Mean {
    let (mut weights, mut sum) = (0.0, 0.0);
    for observation in observations {
        let weight = 1.0 / observation.variance;
        weights += weight;
        sum += weight * observation.value;
    }
    Mean {
        value: sum / weights,
        variance: 1.0 / weights,
    }
}

/// The step with the largest |Z|; `None` of fewer than two observations.
pub fn largest_step(series: &[Observation]) -> Option<Step> {
    let step = |first: usize| {
        let [before, after] = [mean(&series[..first]), mean(&series[first..])];
        let z = (after.value - before.value) / (after.variance + before.variance).sqrt();
        Step {
            first,
            z,
            before,
            after,
        }
    };
    let steps = instants(series.len()).into_iter().map(step);
    steps.reduce(|best, next| {
        if next.z.abs() > best.z.abs() {
            next
        } else {
            best
        }
    })
}

/// Whether a straight line leaves less of a series than the step: `Σ w r²` of both, with two free numbers each.
pub fn is_rather_a_line(series: &[Observation], step: &Step) -> bool {
    let [mut w, mut wx, mut wxx, mut wy, mut wxy] = [0.0; 5];
    for (i, o) in series.iter().enumerate() {
        let (weight, x) = (1.0 / o.variance, i as f64);
        w += weight;
        wx += weight * x;
        wxx += weight * x * x;
        wy += weight * o.value;
        wxy += weight * x * o.value;
    }
    let slope = (w * wxy - wx * wy) / (w * wxx - wx * wx);
    let start = (wy - slope * wx) / w;
    let left = |predicted: &dyn Fn(usize) -> f64| -> f64 {
        let squares = series.iter().enumerate();
        squares
            .map(|(i, o)| (o.value - predicted(i)).powi(2) / o.variance)
            .sum()
    };
    let by_step = left(&|i| match i < step.first {
        true => step.before.value,
        false => step.after.value,
    });
    left(&|i| start + slope * i as f64) < by_step
}

/// P(T ≥ |z|) without a step, for a series with these variances.
pub fn p_value(z: f64, series: &[Observation]) -> f64 {
    let bound = z.abs();
    let shares = shares(series);
    if shares.is_empty() || bound == 0.0 {
        return 1.0;
    }
    let links: Vec<Link> = shares.windows(2).map(Link::between).collect();
    let narrowest = links.iter().map(|link| link.scatter).fold(1.0, f64::min);
    let nodes = nodes(bound, narrowest);
    let tail = |x: f64| Distribution::Normal.upper_tail(x);
    // Densities at the nodes of chains that have stayed within the bound, on the half axis: both halves are alike.
    let mut density: Vec<f64> = nodes.iter().map(|node| normal_density(node.x)).collect();
    let mut exceeded = 2.0 * tail(bound);
    for link in &links {
        let leaving = nodes.iter().zip(&density).map(|(node, density)| {
            let above = tail((bound - link.correlation * node.x) / link.scatter);
            let below = tail((bound + link.correlation * node.x) / link.scatter);
            2.0 * node.weight * density * (above + below)
        });
        exceeded += leaving.sum::<f64>();
        density = nodes
            .iter()
            .map(|to| {
                let arriving = nodes.iter().zip(&density).map(|(from, density)| {
                    let [same, other] = [1.0, -1.0].map(|side| {
                        normal_density((to.x - side * link.correlation * from.x) / link.scatter)
                    });
                    from.weight * density * (same + other)
                });
                arriving.sum::<f64>() / link.scatter
            })
            .collect();
    }
    exceeded.min(1.0)
}

/// t_k at the instants.
fn shares(series: &[Observation]) -> Vec<f64> {
    let all: f64 = series.iter().map(|o| 1.0 / o.variance).sum();
    let before = |first: usize| {
        series[..first]
            .iter()
            .map(|o| 1.0 / o.variance)
            .sum::<f64>()
            / all
    };
    instants(series.len()).into_iter().map(before).collect()
}

/// Correlation of two successive Z, and what the second scatters about what the first predicts.
struct Link {
    correlation: f64,
    scatter: f64,
}

impl Link {
    fn between(shares: &[f64]) -> Self {
        let (t, u) = (shares[0], shares[1]);
        let square = t * (1.0 - u) / (u * (1.0 - t));
        Self {
            correlation: square.sqrt(),
            scatter: (1.0 - square).sqrt().max(LEAST_SCATTER),
        }
    }
}

/// Scatter below which two successive Z count as equal: an observation of no weight lies between them.
const LEAST_SCATTER: f64 = 0.02;

fn normal_density(x: f64) -> f64 {
    (-0.5 * x * x).exp() / TAU.sqrt()
}

/// A node of a rule of integration over [0, bound].
struct QuadratureNode {
    x: f64,
    weight: f64,
}

/// Nodes of the Gauss-Legendre rule over [0, bound], two and a half to a scatter of the chain, which leaves less than a
/// thousandth of a p-value.
fn nodes(bound: f64, scatter: f64) -> Vec<QuadratureNode> {
    let count = 8 + (2.5 * bound / scatter).min(400.0) as usize;
    let node = |i: usize| {
        let mut x = (PI * (i as f64 + 0.75) / (count as f64 + 0.5)).cos();
        let mut slope = 1.0;
        // Newton's method converges to the last bit from these starts in a few steps.
        for _ in 0..8 {
            let (mut last, mut value) = (1.0, x);
            for k in 2..=count {
                let k = k as f64;
                (last, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * last) / k);
            }
            slope = count as f64 * (x * value - last) / (x * x - 1.0);
            x -= value / slope;
        }
        QuadratureNode {
            x: 0.5 * bound * (1.0 + x),
            weight: bound / ((1.0 - x * x) * slope * slope),
        }
    };
    (0..count).map(node).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    fn series(variances: &[f64], rng: &mut ChaCha8Rng) -> Vec<Observation> {
        let draw = |&variance: &f64| Observation {
            value: f64::sqrt(variance)
                * <StandardNormal as rand_distr::Distribution<f64>>::sample(&StandardNormal, rng),
            variance,
        };
        variances.iter().map(draw).collect()
    }

    #[test]
    fn matches_the_closed_form_of_two_observations() {
        let series = [1.0, 4.0].map(|variance| Observation {
            value: 0.0,
            variance,
        });
        for z in [0.5, 2.0, 6.0] {
            let expected = 2.0 * Distribution::Normal.upper_tail(z);
            assert!((p_value(z, &series) / expected - 1.0).abs() < 1e-12);
        }
    }

    /// Of 4000 series without a step (of 1000 long ones), a share p has a p-value up to p, to three and a half standard errors.
    #[test]
    fn invariant_p_values_are_uniform_without_a_step() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let uneven: Vec<f64> = (0..20).map(|i| 1.0 + 3.0 * f64::from(i % 5)).collect();
        for variances in [vec![1.0; 2], vec![1.0; 20], uneven, vec![1.0; 70]] {
            let draws = 4000 / variances.len().div_ceil(20);
            let values: Vec<f64> = (0..draws)
                .map(|_| {
                    let series = series(&variances, &mut rng);
                    p_value(largest_step(&series).unwrap().z, &series)
                })
                .collect();
            for level in [0.01, 0.05, 0.2] {
                let share = values.iter().filter(|p| **p <= level).count() as f64 / draws as f64;
                let error = (level * (1.0 - level) / draws as f64).sqrt();
                assert!(
                    (share - level).abs() < 3.5 * error,
                    "{} {level} {share}",
                    variances.len()
                );
            }
        }
    }

    /// Small p-values lie between a term of Bonferroni's inequality and their sum.
    #[test]
    fn invariant_small_p_values_lie_within_bonferroni_s_bounds() {
        let series = vec![
            Observation {
                value: 0.0,
                variance: 1.0
            };
            20
        ];
        for z in [4.0, 6.0, 9.0] {
            let one = 2.0 * Distribution::Normal.upper_tail(z);
            let p = p_value(z, &series);
            assert!(p > 5.0 * one && p < 19.0 * one, "{z} {p} {one}");
        }
    }

    #[test]
    fn recovers_known_steps_and_tells_them_from_lines() {
        let at = |i: usize, slope: f64, size: f64| Observation {
            value: 2.0
                + slope * i as f64
                + if i >= 14 { size } else { 0.0 }
                + 0.01 * (i % 3) as f64,
            variance: 0.01,
        };
        let stepped: Vec<Observation> = (0..20).map(|i| at(i, 0.0, -1.0)).collect();
        let step = largest_step(&stepped).unwrap();
        assert_eq!(step.first, 14);
        assert!(step.z < -10.0 && !is_rather_a_line(&stepped, &step));
        let drifting: Vec<Observation> = (0..20).map(|i| at(i, 0.1, 0.0)).collect();
        assert!(is_rather_a_line(
            &drifting,
            &largest_step(&drifting).unwrap()
        ));
        assert!(largest_step(&stepped[..1]).is_none());
    }

    #[test]
    fn instants_thin_out_far_back() {
        assert_eq!(instants(4), [1, 2, 3]);
        let many = instants(1000);
        assert!(many.len() < 80 && many.contains(&999) && many.contains(&968));
        assert!(many.windows(2).all(|pair| pair[0] < pair[1]));
    }
}
