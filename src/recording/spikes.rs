//! Spikes of a channel: single samples far from the median of their neighbours (Hampel's identifier).
//!
//! ```text
//! d_k = s_k − median(s_{k−2} .. s_{k+2})        |d_k| > max(8 σ̂, 8 quanta, least)
//! ```
//!
//! with σ̂ the median absolute deviation of all d that are not zero, and the least size that the kind of channel asks for: a
//! quarter of its range where it can jump, as torques do where friction turns; where it cannot, as positions, four times what
//! it moves between two samples, since a motion is nowhere farther from the median of five samples than two such steps. One
//! spike moves a least-squares estimate by as much as its whole size, and a filter spreads it over its neighbours. Before any
//! filter the median of these takes its place, and in positions the cubic through them.

use crate::recording::columns::Recording;
use crate::stats::robust::mad_scale;

/// Robust standard deviations that make a spike: once in 10^15 samples of normal noise.
pub const SPIKE_SIGMA: f64 = 8.0;

/// A spike of a channel that jumps also has this share of its range: heavy tails and friction at reversals stay below.
const SPIKE_SHARE: f64 = 0.25;

/// Steps between two samples that a spike of a position exceeds, twice what any motion does.
const SPIKE_STEPS: f64 = 4.0;

/// Share of the steps between samples that a motion's own are above: spikes are in the others.
const OWN_STEPS: f64 = 0.9;

/// Quanta of a coarse channel that a spike has to exceed.
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

/// How a channel can change between two samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Channel {
    /// At once: torques, currents, forces, and velocities that a filter has made.
    Jumping,
    /// By what the motion covers: positions.
    Smooth,
}

/// The spikes of a series, in its order.
pub fn spikes(series: &[f64], channel: Channel) -> Vec<Spike> {
    let deviations: Vec<f64> = (HALF..series.len().saturating_sub(HALF))
        .map(|k| series[k] - around(series, k))
        .collect();
    // Most samples of a smooth channel are their own median: the scale is that of the others.
    let others: Vec<f64> = deviations.iter().copied().filter(|d| *d != 0.0).collect();
    let Some(scale) = mad_scale(&others) else {
        return Vec::new();
    };
    let least = match channel {
        Channel::Jumping => SPIKE_SHARE * range(series),
        Channel::Smooth => SPIKE_STEPS * own_step(series),
    };
    let threshold = (SPIKE_SIGMA * scale)
        .max(least)
        .max(SPIKE_QUANTA * quantum(series));
    let standing_out = deviations.iter().enumerate();
    let standing_out = standing_out.filter(|(_, d)| d.abs() > threshold);
    let spike = |(k, d): (usize, &f64)| Spike {
        at: k + HALF,
        size: d.abs(),
    };
    standing_out.map(spike).collect()
}

/// The range of a series without its ends: spikes must not raise their own threshold.
fn range(series: &[f64]) -> f64 {
    let mut sorted = series.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (cut, last) = (series.len() / 200, series.len() - 1);
    sorted[last - cut] - sorted[cut]
}

/// The largest step between two samples while there is motion, those of spikes left out.
fn own_step(series: &[f64]) -> f64 {
    let steps = series.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let mut steps: Vec<f64> = steps.filter(|step| *step > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    let at = (OWN_STEPS * steps.len() as f64) as usize;
    steps.get(at).copied().unwrap_or(0.0)
}

/// Puts what its neighbours say in the place of every spike of signals, positions and velocities; says how many there were.
pub(super) fn replace(recording: &mut Recording) -> Option<String> {
    let mut replaced = Vec::new();
    let kinds = [
        ("signal", Channel::Jumping, Some(&mut recording.signal)),
        ("position", Channel::Smooth, Some(&mut recording.position)),
        ("velocity", Channel::Jumping, recording.velocity.as_mut()),
    ];
    for (what, channel, columns) in kinds {
        for (number, series) in columns.into_iter().flatten().enumerate() {
            let found = spikes(series, channel);
            let repaired: Vec<f64> = (found.iter())
                .map(|spike| repaired(series, spike.at, channel))
                .collect();
            for (spike, value) in found.iter().zip(repaired) {
                series[spike.at] = value;
            }
            if !found.is_empty() {
                replaced.push(format!("{} of {what} {}", found.len(), number + 1));
            }
        }
    }
    (!replaced.is_empty()).then(|| {
        format!(
            "Single samples of {} stand out from their neighbours by more than {SPIKE_SIGMA} standard deviations, and \
             what these say takes their place: {}.",
            recording.file.display(),
            replaced.join(", ")
        )
    })
}

/// What stands in the place of a spike.
fn repaired(series: &[f64], k: usize, channel: Channel) -> f64 {
    let median = around(series, k);
    match channel {
        Channel::Jumping => median,
        Channel::Smooth => {
            let cubic =
                (4.0 * (series[k - 1] + series[k + 1]) - series[k - 2] - series[k + 2]) / 6.0;
            // A neighbour that is a spike itself throws the cubic off, and not the median.
            let near = (series[k - 1] - series[k + 1]).abs();
            if (cubic - median).abs() <= near {
                cubic
            } else {
                median
            }
        }
    }
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
        assert_eq!(spikes(&series, Channel::Jumping), []);
        for (at, size) in [(123, 3.0), (500, -2.5), (777, 9.0)] {
            series[at] += size;
        }
        let found: Vec<usize> = spikes(&series, Channel::Jumping)
            .iter()
            .map(|spike| spike.at)
            .collect();
        assert_eq!(found, [123, 500, 777]);
    }

    #[test]
    fn a_constant_and_a_short_series_have_none() {
        for channel in [Channel::Jumping, Channel::Smooth] {
            assert_eq!(spikes(&[1.0; 100], channel), []);
            assert_eq!(spikes(&[1.0, 5.0, 1.0], channel), []);
        }
    }

    #[test]
    fn positions_are_repaired_to_what_the_motion_was() {
        let path = |k: usize| (k as f64 / 60.0).sin() + 0.3 * (k as f64 / 23.0).cos();
        let clean: Vec<f64> = (0..1000).map(path).collect();
        assert_eq!(spikes(&clean, Channel::Smooth), []);
        let mut broken = clean.clone();
        for (at, size) in [(123, 0.2), (500, -0.15), (777, 9.0)] {
            broken[at] += size;
        }
        let found = spikes(&broken, Channel::Smooth);
        assert_eq!(found.len(), 3);
        for spike in found {
            let value = repaired(&broken, spike.at, Channel::Smooth);
            assert!((value - clean[spike.at]).abs() < 1e-5);
        }
    }
}
