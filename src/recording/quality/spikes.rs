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
//! filter the median of these takes its place, and in positions the cubic through those that are none, unless the machine made it: impacts
//! are spikes of the signal too, and come again in every period, or where speed or torque turn over, or shake other joints in
//! the same instant.

use std::collections::HashSet;

use crate::recording::channels::samples::Recording;
use crate::stats::robust::{mad_scale, ranked};

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

/// One sample in so many may be anything: spikes must not raise what they are held against.
const RARE: usize = 200;

/// Half the width of the median's window: follows every monotone change of three samples or more.
const HALF: usize = 2;

/// Samples within which two spikes have the same phase of a period.
const SAME_PHASE: f64 = 2.0;

/// Spikes below which nothing tells whether they come with the motion.
const LEAST_SPIKES: usize = 12;

/// Standard deviations from which their ranks are none of chance: one such mean in a thousand.
const RANDOM_SIGMA: f64 = 3.3;

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
    if series.len() <= 2 * HALF {
        return Vec::new();
    }
    let deviations: Vec<f64> = (0..series.len())
        .map(|k| series[k] - around(series, k))
        .collect();
    // Most samples of a smooth channel are their own median: the scale is that of the others.
    let others: Vec<f64> = deviations.iter().copied().filter(|d| *d != 0.0).collect();
    let Some(scale) = mad_scale(&others) else {
        return Vec::new();
    };
    let sizes = deviations.iter().enumerate();
    let mut spikes: Vec<Spike> = sizes
        .map(|(at, d)| Spike { at, size: d.abs() })
        .filter(|spike| spike.size > SPIKE_SIGMA * scale)
        .collect();
    if spikes.is_empty() {
        return spikes;
    }
    let least = match channel {
        Channel::Jumping => SPIKE_SHARE * range(series),
        Channel::Smooth => SPIKE_STEPS * own_step(series),
    };
    let least = least.max(SPIKE_QUANTA * quantum(series));
    spikes.retain(|spike| spike.size > least);
    spikes
}

/// The range of a series without its ends.
fn range(series: &[f64]) -> f64 {
    let mut values = series.to_vec();
    let (cut, last) = (series.len() / RARE, series.len() - 1);
    ranked(&mut values, last - cut) - ranked(&mut values, cut)
}

/// The largest step between two samples while there is motion, those of spikes left out.
fn own_step(series: &[f64]) -> f64 {
    let steps = series.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let mut steps: Vec<f64> = steps.filter(|step| *step > 0.0).collect();
    if steps.is_empty() {
        return 0.0;
    }
    let at = (OWN_STEPS * steps.len() as f64) as usize;
    ranked(&mut steps, at)
}

/// Puts what its neighbours say in the place of spikes that the recorder made; says how many there were. Those of positions
/// all are, for nothing jumps and comes back; those of signals and velocities where the machine has no part in them.
pub(in crate::recording) fn replace(
    recording: &mut Recording,
    period: Option<f64>,
) -> Option<String> {
    let mut replaced = Vec::new();
    let mut note = |what: &str, number: usize, count: usize| {
        if count > 0 {
            replaced.push(format!("{count} of {what} {}", number + 1));
        }
    };
    let mut lost = HashSet::new();
    for (joint, series) in recording.position.iter_mut().enumerate() {
        let found = spikes(series, Channel::Smooth);
        repair(series, &found, Channel::Smooth);
        note("position", joint, found.len());
        lost.extend(found.iter().map(|spike| spike.at));
    }
    let jumping = [
        ("signal", Some(&mut recording.signal)),
        ("velocity", recording.velocity.as_mut()),
    ];
    for (what, columns) in jumping {
        let Some(columns) = columns else { continue };
        // Channels that are none of joints have no motion of their own to be held against.
        let joints = recording.position.len().min(columns.len());
        let taken = Motion {
            position: &recording.position,
            columns: &columns[..joints],
            lost: &lost,
        };
        let found: Vec<Vec<Spike>> = (0..joints)
            .map(|joint| taken.spikes_of_recorder(joint, period))
            .collect();
        for (joint, found) in found.iter().enumerate() {
            repair(&mut columns[joint], found, Channel::Jumping);
            note(what, joint, found.len());
        }
    }
    (!replaced.is_empty()).then(|| {
        format!(
            "Single samples of {} stand out from their neighbours by more than {SPIKE_SIGMA} standard deviations, and come \
             with nothing in the motion; what their neighbours say takes their place: {}.",
            recording.file.display(),
            replaced.join(", ")
        )
    })
}

