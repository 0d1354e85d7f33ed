//! Position, velocity and acceleration of a joint from noisy samples: a fixed-interval Kalman smoother.
//!
//! ```text
//! x = (q, τ q̇, τ² q̈, τ³ q⃛),  d⁴q/dt⁴ = white noise,   y_q = q + ε_q,  y_v = q̇ + ε_v,  y_a = q̈ + ε_a
//! ```
//!
//! The intensity of the white noise is such that positions alone are smoothed with the gain `1/(1 + (f/f_c)⁸)` far
//! from the ends: that of a Butterworth filter of fourth order run forward and backward, which is the smoothing spline of
//! that order (Wahba 1978). The recursion of Rauch, Tung and Striebel (1965) needs no samples beyond the ends and passes
//! over samples that are missing. Time is in units of `τ = 1/(2π f_c)`, in which all quantities are of order one.

use nalgebra::{Matrix4, RowVector4, Vector4};
use std::f64::consts::TAU;

/// Channels that a smoother takes in, variances in their units squared.
#[derive(Debug, Clone, Copy)]
pub(in crate::recording) struct Channel<'a> {
    pub series: &'a [f64],
    /// 0 position, 1 velocity, 2 acceleration.
    pub order: usize,
    /// Variance of the noise of a sample.
    pub variance: f64,
}

/// The motion of one joint.
#[derive(Debug, Clone, Default)]
pub(super) struct Smoothed {
    /// Position, velocity and acceleration.
    pub motion: [Vec<f64>; 3],
    /// Rows whose acceleration is about as well known as any: not right at the ends, nor within long gaps.
    pub settled: Vec<bool>,
}

/// A row is settled where the variance of its acceleration is at most so many times the usual.
const SETTLED: f64 = 4.0;

/// Covariances that differ by less than this share are the same.
const SAME: f64 = 1e-9;

/// Variance of the state at the first sample, in units of what is usual: it is all but unknown.
const UNKNOWN: f64 = 1e6;

/// The band that a smoother passes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Band {
    pub cutoff_hz: f64,
    /// Of the samples.
    pub rate_hz: f64,
}

/// Where the motion changes faster than elsewhere.
#[derive(Debug, Clone, Default)]
pub(super) struct Unrest {
    /// Per row, of the intensity of the white noise that drives the motion up to it: 1 at rest; everywhere where it is empty.
    pub factor: Vec<f64>,
}

impl Unrest {
    /// Where there is one or the other, of as many rows, the stronger.
    pub fn or(mut self, other: Self) -> Self {
        if self.factor.is_empty() {
            return other;
        }
        let both = self.factor.iter_mut().zip(other.factor);
        both.for_each(|(own, other)| *own = own.max(other));
        self
    }

    /// At the same rows, with one factor.
    pub fn with_factor(&self, factor: f64) -> Self {
        let of = |own: &f64| if *own > 1.0 { factor } else { 1.0 };
        Self {
            factor: self.factor.iter().map(of).collect(),
        }
    }

    fn at(&self, row: usize) -> f64 {
        self.factor.get(row).copied().unwrap_or(1.0)
    }
}

/// A smoother of one joint's samples.
pub(super) struct Smoother<'a> {
    channels: Vec<Channel<'a>>,
    valid: Option<&'a [bool]>,
    /// Variances of the channels, in units of the first one's.
    variances: Vec<f64>,
    pub band: Band,
    tau: f64,
    transition: Matrix4<f64>,
    noise: Matrix4<f64>,
}

/// Filtered and predicted states; covariances by number, as most rows share the steady one.
pub(super) struct Forward {
    filtered: Vec<Vector4<f64>>,
    predicted: Vec<Vector4<f64>>,
    covariances: Vec<[Matrix4<f64>; 2]>,
    of_row: Vec<usize>,
    innovations: Vec<Innovation>,
}

impl Forward {
    pub fn rows(&self) -> usize {
        self.of_row.len()
    }

    /// Logarithm of the likelihood of the first samples, to a constant, at the level of noise at which it is greatest.
    pub fn log_likelihood(&self, rows: usize) -> f64 {
        let (mut channels, mut squares, mut logarithms) = (0, 0.0, 0.0);
        for innovation in self.innovations.iter().take(rows) {
            channels += innovation.channels;
            squares += innovation.squares;
            logarithms += innovation.logarithms;
        }
        let count = channels as f64;
        -0.5 * (count * (squares / count).ln() + logarithms)
    }

