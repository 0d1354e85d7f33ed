//! Detection of signals that are lost: cut off at a limit, or standing still while their joint moves.
//!
//! A signal that is cut off has its largest value, or its smallest, far more often than the value next to that, and in runs.
//! One that the recorder lost does not change in n samples. With noise of deviation σ in steps h two samples in a row are alike
//! with the probability
//!
//! ```text
//! p ≤ max(P(|e| < h/2), share of pairs of other moving samples that are alike)        P = N p^(n−1)
//! ```
//!
//! so that a run that is expected less than once in a million recordings of N samples is none of chance. Where steps hide the
//! noise, p is one and nothing is told. What the noise makes of a limit depends on the noise: samples whose neighbours lie
//! within three deviations of the limit are left out too, and those that remain are none that the noise has chosen.

use std::ops::Range;

use crate::recording::channels::lost::{Loss, LostChannel, LostSignal};
use crate::recording::channels::samples::{Recording, SignalKind};
use crate::recording::quality::spikes::quantum;
use crate::recording::series::differences::fourth;
use crate::stats::deviation::range;
use crate::stats::distribution::Distribution;
use crate::stats::robust::{normal_scale, quantile};

/// Samples in a row at the extreme value that make a plateau.
const PLATEAU: usize = 4;

/// Share of the samples that plateaus must hold to matter.
const PLATEAU_SHARE: f64 = 0.002;

/// The extreme value must be hit this many times as often as the value next to it: the turning point of a
/// smooth quantised signal stays 1/(√2 − 1) = 2.4 times as long at its last step as at the one before.
const PILE: f64 = 6.0;

/// Deviations of the noise from a limit within which it decides what is cut off.
const NEAR_SIGMA: f64 = 3.0;

/// Largest share of samples that may be left out: intervals from the rest are then twice as wide.
const MOST_LOST: f64 = 0.75;

/// Largest share at which a signal is lost for standing still: what does so more often is the machine's own doing, or that of
/// a channel that was never connected.
const MOST_STUCK: f64 = 0.1;

/// Fewest samples of a signal that stands still.
const LEAST_STUCK: usize = 10;

/// Chance of a run by noise, in a whole recording, below which it is none.
const CHANCE: f64 = 1e-6;

/// A run is longer by so much than any that noise explains: noise that is smaller in slow motion makes runs of all lengths.
const LONGER: usize = 2;

/// Steps of the encoder that the joint takes meanwhile for it to count as moving, and least share of its
/// range.
const MOVING_QUANTA: f64 = 20.0;
const MOVING_SHARE: f64 = 0.01;

/// Samples on either side by which the speed of a joint is told, and share of its usual speed above which it moves.
const BESIDE: usize = 5;
const MOVING_SPEED: f64 = 0.1;

/// Smallest changes are rounding or rare: the step of a signal is that which one change in so many falls short of.
const SMALL_CHANGES: f64 = 0.01;

/// A signal jumps where it changes by more than twice what all but one change in a hundred do.
const USUAL_CHANGES: f64 = 0.99;
const JUMP: f64 = 2.0;

/// The recording with what it has lost of its signal. Commands are told and not measured: they may stand still.
pub fn marked(mut recording: Recording, kind: SignalKind) -> Recording {
    let is_measured = kind != SignalKind::PositionCommand;
    let count = recording.position.first().map_or(0, Vec::len);
    let mut valid = vec![true; count];
    let mut channels = Vec::new();
    for channel in 0..recording.signal.len() {
        let series = Series::new(&recording, channel);
        let saturated = series.saturated();
        let limits = saturated
            .as_ref()
            .map_or(&[][..], |lost| &lost.found.values);
        let stuck = series.stuck(limits);
        for Lost { mut found, beside } in saturated.into_iter().chain(stuck) {
            let mut without = valid.clone();
            let rows = found.samples.iter().chain(&beside);
            rows.for_each(|&k| without[k] = false);
            let most = match found.loss {
                Loss::Saturated => MOST_LOST,
                Loss::Stuck => MOST_STUCK,
            };
            let is_rare = found.samples.len() as f64 <= most * count as f64;
            found.left_out = is_measured && is_rare && share_of_false(&without) <= MOST_LOST;
            if found.left_out {
                valid = without;
            }
            channels.push(found);
        }
    }
    if !channels.is_empty() {
        recording.lost = Some(LostSignal { valid, channels });
    }
    recording
}

