//! Spikes of a signal: single samples far from the median of their neighbours (Hampel's identifier).
//!
//! ```text
//! d_k = s_k − median(s_{k−2} .. s_{k+2})        |d_k| > max(8 σ̂, range / 4, 8 steps)
//! ```
//!
//! with σ̂ the median absolute deviation of all d that are not zero. One such sample moves a least-squares estimate by as much
//! as its whole size, and a filter spreads it over its neighbours; the median of these takes its place, before any filter.

use crate::recording::columns::Recording;
use crate::stats::robust::mad_scale;

/// Robust standard deviations that make a spike: once in 10^15 samples of normal noise.
pub const SPIKE_SIGMA: f64 = 8.0;

/// A spike also has this share of the channel's range: heavy tails and friction at reversals stay below.
const SPIKE_SHARE: f64 = 0.25;

/// Steps of a coarse channel that a spike has to exceed.
const SPIKE_QUANTA: f64 = 8.0;

/// Half the width of the median's window: follows every monotone change of three samples or more.
const HALF: usize = 2;

/// A sample that stands out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spike {
    /// Its row.
    pub at: usize,
    /// Distance from the median of its neighbours.
    pub size: f64,
}

/// The spikes of a series, in its order.
pub fn spikes(series: &[f64]) -> Vec<Spike> {
    let deviations: Vec<f64> = (HALF..series.len().saturating_sub(HALF))
        .map(|k| series[k] - around(series, k))
        .collect();
    // Most samples of a smooth channel are their own median: the scale is that of the others.
    let others: Vec<f64> = deviations.iter().copied().filter(|d| *d != 0.0).collect();
    let Some(scale) = mad_scale(&others) else {
        return Vec::new();
    };
    let mut sorted: Vec<f64> = series.to_vec();
    let (cut, last) = (series.len() / 200, series.len() - 1);
    sorted.sort_by(f64::total_cmp);
    // The range without its ends: spikes must not raise their own threshold.
    let (low, high) = (sorted[cut], sorted[last - cut]);
    let threshold = (SPIKE_SIGMA * scale)
        .max(SPIKE_SHARE * (high - low))
        .max(SPIKE_QUANTA * quantum(series));
    let standing_out = deviations.iter().enumerate();
    let standing_out = standing_out.filter(|(_, d)| d.abs() > threshold);
    let spike = |(k, d): (usize, &f64)| Spike {
        at: k + HALF,
        size: d.abs(),
    };
    standing_out.map(spike).collect()
}

/// Puts the median of its neighbours in the place of every spike of the signals; says how many there were.
pub(super) fn replace(recording: &mut Recording) -> Option<String> {
    let mut replaced = Vec::new();
    for (channel, series) in recording.signal.iter_mut().enumerate() {
        let found = spikes(series);
        let medians: Vec<f64> = found.iter().map(|spike| around(series, spike.at)).collect();
        for (spike, median) in found.iter().zip(medians) {
            series[spike.at] = median;
        }
        if !found.is_empty() {
            replaced.push(format!("{} of channel {}", found.len(), channel + 1));
        }
    }
    (!replaced.is_empty()).then(|| {
        format!(
            "Single samples of the signals of {} stand out from their neighbours by more than {SPIKE_SIGMA} standard \
             deviations, and the median of these takes their place: {}.",
            recording.file.display(),
            replaced.join(", ")
        )
    })
}

/// Median of a sample and its neighbours, as many on both sides.
fn around(series: &[f64], k: usize) -> f64 {
    let mut window = [0.0; 2 * HALF + 1];
    window.copy_from_slice(&series[k - HALF..=k + HALF]);
    window.sort_by(f64::total_cmp);
    window[HALF]
}

/// Least change of a series between two samples: the quantum of an encoder or a converter.
pub fn quantum(series: &[f64]) -> f64 {
    let steps = series.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let scale = series.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    // Differences of decimal numbers that should be zero are rounding.
    let least = steps
        .filter(|step| *step > 1e-12 * scale)
        .fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signal() -> Vec<f64> {
        // Friction that turns over within one sample, and something like noise.
        let of = |k: usize| {
            let noise = ((k * 7919 % 101) as f64 / 101.0 - 0.5) * 0.1;
            let turn = if (k / 50) % 2 == 0 { 1.0 } else { -1.0 };
            turn + (k as f64 / 40.0).sin() + noise
        };
        (0..1000).map(of).collect()
    }

    #[test]
    fn single_samples_are_found_and_steps_are_not() {
        let mut series = signal();
        assert_eq!(spikes(&series), []);
        for (at, size) in [(123, 3.0), (500, -2.5), (777, 9.0)] {
            series[at] += size;
        }
        let found: Vec<usize> = spikes(&series).iter().map(|spike| spike.at).collect();
        assert_eq!(found, [123, 500, 777]);
    }

    #[test]
    fn a_constant_and_a_short_series_have_none() {
        assert_eq!(spikes(&[1.0; 100]), []);
        assert_eq!(spikes(&[1.0, 5.0, 1.0]), []);
    }
}
