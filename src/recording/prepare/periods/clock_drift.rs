//! Clocks of time stamps that drift against a motion that repeats.
//!
//! A controller repeats a motion in periods T that are all equally long. Where a stamp is s = t + δ(s), with t by the
//! clock of the controller, the recorded motion q differs from period to period by
//!
//! ```text
//! q(s) − q(s + T) = q̇(s) (δ(s + T) − δ(s)) + noise,    δ = Σ_m c_m P_m,    m = 1 … M:
//! ```
//!
//! linear least squares in the c_m, with Legendre polynomials P_m over the recording. The linear term belongs to T itself.

use nalgebra::{DMatrix, DVector};

use crate::recording::channels::samples::{ClockDrift, Recording};
use crate::recording::prepare::periods::period::{Lagged, of_positions, thinned, variance};
use crate::recording::time_base::timing::{Timing, UNIFORM_STEPS, examine};

/// Highest degree M of a drift, which is one for every period as long as there are fewer: what a clock does within a period,
/// and again within each, does not show.
const MOST_DEGREE: usize = 12;

/// A drift takes at least this share of what changes from period to period: a cause that beats all others together.
const LEADING: f64 = 0.5;

/// And it is so many deviations from nothing, at least. Samples of a motion that wanders depend on each other, which makes
/// the deviation of this estimate, as if of white noise, too small by as much as their number in a wave of the motion, some
/// hundred, has for its root.
const SURE: f64 = 15.0;

/// Steps of Gauss and Newton: a drift is small beside the waves of the motion, so that the second changes next to nothing.
const STEPS: usize = 3;

/// Takes the drift of its clock out of a recording of a motion that repeats.
pub fn steadied(mut recording: Recording) -> Recording {
    let Some(stamps) = recording.time.clone() else {
        return recording;
    };
    let mut periods: Option<[f64; 2]> = None;
    for _ in 0..STEPS {
        let (Some(time), Ok(timing)) = (&recording.time, examine(&recording, None)) else {
            break;
        };
        let Some(drift) = Drift::of(&recording, &timing) else {
            break;
        };
        let steady: Vec<f64> = time.iter().map(|t| t - drift.at(*t)).collect();
        if steady.windows(2).any(|pair| pair[1] <= pair[0]) {
            break;
        }
        periods = periods.or(Some(drift.periods()));
        recording.time = Some(steady);
    }
    if let (Some(periods), Some(steady)) = (periods, &recording.time) {
        let shifts = stamps.iter().zip(steady).map(|(s, t)| (s - t).abs());
        let shift = shifts.fold(0.0, f64::max);
        recording.clock_drift = Some(ClockDrift { periods, shift });
    }
    recording
}

/// δ(s) over a recording.
struct Drift {
    /// s; of the polynomials of degree 2 and up.
    coefficients: Vec<f64>,
    /// First and last stamp, s.
    span: [f64; 2],
    /// s.
    period: f64,
}

impl Drift {
    /// None where none is sure, or where it is less than stamps of an even clock may be off.
    fn of(recording: &Recording, timing: &Timing) -> Option<Self> {
        let time = recording.time.as_ref()?;
        let (positions, rate_hz) = thinned(recording, timing);
        let found = of_positions(&positions, rate_hz)?;
        let lag = found.period * rate_hz;
        let count = positions.first()?.len();
        let degree = ((count as f64 / lag) as usize).min(MOST_DEGREE);
        let system = Changes::between_periods(&positions, lag, degree)?;
        let solution = system.solve(found.noise)?;
        let drift = Self {
            coefficients: solution.iter().skip(1).map(|c| c / rate_hz).collect(),
            span: [time[0], time[time.len() - 1]],
            period: found.period,
        };
        let greatest = time.iter().map(|t| drift.at(*t).abs());
        let greatest = greatest.fold(0.0, f64::max);
        (greatest > UNIFORM_STEPS / timing.rate_hz).then_some(drift)
    }

    /// −1 at the first stamp and 1 at the last.
    fn within(&self, stamp: f64) -> f64 {
        let [first, last] = self.span;
        2.0 * (stamp - first) / (last - first) - 1.0
    }

    /// s.
    fn at(&self, stamp: f64) -> f64 {
        let values = legendre(self.within(stamp), self.coefficients.len() + 1);
        let terms = self.coefficients.iter().zip(&values[2..]);
        terms.map(|(c, p)| c * p).sum()
    }

    /// Shortest and longest period by the stamps, s.
    fn periods(&self) -> [f64; 2] {
        let [first, last] = self.span;
        let begins = (last - first - self.period).max(0.0);
        // So many places find the extremes of a polynomial of this degree to a share of 1e-3 of what it varies.
        let places = 300;
        let lengths = (0..=places).map(|k| {
            let begin = first + begins * f64::from(k) / f64::from(places);
            self.period + self.at(begin + self.period) - self.at(begin)
        });
        lengths.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], length| {
            [low.min(length), high.max(length)]
        })
    }
}

/// The normal equations of what changes from a period to the next.
struct Changes {
    matrix: DMatrix<f64>,
    right: DVector<f64>,
    /// Sum of the squares of what changes, and how many there are.
    squares: f64,
    count: usize,
    /// Variance of the positions, summed over joints.
    variance: f64,
    joints: usize,
}