fn share_of_false(mask: &[bool]) -> f64 {
    mask.iter().filter(|valid| !**valid).count() as f64 / mask.len() as f64
}

/// What is lost of a channel.
struct Lost {
    found: LostChannel,
    /// Samples that are left out with those.
    beside: Vec<usize>,
}

/// A channel of the signal beside the motion of its joint.
struct Series<'a> {
    channel: usize,
    signal: &'a [f64],
    position: &'a [f64],
    mask: Option<&'a [bool]>,
}

impl<'a> Series<'a> {
    fn new(recording: &'a Recording, channel: usize) -> Self {
        // Of a wrench, every joint is as good as the last.
        let joint = channel.min(recording.position.len().saturating_sub(1));
        Self {
            channel,
            signal: &recording.signal[channel],
            position: recording.position.get(joint).map_or(&[], Vec::as_slice),
            mask: recording.mask.as_deref(),
        }
    }

    fn counts(&self, k: usize) -> bool {
        self.mask.is_none_or(|mask| mask[k])
    }

    fn lost(&self, loss: Loss, samples: Vec<usize>, values: Vec<f64>) -> LostChannel {
        LostChannel {
            channel: self.channel,
            loss,
            samples,
            values,
            left_out: false,
        }
    }

    /// Runs of one value, of samples that count.
    fn runs(&self) -> Vec<Range<usize>> {
        let mut end = 0;
        let runs = self.signal.chunk_by(|a, b| a == b).map(|run| {
            let start = end;
            end += run.len();
            start..end
        });
        runs.filter(|run| self.counts(run.start)).collect()
    }

    fn changes(&self) -> impl Iterator<Item = f64> + '_ {
        let changes = self.signal.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        changes.filter(|change| *change > 0.0)
    }
}

/// Signals that are cut off.
impl Series<'_> {
    fn saturated(&self) -> Option<Lost> {
        let runs = self.runs_without_jumps();
        let mut limits: Vec<f64> = Vec::new();
        let (mut samples, mut beside) = (Vec::new(), Vec::new());
        for sign in [1.0, -1.0] {
            let largest = self.signal.iter().map(|x| sign * x);
            let limit = sign * largest.fold(f64::NEG_INFINITY, f64::max);
            if limits.contains(&limit) || !self.is_limit(limit, &runs) {
                continue;
            }
            limits.push(limit);
            samples.extend(
                runs.iter()
                    .filter(|run| self.signal[run.start] == limit)
                    .cloned()
                    .flatten(),
            );
            beside.extend(self.near(limit));
        }
        samples.sort_unstable();
        (!limits.is_empty()).then(|| Lost {
            found: self.lost(Loss::Saturated, samples, limits),
            beside,
        })
    }

    /// Runs into which and out of which the signal does not jump: it comes to a limit as it goes everywhere.
    fn runs_without_jumps(&self) -> Vec<Range<usize>> {
        let mut changes: Vec<f64> = self.changes().collect();
        let jump = match changes.is_empty() {
            true => f64::INFINITY,
            false => JUMP * quantile(&mut changes, USUAL_CHANGES),
        };
        let is_jump = |a: usize, b: usize| (self.signal[a] - self.signal[b]).abs() > jump;
        let jumps = |run: &Range<usize>| {
            let into = run.start.checked_sub(1).map(|k| is_jump(k, run.start));
            let out = (run.end < self.signal.len()).then(|| is_jump(run.end - 1, run.end));
            let flanks: Vec<bool> = into.into_iter().chain(out).collect();
            !flanks.is_empty() && flanks.iter().all(|jumps| *jumps)
        };
        let mut runs = self.runs();
        runs.retain(|run| run.len() < PLATEAU || !jumps(run));
        runs
    }

    fn is_limit(&self, extreme: f64, runs: &[Range<usize>]) -> bool {
        let at_limit = runs.iter().filter(|run| self.signal[run.start] == extreme);
        let lengths: Vec<usize> = at_limit.map(Range::len).collect();
        let held: usize = lengths.iter().filter(|length| **length >= PLATEAU).sum();
        let all: usize = lengths.iter().sum();
        held as f64 >= PLATEAU_SHARE * self.signal.len() as f64
            && all as f64 >= PILE * self.beside(extreme) as f64
    }

    /// How often the value next to the extreme one occurs.
    fn beside(&self, extreme: f64) -> usize {
        let distance = |x: &f64| (x - extreme).abs();
        let others = self.signal.iter().filter(|x| **x != extreme);
        let nearest = others.map(distance).fold(f64::INFINITY, f64::min);
        let alike = |x: &&f64| **x != extreme && distance(x) == nearest;
        self.signal.iter().filter(alike).count()
    }

    /// Samples whose neighbours, two on either side, lie so near a limit that noise decides what is cut off.
    fn near(&self, limit: f64) -> Vec<usize> {
        let free = |x: &&[f64]| x.iter().all(|x| *x != limit);
        let noise = deviation(self.signal.windows(SPAN).filter(free));
        let middle = |k: usize| {
            let mut x = [k - 2, k - 1, k + 1, k + 2].map(|k| self.signal[k]);
            x.sort_by(f64::total_cmp);
            0.5 * (x[1] + x[2])
        };
        let inner = 2..self.signal.len().saturating_sub(2);
        let is_near = |k: &usize| (middle(*k) - limit).abs() <= NEAR_SIGMA * noise;
        inner.filter(is_near).collect()
    }
}

