//! Coloured noise: an autoregression of the residuals of each channel.
//!
//! ```text
//! e_t = Σ_k a_k e_(t−k) + u_t,   A(f) = 1 − Σ_k a_k e^(−2πi f k),   S_e = A⁻¹ S_u A⁻ᴴ
//! ```
//!
//! The innovations u are nearly white, so that their spectrum may be smoothed over wide bands; that of residuals with a
//! corner inside the band of the motion may not (prewhitening: Andrews and Monahan 1992).

use crate::chain::dataset::Prepared;
use crate::stats::autoregression::{
    Autoregression, MOST_COEFFICIENTS, OrderCriterion, largest_order,
};
use nalgebra::Complex;
use std::f64::consts::TAU;

/// Share of the samples that have to have as many samples before them in their run: errors that outlast short runs are
/// in their spectrum across the gaps, and no autoregression within runs has them.
const MOSTLY_USED: f64 = 0.5;

/// Rates that differ by less than this share are one rate.
const SAME_RATE: f64 = 1e-3;

/// What is left of an innovation after this share of it is forgotten.
const FORGOTTEN: f64 = 1e-3;

/// Innovations of a series, zero in rows whose past does not count.
pub(super) struct Innovations {
    pub values: Vec<f64>,
    pub known: Vec<bool>,
}

/// Autoregressions of the channels of recordings.
#[derive(Debug, Clone)]
pub(super) struct ColouredNoise {
    channels: Vec<Autoregression>,
}

/// Series of the channels of one recording with the rows that count, `[channel][row]`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Counted<'a> {
    pub residuals: &'a [Vec<f64>],
    pub counts: &'a [Vec<bool>],
}