/// The spikes that are not there again in more than half of the periods, given in samples: what repeats is the machine's. Of a
/// share s of samples that are outliers by chance, one in another period has the phase of a given one with probability
/// (2·[`SAME_PHASE`] + 1)·s, so that a single coincidence says little and most periods say much.
fn unrepeated(found: &[Spike], period: f64, samples: usize) -> Vec<Spike> {
    let periods = samples as f64 / period;
    let is_random = |spike: &&Spike| {
        let again = found.iter().filter_map(|other| {
            let apart = (other.at as f64 - spike.at as f64) / period;
            let same = (apart - apart.round()).abs() * period <= SAME_PHASE;
            same.then_some(apart.round() as i64)
        });
        let of_periods: HashSet<i64> = again.collect();
        of_periods.len() < 2 || 2.0 * (of_periods.len() as f64) <= periods
    };
    found.iter().filter(is_random).copied().collect()
}

/// What spikes of one joint's column are held against.
struct Motion<'a> {
    /// Of all joints, repaired.
    position: &'a [Vec<f64>],
    /// Signals or velocities of the same joints.
    columns: &'a [Vec<f64>],
    /// Rows at which a position stood out too.
    lost: &'a HashSet<usize>,
}

impl Motion<'_> {
    /// The spikes of a joint's column in which the machine has no part, with a period in samples where the motion has one.
    fn spikes_of_recorder(&self, joint: usize, period: Option<f64>) -> Vec<Spike> {
        let series = &self.columns[joint];
        let found = spikes(series, Channel::Jumping);
        if let Some(period) = period {
            return unrepeated(&found, period, series.len());
        }
        let is_lost = |spike: &Spike| self.lost.contains(&spike.at);
        let (lost, others): (Vec<Spike>, Vec<Spike>) = found.iter().copied().partition(is_lost);
        match self.are_random(joint, &others) {
            true => found,
            false => lost,
        }
    }

    /// Whether spikes of a joint's column come at any speed of the joint and at any size of the column alike, and whatever
    /// other joints do. Impacts, as of play that is gone through, come where speed or torque turns over, and shake the
    /// joints that are carried.
    fn are_random(&self, joint: usize, found: &[Spike]) -> bool {
        if found.len() < LEAST_SPIKES {
            return false;
        }
        let (position, series) = (&self.position[joint], &self.columns[joint]);
        let last = series.len() - 1;
        let speed =
            |k: usize| (position[(k + HALF).min(last)] - position[k.saturating_sub(HALF)]).abs();
        let size = |k: usize| around(series, k).abs();
        let mut others = (0..self.columns.len()).filter(|other| *other != joint);
        are_spread(found, last, &speed)
            && are_spread(found, last, &size)
            && others.all(|other| {
                let shaken = |k: usize| {
                    let near = k.saturating_sub(1)..=(k + 1).min(last);
                    let of =
                        |k: usize| (self.columns[other][k] - around(&self.columns[other], k)).abs();
                    near.map(of).fold(0.0, f64::max)
                };
                are_spread(found, last, &shaken)
            })
    }
}

/// Whether a quantity has any of its values alike at the spikes: the mean of n ranks within (0, 1) has the variance 1/(12 n).
fn are_spread(found: &[Spike], last: usize, quantity: &dyn Fn(usize) -> f64) -> bool {
    let mut all: Vec<f64> = (0..=last).map(quantity).collect();
    all.sort_by(f64::total_cmp);
    let rank = |spike: &Spike| {
        let value = quantity(spike.at);
        let below = all.partition_point(|x| *x < value);
        let through = all.partition_point(|x| *x <= value);
        0.5 * (below + through) as f64 / all.len() as f64
    };
    let count = found.len() as f64;
    let mean = found.iter().map(rank).sum::<f64>() / count;
    (mean - 0.5).abs() * (12.0 * count).sqrt() < RANDOM_SIGMA
}

