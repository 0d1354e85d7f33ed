//! Random aperiodic motions within the limits and the band of frequencies of the Fourier series.
//!
//! ```text
//! tones    f_h = (h + u)/T, h = 1 … H, u uniform in (−1/2, 1/2) for every joint: no common period
//! sweeps   from (1/2 … 1)/T to (0.6 … 1) H/T
//! moves    all joints begin and end together, at 40 to 100 % of the speed that limits allow
//! ```
//!
//! T is the period and H the number of harmonics of the Fourier series that the same problem file would give.

use crate::robot::random::between;
use crate::setup::limits::JointLimits;
use crate::simulate::aperiodic::{Aperiodic, Move, Sweep, Tone, Waveform};
pub use crate::simulate::random_frame::Kind;
use crate::simulate::random_frame::{Frame, SHARE};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

/// Hz at which limits are looked at: 200 in a cycle of the highest frequency of common motions, 1 Hz.
pub(super) const LOOK_RATE: f64 = 200.0;

/// Shares of the greatest speed at which programs of robots run.
const SPEEDS: (f64, f64) = (0.4, 1.0);

/// s between two moves: a controller settles and goes on.
const RESTS: (f64, f64) = (0.1, 0.4);

/// Shortest move, s: joints that hardly move wait for nothing, and no command is shorter.
const SHORTEST: f64 = 0.2;

/// A motion of the joints of `duration` s that keeps to 80 % of the limits of positions, speeds, accelerations and jerks.
pub(super) fn draw(
    frame: &Frame<'_>,
    kind: Kind,
    duration: f64,
    rng: &mut ChaCha8Rng,
) -> Aperiodic {
    let n = frame.limits.len();
    let waveforms: Vec<Waveform> = match kind {
        Kind::Tones => (0..n).map(|_| tones(frame, rng)).collect(),
        Kind::Sweeps => frame
            .limits
            .iter()
            .map(|of| sweep(frame, of, duration, rng))
            .collect(),
        Kind::Moves => moves(frame, duration, rng),
    };
    let mut centre = Vec::with_capacity(n);
    let mut amplitude = Vec::with_capacity(n);
    for (j, (waveform, limits)) in waveforms.iter().zip(frame.limits).enumerate() {
        let locked = frame.plant.joints()[j].locked;
        centre.push(if locked {
            frame.plant.offset()[j]
        } else {
            limits.middle()
        });
        amplitude.push(match (locked, kind) {
            (true, _) => 0.0,
            (false, Kind::Moves) => SHARE * limits.half_range(),
            (false, _) => SHARE * largest(waveform, limits, duration),
        });
    }
    Aperiodic::new(duration, waveforms, [centre, amplitude])
}

/// Amplitudes fall with the frequency, so that all tones move the joint at the same speed.
fn tones(frame: &Frame<'_>, rng: &mut ChaCha8Rng) -> Waveform {
    let tone = |h: usize| {
        let frequency = TAU * (h as f64 + between(rng, -0.5, 0.5)) / frame.period;
        let normal: f64 = StandardNormal.sample(rng);
        Tone {
            amplitude: normal / frequency,
            frequency,
            phase: TAU * rng.random::<f64>(),
        }
    };
    Waveform::Tones((1..=frame.harmonics).map(tone).collect())
}

fn sweep(frame: &Frame<'_>, limits: &JointLimits, duration: f64, rng: &mut ChaCha8Rng) -> Waveform {
    let lowest = TAU / frame.period;
    let from = lowest * between(rng, 0.5, 1.0);
    let to = lowest * frame.harmonics as f64 * between(rng, 0.6, 1.0);
    Waveform::Sweep(Sweep {
        frequency: from,
        growth: (to - from) / duration,
        phase: TAU * rng.random::<f64>(),
        bounds: [limits.half_range(), limits.velocity, limits.acceleration],
    })
}

/// Poses uniform over the range, in units of 80 % of half of it; the joint with the farthest way sets the pace.
fn moves(frame: &Frame<'_>, duration: f64, rng: &mut ChaCha8Rng) -> Vec<Waveform> {
    let pose = |rng: &mut ChaCha8Rng| -> Vec<f64> {
        let joints = frame.limits.iter();
        joints.map(|_| between(rng, -1.0, 1.0)).collect()
    };
    let mut waveforms = vec![Vec::new(); frame.limits.len()];
    let mut from = pose(rng);
    let mut start = between(rng, RESTS.0, RESTS.1);
    while start < duration {
        let to = pose(rng);
        let moving = (0..from.len()).filter(|&j| !frame.plant.joints()[j].locked);
        let least = moving.map(|j| shortest(&frame.limits[j], (to[j] - from[j]).abs()));
        let length = least.fold(SHORTEST, f64::max) / between(rng, SPEEDS.0, SPEEDS.1);
        for (waveform, (from, to)) in waveforms.iter_mut().zip(from.iter().zip(&to)) {
            waveform.push(Move {
                start,
                duration: length,
                from: *from,
                to: *to,
            });
        }
        start += length + between(rng, RESTS.0, RESTS.1);
        from = to;
    }
    waveforms.into_iter().map(Waveform::Moves).collect()
}

/// s of the shortest move over `way` halves of the range within 80 % of a joint's limits.
fn shortest(limits: &JointLimits, way: f64) -> f64 {
    let way = way * limits.half_range();
    let [speed, acceleration, jerk] = Move::PEAKS.map(|peak| peak * way);
    let at_speed = speed / limits.velocity;
    let at_acceleration = (acceleration / limits.acceleration).sqrt();
    let at_jerk = limits.jerk.map_or(0.0, |bound| (jerk / bound).cbrt());
    at_speed.max(at_acceleration).max(at_jerk)
}

/// The factor with which a waveform reaches its tightest limit.
fn largest(waveform: &Waveform, limits: &JointLimits, duration: f64) -> f64 {
    let mut peaks = [0.0_f64; 4];
    let mut before: Option<f64> = None;
    for k in 0..=(duration * LOOK_RATE).ceil() as usize {
        let [q, dq, ddq] = waveform.at(k as f64 / LOOK_RATE);
        let jerk = before.map_or(0.0, |before| (ddq - before) * LOOK_RATE);
        before = Some(ddq);
        for (peak, value) in peaks.iter_mut().zip([q, dq, ddq, jerk]) {
            *peak = peak.max(value.abs());
        }
    }
    let bounds = [
        limits.half_range(),
        limits.velocity,
        limits.acceleration,
        limits.jerk.unwrap_or(f64::INFINITY),
    ];
    let ratios = bounds.iter().zip(peaks).map(|(bound, peak)| bound / peak);
    ratios.fold(f64::INFINITY, f64::min)
}