impl ColouredNoise {
    /// Of the residuals of several recordings together, the order by the criterion of Schwarz.
    pub fn of(recordings: &[Counted<'_>]) -> Self {
        let channels = recordings.first().map_or(0, |r| r.residuals.len());
        let of = |c: usize| {
            let mut runs: Vec<&[f64]> = Vec::new();
            for recording in recordings {
                let (series, counts) = (&recording.residuals[c], &recording.counts[c]);
                runs.extend(runs_of(counts).map(|run| &series[run]));
            }
            let samples: usize = runs.iter().map(|run| run.len()).sum();
            let used = |order: usize| {
                runs.iter()
                    .map(|r| r.len().saturating_sub(order))
                    .sum::<usize>()
            };
            let most = match used(MOST_COEFFICIENTS) as f64 >= MOSTLY_USED * samples as f64 {
                true => largest_order(samples),
                false => 0,
            };
            let fitted = Autoregression::fit(&runs, most, OrderCriterion::Bic);
            fitted.unwrap_or_else(|| Autoregression::white(1.0))
        };
        Self {
            channels: (0..channels).map(of).collect(),
        }
    }

    /// Of the scatter of periods about their averages, pooled by their samples; `None` unless every recording is an
    /// average of one rate.
    pub fn of_periods(recordings: &[&Prepared]) -> Option<Self> {
        let mut sums: Vec<Vec<f64>> = Vec::new();
        let mut samples = 0;
        let rate_hz = recordings.first()?.experiment.rate_hz;
        for recording in recordings {
            let experiment = &recording.experiment;
            let noise = experiment.noise.as_ref()?;
            if (experiment.rate_hz / rate_hz - 1.0).abs() > SAME_RATE {
                return None;
            }
            let own = noise.degrees;
            samples += own as usize;
            sums.resize_with(noise.autocovariance.len(), Vec::new);
            for (sum, lags) in sums.iter_mut().zip(&noise.autocovariance) {
                match sum.is_empty() {
                    true => *sum = vec![0.0; lags.len()],
                    false => sum.truncate(lags.len()),
                }
                sum.iter_mut().zip(lags).for_each(|(s, l)| *s += own * l);
            }
        }
        let of = |covariance: &Vec<f64>| {
            let most = largest_order(samples);
            let known = &covariance[..covariance.len().min(most + 1)];
            let model = Autoregression::of_autocovariance(known, samples);
            model.unwrap_or_else(|| Autoregression::white(1.0))
        };
        Some(Self {
            channels: sums.iter().map(of).collect(),
        })
    }

    /// Whether every channel is white.
    pub fn is_white(&self) -> bool {
        self.order() == 0
    }

    /// Most coefficients of a channel.
    pub fn order(&self) -> usize {
        let orders = self.channels.iter().map(|m| m.coefficients.len());
        orders.max().unwrap_or(0)
    }

    /// Rows after which an innovation is forgotten, at most as many as are asked for.
    pub fn memory(&self, most: usize) -> usize {
        let of = |model: &Autoregression| {
            if model.coefficients.is_empty() {
                return 0;
            }
            let response = model.impulse_response(most);
            let largest = response.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            let last = response.iter().rposition(|x| x.abs() > FORGOTTEN * largest);
            last.map_or(0, |last| last + 1)
        };
        self.channels.iter().map(of).max().unwrap_or(0)
    }

    /// A(f) of a channel at a frequency in cycles per row.
    pub fn response(&self, channel: usize, frequency: f64) -> Complex<f64> {
        let coefficients = self.channels[channel].coefficients.iter().enumerate();
        let term =
            |(k, a): (usize, &f64)| Complex::from_polar(*a, -TAU * frequency * (k + 1) as f64);
        Complex::new(1.0, 0.0) - coefficients.map(term).sum::<Complex<f64>>()
    }

    /// Innovations of a channel; rows count whose past counts too. A cyclic series begins where it ends.
    pub fn innovations(
        &self,
        channel: usize,
        series: &[f64],
        counts: &[bool],
        cyclic: bool,
    ) -> Innovations {
        let coefficients = &self.channels[channel].coefficients;
        let (n, order) = (series.len(), coefficients.len());
        let mut innovations = vec![0.0; n];
        let mut known = vec![false; n];
        let mut run = match cyclic {
            true => counts.iter().rev().take_while(|c| **c).count(),
            false => 0,
        };
        for t in 0..n {
            run = if counts[t] { run + 1 } else { 0 };
            if run <= order {
                continue;
            }
            let past = |k: usize| series[(t + n - k - 1) % n];
            let predicted: f64 = coefficients
                .iter()
                .enumerate()
                .map(|(k, a)| a * past(k))
                .sum();
            innovations[t] = series[t] - predicted;
            known[t] = true;
        }
        Innovations {
            values: innovations,
            known,
        }
    }
}

/// Runs of rows that count.
fn runs_of(counts: &[bool]) -> impl Iterator<Item = std::ops::Range<usize>> {
    let mut start = 0;
    let parts = counts.chunk_by(|a, b| a == b);
    parts.filter_map(move |part| {
        let run = start..start + part.len();
        start = run.end;
        part[0].then_some(run)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn red() -> (Autoregression, Vec<f64>) {
        let model = Autoregression {
            coefficients: vec![0.9],
            innovation_variance: 1.0,
        };
        let mut rng = crate::robot::random::generator(5);
        let mut one = || crate::robot::random::symmetric(&mut rng, 1.7);
        let innovations: Vec<f64> = (0..4000).map(|_| one()).collect();
        (model.clone(), model.shape(&innovations))
    }

    #[test]
    fn recovers_known_colour_across_a_gap() {
        let (_, mut series) = red();
        let counts: Vec<bool> = (0..4000).map(|k| !(1000..1500).contains(&k)).collect();
        series[1000..1500].fill(0.0);
        let residuals = vec![series];
        let counts = vec![counts];
        let colour = ColouredNoise::of(&[Counted {
            residuals: &residuals,
            counts: &counts,
        }]);
        assert_eq!(colour.order(), 1);
        // The standard deviation of a coefficient is √((1 − a²)/N) = 0.0074.
        assert!((colour.channels[0].coefficients[0] - 0.9).abs() < 4.0 * 0.0074);
        let Innovations { values, known } = colour.innovations(0, &residuals[0], &counts[0], false);
        assert_eq!(known.iter().filter(|k| !**k).count(), 502);
        let squares: f64 = values.iter().map(|u| u * u).sum();
        // Uniform over ±1.7: a variance of 0.963.
        assert!((squares / 3498.0 / 0.963 - 1.0).abs() < 0.1);
    }

    #[test]
    fn what_is_forgotten_and_the_response_follow_from_the_coefficients() {
        let (model, _) = red();
        let colour = ColouredNoise {
            channels: vec![model],
        };
        // 0.9^n < 1e-3 from n = 66 on.
        assert_eq!(colour.memory(1000), 66);
        assert!((colour.response(0, 0.0).re - 0.1).abs() < 1e-12);
        assert!((colour.response(0, 0.5).re - 1.9).abs() < 1e-12);
    }
}
