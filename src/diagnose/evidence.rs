//! Whether a richer model forecasts the residual of a poorer one on recordings that were not fitted.
//!
//! `e = b (e − e_h) + ε`: b = 0 if the poorer model says all that the richer says, 1 if the richer is right
//! (forecast encompassing: Chong and Hendry 1986; Harvey, Leybourne and Newbold 1998, section 2). The variance of b
//! is that of sums over blocks, longer than residuals remember, of the residual ε times the regressor, which
//! holds for any autocorrelation within a block (Newey and West 1987); its degrees of freedom are the effective number
//! of blocks in which the two models differ (Satterthwaite 1946).

use crate::stats::distribution::Distribution;

/// The test of one model against another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// b.
    pub slope: f64,
    /// b over its standard deviation.
    pub ratio: f64,
    pub freedom: f64,
    /// Probability of such a ratio, or a larger one, where b = 0; of one test.
    pub p_value: f64,
}

/// Rows of a block at least.
const LEAST_BLOCK: usize = 8;

/// Blocks of a recording at least.
const LEAST_BLOCKS: usize = 24;

/// Blocks are this many times longer than the residual's correlation time.
const CORRELATION_TIMES: f64 = 4.0;

/// Weighted residuals of two models over the same rows, `[channel][row]`.
pub fn encompassing(poorer: &[Vec<f64>], richer: &[Vec<f64>]) -> Evidence {
    let scale: Vec<f64> = richer.iter().map(|e| deviation(e)).collect();
    let block = block_length(richer);
    let rows = richer.iter().map(Vec::len).max().unwrap_or(0);
    let difference = |c: usize, k: usize| (poorer[c][k] - richer[c][k]) / scale[c];
    let channels: Vec<usize> = (0..richer.len())
        .filter(|&c| !richer[c].is_empty())
        .collect();
    let (mut product, mut square) = (0.0, 0.0);
    for &c in &channels {
        for k in 0..richer[c].len() {
            let d = difference(c, k);
            product += d * poorer[c][k] / scale[c];
            square += d * d;
        }
    }
    if square <= 0.0 {
        return Evidence {
            slope: 0.0,
            ratio: 0.0,
            freedom: 1.0,
            p_value: 1.0,
        };
    }
    let slope = product / square;
    let (mut variance, mut weights) = (0.0, Vec::new());
    for start in (0..rows).step_by(block) {
        let (mut score, mut weight) = (0.0, 0.0);
        for &c in &channels {
            for k in start..richer[c].len().min(start + block) {
                let d = difference(c, k);
                score += d * (poorer[c][k] / scale[c] - slope * d);
                weight += d * d;
            }
        }
        variance += score * score;
        weights.push(weight);
    }
    let fourth: f64 = weights.iter().map(|w| w * w).sum();
    let freedom = (square * square / fourth - 1.0).max(1.0);
    let ratio = if variance > 0.0 {
        product / variance.sqrt()
    } else {
        0.0
    };
    Evidence {
        slope,
        ratio,
        freedom,
        p_value: Distribution::StudentT { freedom }.upper_tail(ratio),
    }
}

fn deviation(series: &[f64]) -> f64 {
    let squares: f64 = series.iter().map(|x| x * x).sum();
    let deviation = (squares / series.len().max(1) as f64).sqrt();
    if deviation > 0.0 { deviation } else { 1.0 }
}

/// Rows of a block: four correlation times of the residual that remembers longest.
pub fn block_length(residuals: &[Vec<f64>]) -> usize {
    let rows = residuals.iter().map(Vec::len).max().unwrap_or(0);
    let longest = residuals
        .iter()
        .map(|e| correlation_time(e))
        .fold(1.0, f64::max);
    let most = (rows / LEAST_BLOCKS).max(LEAST_BLOCK);
    ((CORRELATION_TIMES * longest) as usize).clamp(LEAST_BLOCK, most)
}

/// `1 + 2 Σ ρ_l` rows up to the first lag at which the autocorrelation ρ falls below two standard deviations
/// of that of white noise.
fn correlation_time(series: &[f64]) -> f64 {
    let n = series.len();
    let total: f64 = series.iter().map(|x| x * x).sum();
    if n < 2 || total <= 0.0 {
        return 1.0;
    }
    let noise = 2.0 / (n as f64).sqrt();
    let mut time = 1.0;
    for lag in 1..n / 4 {
        let pairs = series.iter().zip(&series[lag..]);
        let correlation = pairs.map(|(a, b)| a * b).sum::<f64>() / total;
        if correlation < noise {
            break;
        }
        time += 2.0 * correlation;
    }
    time
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution as _, StandardNormal};

    fn noise(rows: usize, seed: u64) -> Vec<f64> {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        (0..rows)
            .map(|_| StandardNormal.sample(&mut random))
            .collect()
    }

    /// Of 400 true null hypotheses about 0.05 · 400 = 20 are rejected at 5 %; the standard deviation of
    /// the count is 4.4.
    #[test]
    fn matches_the_stated_level_where_nothing_is_missing() {
        let rows = 1000;
        let mut rejected = 0;
        for seed in 0..400 {
            let e = noise(rows, seed);
            let spurious: Vec<f64> = (0..rows).map(|k| 0.1 * (k as f64 * 0.013).sin()).collect();
            let richer: Vec<f64> = e.iter().zip(&spurious).map(|(e, s)| e - s).collect();
            let evidence = encompassing(&[e], &[richer]);
            rejected += usize::from(evidence.p_value < 0.05);
        }
        let expected = 20.0;
        assert!(
            (f64::from(rejected as u32) - expected).abs() < 3.0 * 4.4,
            "{rejected}"
        );
    }

    #[test]
    fn recovers_a_slope_of_one_where_the_richer_model_is_right() {
        let e = noise(1000, 7);
        let effect: Vec<f64> = (0..1000).map(|k| (k as f64 * 0.02).sin()).collect();
        let poorer: Vec<f64> = e.iter().zip(&effect).map(|(e, s)| e + s).collect();
        let evidence = encompassing(&[poorer], &[e]);
        // The slope has a standard deviation of 1/√(Σ s²) = 1/√500.
        assert!((evidence.slope - 1.0).abs() < 4.0 / 500.0_f64.sqrt());
        assert!(evidence.p_value < 1e-6);
    }
}