fn repair(series: &mut [f64], found: &[Spike], channel: Channel) {
    let value = |spike: &Spike| match channel {
        Channel::Jumping => around(series, spike.at),
        Channel::Smooth => between(series, spike.at, found),
    };
    let values: Vec<f64> = found.iter().map(value).collect();
    for (spike, value) in found.iter().zip(values) {
        series[spike.at] = value;
    }
}

/// The value at a row of the cubic through two samples on either side, or what there is of them, that are no spikes.
fn between(series: &[f64], at: usize, found: &[Spike]) -> f64 {
    let is_sound = |k: &usize| found.binary_search_by_key(k, |spike| spike.at).is_err();
    let before: Vec<usize> = (0..at).rev().filter(is_sound).take(4).collect();
    let after: Vec<usize> = (at + 1..series.len()).filter(is_sound).take(4).collect();
    let of_after = after.len().min(4 - before.len().min(2));
    let nodes: Vec<usize> = (before.iter().take(4 - of_after))
        .chain(&after[..of_after])
        .copied()
        .collect();
    let place = |k: usize| k as f64 - at as f64;
    // Lagrange's polynomial at 0.
    let weight = |&k: &usize| -> f64 {
        let others = nodes.iter().filter(|other| **other != k);
        others
            .map(|&other| place(other) / (place(other) - place(k)))
            .product()
    };
    nodes.iter().map(|k| weight(k) * series[*k]).sum()
}

/// Median of a sample and its neighbours, two on either side, or the five at the end of the series.
fn around(series: &[f64], k: usize) -> f64 {
    let first = k.saturating_sub(HALF).min(series.len() - 2 * HALF - 1);
    let mut window = [0.0; 2 * HALF + 1];
    window.copy_from_slice(&series[first..=first + 2 * HALF]);
    window.sort_by(f64::total_cmp);
    window[HALF]
}

