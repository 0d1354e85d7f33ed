//! Changes of the signal from period to period, which averages over periods hide.
//!
//! `d_p(k) = s_p(k) − s̄(k)`. Noise that forgets within a block has block means of variance σ²/B, with σ² from the
//! differences of successive samples, `E (d(k+1) − d(k))²/2`, which slow changes do not enter (von Neumann 1941).

use crate::chain::dataset::{Dataset, Prepared};
use crate::stats::distribution::Distribution;
use crate::stats::encompassing::block_length;

/// Whether any channel of any recording changes from period to period, at a significance corrected for their
/// number.
pub fn change(data: &Dataset, significance: f64) -> bool {
    let channels: usize = data
        .recordings
        .iter()
        .map(|r| r.experiment.signal.len())
        .sum();
    let level = significance / channels.max(1) as f64;
    let mut recordings = data.recordings.iter();
    recordings.any(|recording| {
        (0..recording.experiment.signal.len()).any(|c| p_value(recording, c) < level)
    })
}

/// Probability of so much variance between the block means of the periods of one channel, or more, where
/// nothing changes.
fn p_value(recording: &Prepared, channel: usize) -> f64 {
    let experiment = &recording.experiment;
    let Some(periods) = experiment.periods.filter(|p| p.count > 1) else {
        return 1.0;
    };
    let mean = &experiment.signal[channel];
    let differences: Vec<Vec<f64>> = (0..periods.count)
        .map(|p| {
            let signal = experiment.period_signal(channel, p);
            signal.iter().zip(mean).map(|(s, m)| s - m).collect()
        })
        .collect();
    let block = 4 * block_length(std::slice::from_ref(&differences[0])).min(periods.samples / 16);
    let steps: f64 = differences
        .iter()
        .flat_map(|d| d.windows(2))
        .map(|w| (w[1] - w[0]).powi(2))
        .sum();
    let rows = (periods.count * periods.samples) as f64;
    let noise = 0.5 * steps / (rows - periods.count as f64);
    let means = differences.iter().flat_map(|d| d.chunks_exact(block));
    let squares: Vec<f64> = means
        .map(|chunk| (chunk.iter().sum::<f64>() / block as f64).powi(2))
        .collect();
    // The periods of a block add up to zero: one of them is not free.
    let free = squares.len() as f64 * (1.0 - 1.0 / periods.count as f64);
    let ratio = squares.iter().sum::<f64>() * block as f64 / squares.len() as f64 / noise;
    if !ratio.is_finite() {
        return 1.0;
    }
    let distribution = Distribution::FisherF {
        numerator: free,
        denominator: rows,
    };
    distribution.upper_tail(ratio)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::preprocess::prepare;
    use crate::recording::samples::Recording;
    use crate::recording::settings::Preparation;
    use crate::recording::split::Split;
    use crate::robot::random::generator;
    use rand::RngExt;
    use rand_distr::StandardNormal;
    use std::f64::consts::TAU;

    const ROWS: usize = 200;
    const PERIODS: usize = 5;

    /// Two joints over periods, with white noise of size one, the second of which grows by so much with every period.
    fn data(seed: u64, growth: f64) -> Dataset {
        let mut rng = generator(seed);
        let samples = 0..ROWS * PERIODS;
        let angle = |k: usize| TAU * k as f64 / ROWS as f64;
        let position = vec![samples.clone().map(|k| angle(k).sin()).collect(); 2];
        let signal = [0.0, growth].map(|growth| {
            let noisy = |k: usize| {
                let fresh: f64 = rng.sample(StandardNormal);
                3.0 * angle(k).cos() + fresh + growth * (k / ROWS) as f64
            };
            samples.clone().map(noisy).collect()
        });
        let recording = Recording::of_samples("periods", position, signal.to_vec());
        let preparation = Preparation {
            rate: Some(100.0),
            period: Some(ROWS as f64 / 100.0),
            ..Preparation::default()
        };
        let experiment = prepare(recording, &preparation).unwrap();
        Dataset {
            recordings: vec![Prepared::new(
                "periods".into(),
                Split::Train,
                false,
                experiment,
            )],
        }
    }

    /// Of 400 recordings in which nothing changes 20 are expected at 5 %, of two channels together; their number has a
    /// deviation of 4.4.
    #[test]
    fn matches_the_stated_level_where_nothing_changes() {
        let changed = (0..400).filter(|&seed| change(&data(seed, 0.0), 0.05));
        let count = changed.count() as f64;
        assert!((count - 20.0).abs() < 3.0 * 4.4, "{count}");
    }

    /// A tenth of the noise of a sample from period to period is two and a half deviations of the mean of a period.
    #[test]
    fn a_signal_that_grows_changes() {
        assert!((0..20).all(|seed| change(&data(seed, 0.2), 0.001)));
    }
}
