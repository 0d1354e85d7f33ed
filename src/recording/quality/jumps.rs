//! Jumps of positions: steps between two samples that no motion makes, and that stay, as where an encoder slips, where turns are
//! counted anew from zero, where samples are lost that no stamps tell of, or where a file holds two recordings.
//!
//! ```text
//! d_k = Δ_k − (4 Δ_{k−1} + 4 Δ_{k+1} − Δ_{k−2} − Δ_{k+2})/6,     Δ_k = q_{k+1} − q_k
//! |d_k| > max(8 σ̂, 8 quanta, 2 R_k)
//! ```
//!
//! with the cubic through the four steps beside one, the robust deviation σ̂ of all d that are not zero, and the range R of the four
//! steps. However hard a joint accelerates or stops, a step of its motion is about within the range of its neighbours. A sample that
//! was taken by τ steps too late, or after others that are lost, is where all joints jump by as many of their own steps:
//!
//! ```text
//! d_kj = τ (Δ_kj − d_kj),     Σ_j (d_kj − τ (Δ_kj − d_kj))²/σ̂_j² < Σ_j d_kj²/σ̂_j² / 10
//! ```

use crate::recording::channels::samples::Recording;
use crate::recording::quality::spikes::{self, SPIKE_SIGMA, quantum};
use crate::recording::series::differences::steps;
use crate::recording::time_base::timing::GAP_STEPS;
use crate::stats::deviation::range;
use crate::stats::robust::{mad_scale, median};
use rayon::prelude::*;
use std::ops::Range;

/// Quanta of a position that a jump exceeds: its steps are sums of rounding of a few counts.
const QUANTA: f64 = 8.0;

/// Ranges of the four steps beside it that a jump exceeds: at the hardest stop, between a speed and rest, the step between is off the
/// cubic by half of it, and by all of it where the sample was held.
const RANGES: f64 = 2.0;

/// Share of the squares of jumps up to which one time explains them; of two slips at once as much is explained by chance in
/// one of five.
const IN_TIME: f64 = 0.1;

/// A step of one joint that no motion makes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointJump {
    /// Its number.
    pub joint: usize,
    /// By how much the step is longer than the motion's own, in the unit of the position, signed.
    pub size: f64,
    /// It is longer than every step of the joint's motion: no sample that comes early or late makes it.
    pub is_beyond_motion: bool,
}

/// Two samples between which positions jump.
#[derive(Debug, Clone, PartialEq)]
pub struct Jump {
    /// The sample before it.
    pub before: usize,
    /// The joints of which the step stands out.
    pub joints: Vec<JointJump>,
    /// By how many steps the second sample comes late, where that explains the jumps of several joints.
    pub late: Option<f64>,
}

/// Jumps of the positions, in the order of time; samples that stand out alone are spikes.
pub fn jumps(recording: &Recording) -> Vec<Jump> {
    let time = recording.time.as_deref();
    let joints: Vec<Steps> = (recording.position.par_iter())
        .map(|position| Steps::of(position, time))
        .collect();
    let count = joints.first().map_or(0, |joint| joint.steps.len());
    let at = (0..count).filter(|&k| joints.iter().any(|joint| joint.stands_out[k]));
    let jump = |before: usize| {
        let out = joints.iter().enumerate();
        let out = out.filter(|(_, steps)| steps.stands_out[before]);
        let of_joint = |(joint, steps): (usize, &Steps)| JointJump {
            joint,
            size: steps.off[before],
            is_beyond_motion: steps.off[before].abs() > steps.longest,
        };
        Jump {
            before,
            joints: out.map(of_joint).collect(),
            late: late(&joints, before),
        }
    };
    at.map(jump).collect()
}

/// τ where it explains the steps of all joints that move there.
fn late(joints: &[Steps], at: usize) -> Option<f64> {
    let (mut own_own, mut own_off, mut off_off, mut moving) = (0.0, 0.0, 0.0, 0);
    for steps in joints.iter().filter(|steps| steps.scale > 0.0) {
        let [off, own] = [steps.off[at], steps.own(at)].map(|x| x / steps.scale);
        own_own += own * own;
        own_off += own * off;
        off_off += off * off;
        moving += usize::from(own.abs() > SPIKE_SIGMA);
    }
    let left = off_off - own_off * own_off / own_own;
    (moving > 1 && left < IN_TIME * off_off).then(|| own_off / own_own)
}

/// Steps of a joint between successive samples.
struct Steps {
    steps: Vec<f64>,
    /// d, NaN where a neighbour is missing.
    off: Vec<f64>,
    /// σ̂; zero where nothing moves.
    scale: f64,
    /// The longest step of the motion.
    longest: f64,
    /// Whether no motion makes the step.
    stands_out: Vec<bool>,
}

impl Steps {
    fn of(position: &[f64], time: Option<&[f64]>) -> Self {
        let steps = evened(position, time);
        let inner = 2..steps.len().saturating_sub(2);
        let mut off = vec![f64::NAN; steps.len()];
        for k in inner.clone() {
            let [a, b, c, d] = beside(&steps, k);
            off[k] = steps[k] - (4.0 * (b + c) - a - d) / 6.0;
        }
        let others: Vec<f64> = off
            .iter()
            .copied()
            .filter(|d| d.is_finite() && *d != 0.0)
            .collect();
        let scale = mad_scale(&others).unwrap_or(0.0);
        let mut found = Self {
            steps,
            off,
            scale,
            longest: 0.0,
            stands_out: Vec::new(),
        };
        found.stands_out = found.out_of(position, inner);
        let own = (0..found.steps.len()).map(|k| found.own(k).abs());
        found.longest = own.filter(|step| step.is_finite()).fold(0.0, f64::max);
        found
    }