/// Samples of a fourth difference.
const SPAN: usize = 5;

/// Deviation of the noise by fourth differences, most of which a motion and rare faults leave alone; 0 of none.
fn deviation<'a>(windows: impl Iterator<Item = &'a [f64]>) -> f64 {
    let mut sizes: Vec<f64> = windows.map(|x| fourth(x, 1).abs()).collect();
    match sizes.is_empty() {
        true => 0.0,
        false => normal_scale(quantile(&mut sizes, 0.5)) / 70.0_f64.sqrt(),
    }
}

/// Signals that stand still.
impl Series<'_> {
    /// At a limit a signal that is cut off stands still by itself.
    fn stuck(&self, limits: &[f64]) -> Option<Lost> {
        let enough = (MOVING_QUANTA * quantum(self.position))
            .max(MOVING_SHARE * range(self.position))
            .max(f64::MIN_POSITIVE);
        let mut runs = self.runs();
        runs.retain(|run| {
            !limits.contains(&self.signal[run.start]) && range(&self.position[run.clone()]) > enough
        });
        let longest = runs.iter().max_by_key(|run| run.len())?.clone();
        let alike = self.chance_of_alike(&self.moves(), &longest);
        let count = self.signal.len() as f64;
        let is_chance = |run: &Range<usize>| {
            run.len() < LEAST_STUCK
                || count.ln() + (run.len() - 1) as f64 * alike.ln() > CHANCE.ln()
        };
        let (usual, mut lost): (Vec<Range<usize>>, Vec<_>) = runs.into_iter().partition(is_chance);
        let longest_usual = usual.iter().map(Range::len).max().unwrap_or(0);
        lost.retain(|run| run.len() >= LONGER * longest_usual);
        let first = lost.first()?.start;
        let samples = lost.into_iter().flatten().collect();
        Some(Lost {
            found: self.lost(Loss::Stuck, samples, vec![self.signal[first]]),
            beside: Vec::new(),
        })
    }

    /// Whether the joint moves, by sample.
    fn moves(&self) -> Vec<bool> {
        let last = self.position.len() - 1;
        let way = |k: usize| {
            (self.position[(k + BESIDE).min(last)] - self.position[k.saturating_sub(BESIDE)]).abs()
        };
        let ways: Vec<f64> = (0..=last).map(way).collect();
        let mut usual: Vec<f64> = ways.iter().copied().filter(|way| *way > 0.0).collect();
        if usual.is_empty() {
            return vec![false; ways.len()];
        }
        let least = MOVING_SPEED * quantile(&mut usual, 0.5);
        ways.iter().map(|way| *way > least).collect()
    }

    /// Probability that two samples in a row are alike while the joint moves, by those outside a run.
    fn chance_of_alike(&self, moves: &[bool], run: &Range<usize>) -> f64 {
        let is_usual = |k: &usize| moves[*k] && !run.contains(k) && self.counts(*k);
        let usual: Vec<usize> = (1..self.signal.len()).filter(is_usual).collect();
        let alike = |k: &&usize| self.signal[**k] == self.signal[**k - 1];
        let of_others = usual.iter().filter(alike).count() as f64 / usual.len().max(1) as f64;
        let mut changes: Vec<f64> = self.changes().collect();
        if changes.is_empty() {
            return 1.0;
        }
        let step = quantile(&mut changes, SMALL_CHANGES);
        let windows = usual.iter().filter_map(|&k| self.signal.get(k..k + SPAN));
        let noise = deviation(windows);
        // Of no noise all samples are alike.
        let of_noise = match noise > 0.0 {
            true => 1.0 - 2.0 * Distribution::Normal.upper_tail(0.5 * step / noise),
            false => 1.0,
        };
        of_noise.max(of_others)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution as _, StandardNormal};

    const ROWS: usize = 3000;

    /// A motion at 100 Hz, and a signal with noise in steps of a converter.
    fn taken(step: f64, noise: f64) -> Recording {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(11);
        let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
        let angle = |k: usize| (0.02 * k as f64).sin() + 0.3 * (0.053 * k as f64).sin();
        let position = (0..ROWS).map(|k| (1e4 * angle(k)).round() / 1e4);
        let signal = (0..ROWS).map(|k| {
            let speed = 0.02 * (0.02 * k as f64).cos() + 0.016 * (0.053 * k as f64).cos();
            let torque = 2.0 * angle(k) + speed / (speed.abs() + 1e-3) + noise * draw();
            (torque / step).round() * step
        });
        Recording::of_samples("made.csv", vec![position.collect()], vec![signal.collect()])
    }

    fn found(recording: Recording) -> Option<LostSignal> {
        marked(recording, SignalKind::Current).lost
    }

    #[test]
    fn samples_at_a_limit_and_near_it_are_left_out() {
        let mut recording = taken(1e-9, 0.05);
        let whole = recording.signal[0].clone();
        recording.signal[0]
            .iter_mut()
            .for_each(|x| *x = x.clamp(-2.0, 1.5));
        let lost = found(recording).unwrap();
        let [channel] = &lost.channels[..] else {
            panic!("{:?}", lost.channels.len())
        };
        assert_eq!((channel.loss, channel.left_out), (Loss::Saturated, true));
        assert_eq!(channel.values, [1.5, -2.0]);
        let beyond = (0..ROWS).filter(|&k| !(-2.0..1.5).contains(&whole[k]));
        assert_eq!(channel.samples, beyond.collect::<Vec<_>>());
        assert!(channel.samples.iter().all(|&k| !lost.valid[k]));
        // Between two samples that are cut off, the noise alone has spared one.
        let between =
            (1..ROWS - 1).filter(|k| [k - 1, k + 1].iter().all(|k| channel.samples.contains(k)));
        let spared = between.filter(|&k| lost.valid[k]).count();
        assert!(spared * 20 < channel.samples.len(), "{spared}");
    }

    #[test]
    fn a_signal_that_drops_or_freezes_while_the_joint_moves_is_left_out() {
        for (value, step) in [
            (Some(0.0), 1e-9),
            (Some(5.0), 1e-9),
            (None, 1e-9),
            (None, 0.05),
        ] {
            let mut recording = taken(step, 0.05);
            let value = value.unwrap_or(recording.signal[0][999]);
            recording.signal[0][1000..1030].fill(value);
            let lost = found(recording).unwrap();
            assert_eq!(lost.channels.len(), 1);
            assert_eq!(lost.channels[0].loss, Loss::Stuck);
            let out: Vec<usize> = (0..ROWS).filter(|&k| !lost.valid[k]).collect();
            assert!((1000..1030).all(|k| out.contains(&k)));
            assert!(out.len() <= 32, "{value}, {step}: {}", out.len());
        }
    }

    #[test]
    fn honest_signals_are_kept() {
        for step in [1e-9, 0.01, 0.05, 0.1, 0.3, 1.0] {
            for noise in [0.0, 0.01, 0.05] {
                assert_eq!(found(taken(step, noise)), None, "{step}, {noise}");
            }
        }
    }

    #[test]
    fn a_joint_that_rests_may_have_a_signal_that_stands_still() {
        let mut recording = taken(1e-9, 0.05);
        for series in recording.position.iter_mut().chain(&mut recording.signal) {
            let value = series[1000];
            series[1000..1200].fill(value);
        }
        assert_eq!(found(recording), None);
    }

    #[test]
    fn too_much_is_said_and_not_left_out() {
        let dead = Recording {
            signal: vec![vec![0.4; ROWS]],
            ..taken(1e-9, 0.05)
        };
        let mut frozen = taken(1e-9, 0.05);
        let value = frozen.signal[0][2000];
        frozen.signal[0][2000..].fill(value);
        for recording in [dead, frozen] {
            let lost = found(recording).unwrap();
            assert!(!lost.channels[0].left_out);
            assert!(lost.valid.iter().all(|valid| *valid));
        }
    }
}