impl Changes {
    /// None where hardly anything lies a period behind.
    fn between_periods(positions: &[Vec<f64>], lag: f64, degree: usize) -> Option<Self> {
        let mut sums = Self {
            matrix: DMatrix::zeros(degree, degree),
            right: DVector::zeros(degree),
            squares: 0.0,
            count: 0,
            variance: 0.0,
            joints: positions.len(),
        };
        let samples = positions.first()?.len();
        let within = |k: f64| 2.0 * k / (samples - 1) as f64 - 1.0;
        let later: Vec<DVector<f64>> = (0..samples)
            .map(|k| {
                let [now, then] = [k as f64, k as f64 + lag].map(|k| legendre(within(k), degree));
                DVector::from_iterator(degree, (1..=degree).map(|m| then[m] - now[m]))
            })
            .collect();
        for q in positions {
            sums.variance += variance(q);
            for (k, change) in Lagged::new(q, lag)?.changes() {
                let speed = 0.5 * (q[k + 1] - q[k - 1]);
                let row = &later[k] * speed;
                sums.matrix.ger(1.0, &row, &row, 1.0);
                sums.right.axpy(change, &row, 1.0);
                sums.squares += change * change;
                sums.count += 1;
            }
        }
        Some(sums)
    }

    /// Coefficients in samples; None unless they are sure and take most of what is not noise, of which the positions'
    /// variance has this share.
    fn solve(self, noise: f64) -> Option<DVector<f64>> {
        let count = self.count as f64;
        let solution = self.matrix.clone().cholesky()?.solve(&self.right);
        // What the linear term takes belongs to the period and not to a drift.
        let period = self.right[0] * self.right[0] / self.matrix[(0, 0)];
        let taken = self.right.dot(&solution) - period;
        let left = (self.squares - period - taken).max(f64::MIN_POSITIVE);
        let of_noise = 2.0 * noise * self.variance * count / self.joints as f64;
        let moves = self.squares - period - of_noise;
        let is_sure = taken > SURE * SURE * (solution.len() - 1) as f64 * left / count;
        (solution.len() > 1 && is_sure && taken > LEADING * moves).then_some(solution)
    }
}

/// Legendre polynomials up to a degree: (m + 1) P_{m+1} = (2 m + 1) x P_m − m P_{m−1}.
fn legendre(x: f64, degree: usize) -> Vec<f64> {
    let mut values = vec![1.0, x];
    for m in 1..degree {
        let (m, next) = (m as f64, values[m]);
        let after = ((2.0 * m + 1.0) * x * next - m * values[values.len() - 2]) / (m + 1.0);
        values.push(after);
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use std::f64::consts::TAU;

    /// Two joints at 100 Hz, five and a half periods of 10 s by the clock of their controller, stamped otherwise.
    fn recording(stamp: impl Fn(f64) -> f64, position: impl Fn(usize, f64) -> f64) -> Recording {
        let clock: Vec<f64> = (0..5500).map(|k| 0.01 * f64::from(k)).collect();
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let mut joint = |j: usize| {
            let noisy = clock.iter().map(|t| {
                let noise: f64 = StandardNormal.sample(&mut rng);
                position(j, *t) + 1e-5 * noise
            });
            noisy.collect::<Vec<f64>>()
        };
        let positions = vec![joint(0), joint(1)];
        let signal = vec![vec![0.0; clock.len()]; 2];
        let stamps = clock.iter().map(|t| stamp(*t)).collect();
        Recording::of_samples("made.csv", positions, signal).at(stamps)
    }

    fn repeating(joint: usize, t: f64) -> f64 {
        let wave = |h: f64| (TAU * h * t / 10.0 + h).sin() / h;
        [wave(1.0) + wave(4.0), wave(2.0) + wave(3.0)][joint]
    }

    #[test]
    fn recovers_known_drift_but_for_a_constant_rate() {
        // 0.2 % fast at the end, as a parabola, and waves of 3 ms beside it.
        let stamp = |t: f64| t + 1e-3 * t * t / 55.0 + 3e-3 * (t / 10.0).sin();
        let steady = steadied(recording(stamp, repeating));
        let [shortest, longest] = steady.clock_drift.unwrap().periods;
        assert!(
            shortest < 10.005 && longest > 10.015,
            "{shortest} {longest}"
        );
        // What remains against the clock of the controller is a straight line.
        let time = steady.time.unwrap();
        let last = time.len() - 1;
        let line = |k: usize| time[0] + (time[last] - time[0]) * k as f64 / last as f64;
        let worst = (0..time.len()).map(|k| (time[k] - line(k)).abs());
        let worst = worst.fold(0.0, f64::max);
        // Polynomials up to the fifth degree miss so much of those waves.
        assert!(worst < 0.2e-3, "{worst}");
    }

    #[test]
    fn leaves_clocks_that_are_even_and_motions_that_wander() {
        let even = recording(|t| 1.001 * t, repeating);
        assert_eq!(steadied(even.clone()), even);
        // The first joint's amplitude grows by a hundredth: no clock does that.
        let grown =
            |j: usize, t: f64| repeating(j, t) * (1.0 + if j == 0 { 2e-4 * t } else { 0.0 });
        let wanders = recording(|t| t, grown);
        assert_eq!(steadied(wanders.clone()), wanders);
        let sweep = recording(|t| t, |j, t| (0.05 * (j + 1) as f64 * t * t).sin());
        assert_eq!(steadied(sweep.clone()), sweep);
    }
}