    /// Mean of the squares of innovations by their variances, of so many rows from each of these on.
    pub fn mean_innovation_behind(&self, rows: &[usize], count: usize) -> f64 {
        let windows = rows
            .iter()
            .map(|&row| self.innovations.iter().skip(row).take(count));
        let (mut channels, mut squares) = (0, 0.0);
        for innovation in windows.flatten() {
            channels += innovation.channels;
            squares += innovation.squares;
        }
        squares / channels as f64
    }
}

/// What the samples of a row say that the rows before did not: none, where it does not count.
#[derive(Debug, Clone, Copy, Default)]
struct Innovation {
    channels: usize,
    /// Σ of the squares by their variances.
    squares: f64,
    /// Σ of the logarithms of the variances.
    logarithms: f64,
}

/// How a sample corrects the state.
struct Gain {
    column: Vector4<f64>,
    /// Variance of the innovation and its logarithm.
    variance: f64,
    logarithm: f64,
}

impl<'a> Smoother<'a> {
    pub fn new(channels: Vec<Channel<'a>>, valid: Option<&'a [bool]>, band: Band) -> Self {
        let tau = 1.0 / (TAU * band.cutoff_hz);
        let step = 1.0 / (band.rate_hz * tau);
        let scaled = |c: &Channel<'_>| c.variance * tau.powi(2 * c.order as i32);
        let unit = channels.first().map_or(1.0, scaled).max(f64::MIN_POSITIVE);
        let factorial = [1.0, 1.0, 2.0, 6.0];
        let transition = Matrix4::from_fn(|i, j| match j >= i {
            true => step.powi((j - i) as i32) / factorial[j - i],
            false => 0.0,
        });
        // ∫ of the response of each state to the white noise, whose intensity in units of τ is the step.
        let noise = Matrix4::from_fn(|i, j| {
            let power = 7 - i - j;
            step * step.powi(power as i32) / (power as f64 * factorial[3 - i] * factorial[3 - j])
        });
        Self {
            variances: channels.iter().map(|c| scaled(c) / unit).collect(),
            channels,
            valid,
            band,
            tau,
            transition,
            noise,
        }
    }

    /// The motion that the samples show.
    pub fn smoothed(&self, unrest: &Unrest) -> Smoothed {
        self.backward(&self.forward(unrest))
    }

    /// Logarithm of the likelihood of the first samples.
    pub fn log_likelihood(&self, unrest: &Unrest, rows: usize) -> f64 {
        let rows = rows.min(self.rows());
        self.forward_over(rows, unrest).log_likelihood(rows)
    }

    /// Rows of so many time constants, rounded up.
    pub fn rows_of(&self, time_constants: f64) -> usize {
        (time_constants / self.transition[(0, 1)]).ceil() as usize
    }

    fn rows(&self) -> usize {
        self.channels.first().map_or(0, |c| c.series.len())
    }

    pub fn forward(&self, unrest: &Unrest) -> Forward {
        self.forward_over(self.rows(), unrest)
    }

    fn forward_over(&self, rows: usize, unrest: &Unrest) -> Forward {
        let counts = |k: usize| self.valid.is_none_or(|valid| valid[k]);
        let mut forward = Forward {
            filtered: Vec::with_capacity(rows),
            predicted: Vec::with_capacity(rows),
            covariances: Vec::new(),
            of_row: Vec::with_capacity(rows),
            innovations: vec![Innovation::default(); rows],
        };
        let mut state = self.start(rows, &counts);
        let mut covariance = Matrix4::from_diagonal_element(UNKNOWN);
        let (mut steady, mut steady_gains) = (false, Vec::new());
        for k in 0..rows {
            let predicted = match k {
                0 => state,
                _ => self.transition * state,
            };
            state = predicted;
            let factor = unrest.at(k);
            if steady && counts(k) && factor == 1.0 {
                forward.innovations[k] = self.correct(&mut state, k, &steady_gains);
            } else {
                let ahead = match k {
                    0 => covariance,
                    _ => {
                        let carried = self.transition * covariance * self.transition.transpose();
                        carried + self.noise * factor
                    }
                };
                let (after, gains) = match counts(k) {
                    true => self.update(ahead),
                    false => (ahead, Vec::new()),
                };
                if counts(k) {
                    forward.innovations[k] = self.correct(&mut state, k, &gains);
                }
                steady = counts(k)
                    && factor == 1.0
                    && (after - covariance).amax() <= SAME * after.amax();
                covariance = after;
                steady_gains = gains;
                forward.covariances.push([ahead, after]);
            }
            forward.of_row.push(forward.covariances.len() - 1);
            forward.predicted.push(predicted);
            forward.filtered.push(state);
        }
        forward
    }

