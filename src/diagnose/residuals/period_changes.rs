//! Whether the signal changes from period to period, which averages over periods hide.
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