    /// The step that the motion makes of itself.
    fn own(&self, k: usize) -> f64 {
        match self.stands_out[k] {
            true => self.steps[k] - self.off[k],
            false => self.steps[k],
        }
    }

    fn out_of(&self, position: &[f64], inner: Range<usize>) -> Vec<bool> {
        let mut stands_out = vec![false; self.steps.len()];
        if self.scale == 0.0 {
            return stands_out;
        }
        let least = (SPIKE_SIGMA * self.scale).max(QUANTA * quantum(position));
        let alone = spikes::spikes(position, spikes::Channel::Smooth);
        let is_spike = |k: usize| alone.iter().any(|spike| spike.at == k || spike.at == k + 1);
        for k in inner {
            let off = self.off[k].abs();
            stands_out[k] =
                off > least && off > RANGES * range(&beside(&self.steps, k)) && !is_spike(k);
        }
        stands_out
    }
}

/// The four steps beside one.
fn beside(steps: &[f64], k: usize) -> [f64; 4] {
    [steps[k - 2], steps[k - 1], steps[k + 1], steps[k + 2]]
}

/// Steps between successive samples; over uneven ones what the usual time would have made of them, over gaps none (NaN).
fn evened(position: &[f64], time: Option<&[f64]>) -> Vec<f64> {
    let plain = steps(position);
    let Some(time) = time else {
        return plain;
    };
    let times = steps(time);
    let usual = median(&times).unwrap_or(0.0);
    let of = |(step, time): (f64, &f64)| match *time <= GAP_STEPS * usual {
        true => step * usual / time,
        false => f64::NAN,
    };
    plain.into_iter().zip(&times).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    const COUNTS: f64 = 65536.0 / std::f64::consts::TAU;
    const STEP: f64 = 0.01;

    /// Positions of an encoder along a motion with stops: moves of 1 rad with trapezoidal speed and rests between.
    fn moves() -> Vec<f64> {
        let mut q = 0.0;
        let speed = |k: usize| {
            let phase = k % 300;
            let up = (phase as f64 * 0.05).min(1.5);
            let down = ((200.0 - phase as f64) * 0.05).max(0.0);
            let sign = if (k / 300).is_multiple_of(2) {
                1.0
            } else {
                -1.0
            };
            sign * up.min(down)
        };
        let mut at = |k: usize| {
            q += STEP * speed(k);
            (q * COUNTS).round() / COUNTS
        };
        (0..3000).map(&mut at).collect()
    }

    fn found(position: &[Vec<f64>], time: Option<Vec<f64>>) -> Vec<Jump> {
        let mut recording = Recording::of_samples("made.csv", position.to_vec(), position.to_vec());
        recording.time = time;
        jumps(&recording)
    }

    /// Two joints, the second twice as far and the other way round.
    fn both(position: Vec<f64>) -> [Vec<f64>; 2] {
        let other = position.iter().map(|q| -2.0 * q).collect();
        [position, other]
    }

    #[test]
    fn motions_with_stops_noise_and_hard_impacts_do_not_jump() {
        assert_eq!(found(&[moves()], None), []);
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let noisy = moves()
            .iter()
            .map(|q| q + 2e-4 * (rng.random::<f64>() - 0.5))
            .collect();
        assert_eq!(found(&[noisy], None), []);
        // Thrown back and forth between two walls, and held for two samples of three.
        let zigzag = |k: usize| ((k % 40) as f64 - 20.0).abs() * 0.01;
        assert_eq!(found(&[(0..2000).map(zigzag).collect()], None), []);
        let held: Vec<f64> = moves().iter().flat_map(|q| [*q; 3]).collect();
        assert_eq!(found(&[held], None), []);
    }

    /// A slip is found where it is, with its size; samples that are lost, doubled or late by the motion's own steps.
    #[test]
    fn slips_and_samples_at_wrong_times_are_told_apart() {
        let [mut slipped, other] = both(moves());
        slipped[1080..].iter_mut().for_each(|q| *q += 0.02);
        let [jump] = &found(&[slipped, other], None)[..] else {
            panic!("one jump")
        };
        assert_eq!((jump.before, jump.joints.len(), jump.late), (1079, 1, None));
        assert!((jump.joints[0].size - 0.02).abs() < 1e-3 && jump.joints[0].is_beyond_motion);
        let mut lost = moves();
        lost.drain(1080..1082);
        let mut doubled = moves();
        doubled.insert(1080, doubled[1079]);
        let mut late = moves();
        let half = 0.5 * (late[1001] - late[1000]);
        late[1000..].iter_mut().for_each(|q| *q += half);
        for (position, steps) in [(lost, 2.0), (doubled, -1.0), (late, 0.5)] {
            let found = found(&both(position), None);
            let [jump] = &found[..] else {
                panic!("one jump of {steps}: {found:?}")
            };
            assert!(
                (jump.late.unwrap() - steps).abs() < 0.05,
                "{steps}: {jump:?}"
            );
        }
    }

    /// Uneven samples and gaps are no jumps, by their stamps.
    #[test]
    fn stamps_explain_uneven_samples() {
        let motion = |t: f64| (1.7 * t).sin();
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut time: Vec<f64> = (0..3000).map(|k| STEP * f64::from(k)).collect();
        time.iter_mut()
            .for_each(|t| *t += 0.006 * (rng.random::<f64>() - 0.5));
        time.drain(1000..1040);
        let position = time.iter().map(|t| motion(*t)).collect();
        assert_eq!(found(&[position], Some(time)), []);
    }
}