    /// The state at the first sample: a straight line through the first samples, by least squares.
    fn start(&self, rows: usize, counts: &dyn Fn(usize) -> bool) -> Vector4<f64> {
        let step = self.transition[(0, 1)];
        let within = ((1.0 / step) as usize).max(2);
        let first: Vec<usize> = (0..rows).filter(|&k| counts(k)).take(within).collect();
        let Some(position) = self.channels.iter().find(|c| c.order == 0) else {
            return Vector4::zeros();
        };
        let n = first.len().max(1) as f64;
        let time = |k: &usize| *k as f64 * step;
        let mean_t = first.iter().map(time).sum::<f64>() / n;
        let mean_q = first.iter().map(|&k| position.series[k]).sum::<f64>() / n;
        let (mut product, mut square) = (0.0, 0.0);
        for k in &first {
            product += (time(k) - mean_t) * (position.series[*k] - mean_q);
            square += (time(k) - mean_t).powi(2);
        }
        let slope = if square > 0.0 { product / square } else { 0.0 };
        Vector4::new(mean_q - slope * mean_t, slope, 0.0, 0.0)
    }

    /// Covariance after the channels of one sample, and their gains.
    fn update(&self, mut covariance: Matrix4<f64>) -> (Matrix4<f64>, Vec<Gain>) {
        let mut gains = Vec::with_capacity(self.channels.len());
        for (channel, variance) in self.channels.iter().zip(&self.variances) {
            let column = covariance.column(channel.order).into_owned();
            let expected = column[channel.order] + variance;
            let gain = column / expected;
            let mut observed = RowVector4::zeros();
            observed[channel.order] = 1.0;
            // Joseph's form stays positive definite.
            let kept = Matrix4::identity() - gain * observed;
            covariance = kept * covariance * kept.transpose() + gain * gain.transpose() * *variance;
            gains.push(Gain {
                column: gain,
                variance: expected,
                logarithm: expected.ln(),
            });
        }
        (covariance, gains)
    }

    fn correct(&self, state: &mut Vector4<f64>, row: usize, gains: &[Gain]) -> Innovation {
        let mut innovation = Innovation::default();
        for (channel, gain) in self.channels.iter().zip(gains) {
            let observed = channel.series[row] * self.tau.powi(channel.order as i32);
            let new = observed - state[channel.order];
            *state += gain.column * new;
            innovation.channels += 1;
            innovation.squares += new.powi(2) / gain.variance;
            innovation.logarithms += gain.logarithm;
        }
        innovation
    }

    pub fn backward(&self, forward: &Forward) -> Smoothed {
        let rows = forward.of_row.len();
        let scale = [1.0, 1.0 / self.tau, 1.0 / self.tau.powi(2)];
        let mut smoothed = Smoothed {
            motion: [vec![0.0; rows], vec![0.0; rows], vec![0.0; rows]],
            settled: vec![true; rows],
        };
        let mut variances = vec![0.0; rows];
        let (mut state, mut covariance) = (Vector4::zeros(), Matrix4::zeros());
        let mut last: Option<(usize, usize, Matrix4<f64>, bool)> = None;
        for k in (0..rows).rev() {
            let own = forward.of_row[k];
            let [_, filtered] = &forward.covariances[own];
            if k + 1 == rows {
                (state, covariance) = (forward.filtered[k], *filtered);
            } else {
                let next = forward.of_row[k + 1];
                let known = last.filter(|(a, b, ..)| (*a, *b) == (own, next));
                let gain = match known {
                    Some((_, _, gain, _)) => gain,
                    None => self.gain(filtered, &forward.covariances[next][0]),
                };
                state = forward.filtered[k] + gain * (state - forward.predicted[k + 1]);
                let is_steady = known.is_some_and(|(.., steady)| steady);
                if !is_steady {
                    let [ahead, _] = &forward.covariances[next];
                    let after = filtered + gain * (covariance - ahead) * gain.transpose();
                    let same =
                        known.is_some() && (after - covariance).amax() <= SAME * after.amax();
                    covariance = 0.5 * (after + after.transpose());
                    last = Some((own, next, gain, same));
                }
            }
            for (order, series) in smoothed.motion.iter_mut().enumerate() {
                series[k] = state[order] * scale[order];
            }
            variances[k] = covariance[(2, 2)];
        }
        let mut sorted = variances.clone();
        let middle = rows / 2;
        let median = *sorted.select_nth_unstable_by(middle, f64::total_cmp).1;
        for (settled, variance) in smoothed.settled.iter_mut().zip(&variances) {
            *settled = *variance <= SETTLED * median;
        }
        smoothed
    }