/// Least change of a series between two samples: the quantum of an encoder or a converter. What is rounding follows from the
/// sizes of the samples, rare ones left out.
pub fn quantum(series: &[f64]) -> f64 {
    let steps = series.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let mut sizes: Vec<f64> = series.iter().map(|x| x.abs()).collect();
    let Some(last) = sizes.len().checked_sub(1) else {
        return 0.0;
    };
    let rare = sizes.len() / RARE;
    let scale = ranked(&mut sizes, last - rare);
    // Differences of decimal numbers that should be zero are rounding.
    let least = steps
        .filter(|step| *step > 1e-12 * scale)
        .fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn signal() -> Vec<f64> {
        // Friction that turns over within one sample, and something like noise.
        let of = |k: usize| {
            let noise = ((k * 7919 % 101) as f64 / 101.0 - 0.5) * 0.1;
            let turn = if (k / 50).is_multiple_of(2) {
                1.0
            } else {
                -1.0
            };
            turn + (k as f64 / 40.0).sin() + noise
        };
        (0..1000).map(of).collect()
    }

    #[test]
    fn single_samples_are_found_and_steps_are_not() {
        let mut series = signal();
        assert_eq!(spikes(&series, Channel::Jumping), []);
        for (at, size) in [(123, 3.0), (525, -2.5), (777, 9.0)] {
            series[at] += size;
        }
        let found: Vec<usize> = spikes(&series, Channel::Jumping)
            .iter()
            .map(|spike| spike.at)
            .collect();
        assert_eq!(found, [123, 525, 777]);
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
        let sizes = [
            (0, 0.3),
            (123, 0.2),
            (500, -0.15),
            (501, 0.4),
            (777, 9.0),
            (998, 1.0),
        ];
        for (at, size) in sizes {
            broken[at] += size;
        }
        let found = spikes(&broken, Channel::Smooth);
        assert_eq!(
            found.iter().map(|s| s.at).collect::<Vec<_>>(),
            sizes.map(|(at, _)| at)
        );
        repair(&mut broken, &found, Channel::Smooth);
        let worst = clean
            .iter()
            .zip(&broken)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        assert!(worst < 1e-5, "{worst}");
    }

    #[test]
    fn what_comes_with_the_motion_is_the_machines() {
        let position: Vec<f64> = (0..2000).map(|k| (k as f64 / 50.0).sin()).collect();
        let signal: Vec<f64> = signal().into_iter().chain(signal()).collect();
        let at = |rows: Vec<usize>| -> Vec<Spike> {
            let spike = |at: usize| Spike { at, size: 1.0 };
            rows.into_iter().map(spike).collect()
        };
        // Reversals are at (n + 1/2)·50π.
        let reversals = at((0..12)
            .map(|n| ((n as f64 + 0.5) * 50.0 * PI) as usize)
            .collect());
        let anywhere = at((1..40).map(|k| k * 997 % 1999).collect());
        let (position, columns) = ([position], [signal]);
        let are_random = |spikes: &[Spike]| {
            let motion = Motion {
                position: &position,
                columns: &columns,
                lost: &HashSet::new(),
            };
            motion.are_random(0, spikes)
        };
        assert!(!are_random(&reversals));
        assert!(are_random(&anywhere));
        assert!(!are_random(&anywhere[..5]));
        // Of three periods of 400 samples, 100 comes in two and 700 in one; of six, two are a coincidence.
        let found = at(vec![100, 501, 700]);
        assert_eq!(unrepeated(&found, 400.0, 1200), at(vec![700]));
        assert_eq!(unrepeated(&found, 400.0, 2400), found);
    }

    /// Spikes at any speed and size, with those of a second joint elsewhere, in the same rows, and where a position is lost too.
    #[test]
    fn what_shakes_another_joint_is_the_machines() {
        let rows: Vec<usize> = (1..20).map(|k| k * 997 % 1960).collect();
        let position: Vec<f64> = (0..2000).map(|k| (k as f64 / 50.0).sin()).collect();
        let struck = |later: usize| -> Vec<f64> {
            let mut series: Vec<f64> = signal().into_iter().chain(signal()).collect();
            for &row in &rows {
                series[row + later] += 9.0;
            }
            series
        };
        let of_recorder = |later: usize, lost: &[usize]| {
            let motion = Motion {
                position: &[position.clone(), position.clone()],
                columns: &[struck(0), struck(later)],
                lost: &lost.iter().copied().collect(),
            };
            motion.spikes_of_recorder(0, None).len()
        };
        assert_eq!(of_recorder(30, &[]), rows.len());
        assert_eq!(of_recorder(0, &[]), 0);
        assert_eq!(of_recorder(1, &[]), 0);
        assert_eq!(of_recorder(0, &rows), rows.len());
    }

    #[test]
    fn what_most_periods_have_is_the_machine_s() {
        let kept = |at: &[usize], samples: usize| -> Vec<usize> {
            let found: Vec<Spike> = at.iter().map(|&at| Spike { at, size: 1.0 }).collect();
            let left = unrepeated(&found, 100.0, samples).into_iter();
            left.map(|spike| spike.at).collect()
        };
        // At the phase 10 in three of four periods, within two samples; at 40 in two of them; at 70 in one.
        let found = [10, 40, 70, 111, 210, 240];
        assert_eq!(kept(&found, 400), [40, 70, 240]);
        // Twice in one period is once.
        assert_eq!(kept(&[10, 11], 400), [10, 11]);
        // Of less than two periods a single spike is most.
        assert_eq!(kept(&[10], 150), [10]);
        assert!(kept(&[10, 110], 150).is_empty());
    }

    /// However large it is: what would hide it are its own rounding and its own step.
    #[test]
    fn the_size_of_a_spike_does_not_hide_it() {
        let motion: Vec<f64> = (0..600).map(|k| (k as f64 / 40.0).sin()).collect();
        for size in [1e3, 1e9, 1e15, 1e30, 1e99] {
            for (series, channel) in [
                (signal(), Channel::Jumping),
                (motion.clone(), Channel::Smooth),
            ] {
                let mut series = series;
                series[100] = size;
                let found = spikes(&series, channel);
                assert_eq!(
                    (found.len(), found[0].at),
                    (1, 100),
                    "{size:e}, {channel:?}"
                );
            }
        }
    }
}
