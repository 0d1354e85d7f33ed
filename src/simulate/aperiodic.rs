//! Aperiodic motions: each joint about a centre by sums of sines, point-to-point moves or sweeps.
//!
//! ```text
//! x(t) = A u(t) + b,   u_j = Σ_k a_k sin(ω_k t + φ_k)                          tones
//!                      u_j = u_0 + (u_1 − u_0)(10 s³ − 15 s⁴ + 6 s⁵)           moves, s the share of a move's time
//!                      u_j = sin φ(t) / √(r² + (ω/v)² + (ω²/a)²), ω = φ̇       sweeps, ω grows evenly
//! ```
//!
//! The amplitude of a sweep is that of the range, r⁻¹, where it is slow, of the speed v in between and of the acceleration
//! a where it is fast.

use crate::simulate::motion::{Instants, Motion};
use nalgebra::{DMatrix, DVector};

/// A path whose joints each follow a waveform of their own.
#[derive(Debug, Clone)]
pub struct Aperiodic {
    /// s.
    pub duration: f64,
    waveforms: Vec<Waveform>,
    mix: DMatrix<f64>,
    shift: DVector<f64>,
}

impl Aperiodic {
    /// The path of joints that follow `waveforms` times `amplitude` about `centre`.
    pub fn new(
        duration: f64,
        waveforms: Vec<Waveform>,
        [centre, amplitude]: [Vec<f64>; 2],
    ) -> Self {
        Self {
            duration,
            waveforms,
            mix: DMatrix::from_diagonal(&DVector::from_vec(amplitude)),
            shift: DVector::from_vec(centre),
        }
    }

    pub(super) fn sample(&self, instants: Instants) -> Motion {
        let Instants { start, rate, count } = instants;
        let n = self.shift.len();
        let mut motion: Motion = std::array::from_fn(|_| vec![Vec::with_capacity(count); n]);
        for k in 0..count {
            let time = start + k as f64 / rate;
            let own: Vec<[f64; 3]> = self.waveforms.iter().map(|c| c.at(time)).collect();
            for (order, series) in motion.iter_mut().enumerate() {
                let u = DVector::from_iterator(own.len(), own.iter().map(|u| u[order]));
                let mut x = &self.mix * u;
                if order == 0 {
                    x += &self.shift;
                }
                let pairs = series.iter_mut().zip(x.iter());
                pairs.for_each(|(to, x)| to.push(*x));
            }
        }
        motion
    }

    pub(super) fn mapped(&self, matrix: &DMatrix<f64>, shift: &DVector<f64>) -> Self {
        Self {
            mix: matrix * &self.mix,
            shift: matrix * &self.shift + shift,
            ..self.clone()
        }
    }

    /// The same path about the same centre, amplitudes times `factor`.
    pub(super) fn scaled(&self, factor: f64) -> Self {
        Self {
            mix: &self.mix * factor,
            ..self.clone()
        }
    }
}

/// What one joint does.
#[derive(Debug, Clone, PartialEq)]
pub enum Waveform {
    Tones(Vec<Tone>),
    /// In the order of time.
    Moves(Vec<Move>),
    Sweep(Sweep),
}

/// A sine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tone {
    pub amplitude: f64,
    /// rad/s.
    pub frequency: f64,
    /// rad.
    pub phase: f64,
}

/// A polynomial of fifth order from rest to rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Move {
    /// s.
    pub start: f64,
    /// s.
    pub duration: f64,
    pub from: f64,
    pub to: f64,
}

/// A sine whose frequency grows evenly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sweep {
    /// rad/s at the start.
    pub frequency: f64,
    /// rad/s².
    pub growth: f64,
    /// rad.
    pub phase: f64,
    /// Bounds of the amplitudes of position, speed and acceleration.
    pub bounds: [f64; 3],
}

impl Waveform {
    /// Value and first and second derivative.
    pub fn at(&self, time: f64) -> [f64; 3] {
        match self {
            Self::Tones(tones) => {
                let all = tones.iter().map(|tone| tone.at(time));
                all.fold([0.0; 3], |s, x| std::array::from_fn(|k| s[k] + x[k]))
            }
            Self::Moves(moves) => {
                let begun = moves.partition_point(|m| m.start <= time);
                let first = moves.first().map_or([0.0; 3], |m| [m.from, 0.0, 0.0]);
                let last = begun.checked_sub(1).map(|k| moves[k].at(time));
                last.unwrap_or(first)
            }
            Self::Sweep(sweep) => sweep.at(time),
        }
    }
}

impl Tone {
    fn at(&self, time: f64) -> [f64; 3] {
        let (sine, cosine) = (self.frequency * time + self.phase).sin_cos();
        let (a, w) = (self.amplitude, self.frequency);
        [a * sine, a * w * cosine, -a * w * w * sine]
    }
}

impl Move {
    /// Largest speed, acceleration and jerk of a move over 1 in 1 s: at s = 1/2, at (3 ∓ √3)/6, and at the ends.
    pub const PEAKS: [f64; 3] = [1.875, 5.773_502_691_896_258, 60.0];

    fn at(&self, time: f64) -> [f64; 3] {
        let s = ((time - self.start) / self.duration).clamp(0.0, 1.0);
        let (way, d) = (self.to - self.from, self.duration);
        let position = s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s);
        let speed = 30.0 * (s * (1.0 - s)).powi(2);
        let acceleration = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s);
        [
            self.from + way * position,
            way * speed / d,
            way * acceleration / (d * d),
        ]
    }
}

impl Sweep {
    fn at(&self, time: f64) -> [f64; 3] {
        let w = self.frequency + self.growth * time;
        let phase = self.phase + time * (self.frequency + 0.5 * self.growth * time);
        let (sine, cosine) = phase.sin_cos();
        let [a, da, dda] = self.amplitude(w);
        [
            a * sine,
            da * sine + a * w * cosine,
            (dda - a * w * w) * sine + (2.0 * da * w + a * self.growth) * cosine,
        ]
    }

    /// The amplitude and its first and second derivative by time at a frequency.
    fn amplitude(&self, w: f64) -> [f64; 3] {
        let [r, v, a] = self.bounds.map(|bound| bound.powi(-2));
        let sum = r + v * w.powi(2) + a * w.powi(4);
        let slope = 2.0 * v * w + 4.0 * a * w.powi(3);
        let bend = 2.0 * v + 12.0 * a * w * w;
        let by_frequency = -0.5 * slope * sum.powf(-1.5);
        let twice = 0.75 * slope * slope * sum.powf(-2.5) - 0.5 * bend * sum.powf(-1.5);
        [
            sum.powf(-0.5),
            by_frequency * self.growth,
            twice * self.growth * self.growth,
        ]
    }
}