    /// `P Fᵀ P⁻¹` with the covariance P⁻ that is predicted for the next row.
    fn gain(&self, filtered: &Matrix4<f64>, ahead: &Matrix4<f64>) -> Matrix4<f64> {
        let product = filtered * self.transition.transpose();
        match ahead.cholesky() {
            Some(factor) => factor.solve(&product.transpose()).transpose(),
            None => Matrix4::zeros(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::series::zero_phase::ZeroPhase;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    const RATE: f64 = 200.0;

    fn smooth(channels: &[Channel<'_>], valid: Option<&[bool]>, cutoff_hz: f64) -> Smoothed {
        let band = Band {
            cutoff_hz,
            rate_hz: RATE,
        };
        Smoother::new(channels.to_vec(), valid, band).smoothed(&Unrest::default())
    }

    fn truth(t: f64) -> [f64; 3] {
        let terms = [(0.3, 1.0), (1.1, 0.5), (2.1, 0.05)];
        let mut sum = [0.0; 3];
        for (frequency, amplitude) in terms {
            let w = TAU * frequency;
            sum[0] += amplitude * (w * t + frequency).sin();
            sum[1] += amplitude * w * (w * t + frequency).cos();
            sum[2] -= amplitude * w * w * (w * t + frequency).sin();
        }
        sum
    }

    fn noisy(rows: usize, order: usize, sd: f64, seed: u64) -> Vec<f64> {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
        (0..rows)
            .map(|k| truth(k as f64 / RATE)[order] + sd * draw())
            .collect()
    }

    fn position(series: &[f64], sd: f64) -> Channel<'_> {
        Channel {
            series,
            order: 0,
            variance: sd * sd,
        }
    }

    fn errors(smoothed: &Smoothed) -> [f64; 3] {
        let rows = smoothed.settled.len();
        let kept: Vec<usize> = (0..rows).filter(|&k| smoothed.settled[k]).collect();
        [0, 1, 2].map(|order| {
            let error = |k: &usize| smoothed.motion[order][*k] - truth(*k as f64 / RATE)[order];
            let squares: f64 = kept.iter().map(|k| error(k).powi(2)).sum();
            (squares / kept.len() as f64).sqrt()
        })
    }

    #[test]
    fn invariant_it_is_the_zero_phase_low_pass_far_from_the_ends() {
        let series = noisy(4000, 0, 1e-3, 1);
        let smoothed = smooth(&[position(&series, 1e-3)], None, 5.0);
        let mut filtered = series.clone();
        ZeroPhase::new(5.0, RATE).unwrap().apply(&mut filtered);
        for k in 600..3400 {
            // The spline lives in continuous time and the filter in samples: gains differ by a part in a thousand.
            assert!((smoothed.motion[0][k] - filtered[k]).abs() < 1e-4);
        }
    }

    #[test]
    fn velocities_that_are_measured_lower_the_error() {
        let series = noisy(4000, 0, 1e-3, 3);
        let speeds = noisy(4000, 1, 1e-3, 4);
        let alone = smooth(&[position(&series, 1e-3)], None, 8.0);
        let speed = Channel {
            series: &speeds,
            order: 1,
            variance: 1e-6,
        };
        let both = smooth(&[position(&series, 1e-3), speed], None, 8.0);
        assert!(errors(&both)[2] < 0.5 * errors(&alone)[2]);
    }

    #[test]
    fn a_gap_is_passed_over_and_its_middle_is_not_settled() {
        let sd = 1e-4;
        let mut series = noisy(4000, 0, sd, 5);
        let valid: Vec<bool> = (0..4000).map(|k| !(2000..2040).contains(&k)).collect();
        series[2000..2040].fill(1e6);
        let smoothed = smooth(&[position(&series, sd)], Some(&valid), 8.0);
        assert!(!smoothed.settled[2020] && smoothed.settled[1980] && smoothed.settled[2060]);
        assert!(errors(&smoothed)[0] < sd);
        let dropped = smoothed.settled[..1000].iter().filter(|s| !**s).count();
        // A fraction of a period of the cut-off, where a low-pass lost two.
        assert!(dropped < 12, "{dropped}");
    }
}
