//! Fourier series of a periodic position, its derivatives, and how many harmonics the data bear.
//!
//! q(t) = c_0 + Σ_{h<=H} 2 Re(c_h e^{i h ω t}); differentiation multiplies c_h by i h ω.
//! Leaving harmonic h out costs the acceleration (hω)⁴ |true c_h|², taking it in (hω)⁴ σ_h², where
//! σ_h² is the noise variance of c_h. As E|c_h|² = |true c_h|² + σ_h², the H that minimises the
//! estimated error maximises  Σ_{h<=H} (hω)⁴ (|c_h|² - 2 σ_h²)  (Mallows, 1973, for his C_p).

use std::f64::consts::TAU;

use nalgebra::DMatrix;
use realfft::num_complex::Complex;

use crate::recording::prepare::motion_error::{JointErrors, MotionError};
use crate::recording::series::spectrum::{
    band_end, clear_until, coefficients, noise_power, synthesis,
};

/// The series of one joint's mean position.
#[derive(Debug, Clone)]
pub(super) struct JointSpectrum {
    /// c_h from h = 0 to half the rate.
    pub coefficients: Vec<Complex<f64>>,
    /// Noise variances of the coefficients.
    pub noise: Vec<f64>,
    /// The highest harmonic that is summed.
    pub summed: usize,
    /// Whether what is summed is to be shrunk to what of it is motion.
    pub shrinks: bool,
}

impl JointSpectrum {
    /// Multiplies every harmonic by a gain.
    pub fn filter(&mut self, gain: impl Fn(usize) -> f64) {
        let pairs = self.coefficients.iter_mut().zip(&mut self.noise);
        for (h, (c, variance)) in pairs.enumerate() {
            *c *= gain(h);
            *variance *= gain(h).powi(2);
        }
    }

    /// Position, velocity and acceleration over one period of `samples` rows.
    pub fn sum(&self, samples: usize, period: f64) -> [Vec<f64>; 3] {
        let omega = TAU / period;
        [0, 1, 2].map(|order| {
            let factor = |h: usize| Complex::new(0.0, h as f64 * omega).powi(order);
            let kept = self.coefficients[..=self.summed].iter().enumerate();
            synthesis(kept.map(|(h, c)| c * factor(h)).collect(), samples)
        })
    }
}

/// Share of the spectrum at its top that is taken for noise: the upper quarter.
const FLOOR_FROM: f64 = 0.75;

/// Noise variance of each coefficient of a mean, from those of the periods' differences from it.
///
/// The scatter between periods is pooled over bands. It misses what repeats with the motion, as
/// quantisation does when the periods are alike; so the level at the top of the mean's own
/// spectrum bounds it from below.
fn noise_of_mean(mean: &[Complex<f64>], differences: &[Vec<Complex<f64>>]) -> Vec<f64> {
    let count = mean.len();
    let mut variances = vec![0.0; count];
    let degrees = differences.len().saturating_sub(1) as f64;
    if degrees > 0.0 {
        let scatter = |h: usize| -> f64 {
            let squares: f64 = differences.iter().map(|c| c[h].norm_sqr()).sum();
            squares / (degrees * differences.len() as f64)
        };
        let mut low = 0;
        while low < count {
            let high = band_end(low, count);
            // The constant is a real number, of half the degrees of freedom: it takes the level of
            // the lowest band and has no part in it.
            let mut powers: Vec<f64> = (low.max(1)..high).map(scatter).collect();
            variances[low..high].fill(noise_power(&mut powers, degrees));
            low = high;
        }
    }
    let floor = top_level(mean);
    variances.iter_mut().for_each(|v| *v = v.max(floor));
    variances
}

/// By how much the mean of the powers of white noise exceeds what their median says of it: with fifty lines and more both are
/// known to a fifth.
const UNEVEN: f64 = 2.0;

/// Power of a coefficient at the top of the spectrum: by the median, or the mean where some lines hold most of it, as the rounding of
/// a motion of few harmonics does, which repeats with them.
fn top_level(mean: &[Complex<f64>]) -> f64 {
    let from = (FLOOR_FROM * mean.len() as f64) as usize;
    let mut powers: Vec<f64> = mean[from..].iter().map(|c| c.norm_sqr()).collect();
    let all = powers.iter().sum::<f64>() / powers.len().max(1) as f64;
    let even = noise_power(&mut powers, 1.0);
    if all > UNEVEN * even { all } else { even }
}

/// The number of harmonics with the least estimated error of the acceleration.
pub(super) fn choose_harmonics(mean: &[Complex<f64>], noise: &[f64], samples: usize) -> usize {
    let all = 1..=most_harmonics(samples);
    harmonics_worth_having(all.map(|h| mean[h].norm_sqr() - 2.0 * noise[h]))
}

/// The number of harmonics with the least error of the acceleration, from what each, the first first, takes from the
/// error of its coefficient.
pub(super) fn harmonics_worth_having(gains: impl Iterator<Item = f64>) -> usize {
    let (mut sum, mut best) = (0.0, 0.0);
    let mut chosen = 0;
    for (h, gain) in (1..).zip(gains) {
        sum += f64::from(h).powi(4) * gain;
        if sum > best {
            best = sum;
            chosen = h as usize;
        }
    }
    // A joint at rest has no harmonic worth having; one keeps the series a series.
    chosen.max(1)
}

/// Harmonics that stand clear of the noise.
pub(super) fn clear_harmonics(mean: &[Complex<f64>], noise: &[f64], harmonics: usize) -> usize {
    let power: Vec<f64> = mean.iter().map(|c| c.norm_sqr()).collect();
    // The constant is no motion.
    clear_until(&power[1..=harmonics], &noise[1..=harmonics])
}

/// Harmonics below half the rate: the one at half the rate has no derivative.
pub(super) fn most_harmonics(samples: usize) -> usize {
    ((samples - 1) / 2).max(1)
}

/// Covariances across joints of the errors of a row's positions, velocities and accelerations, from those of the coefficients.
pub(super) fn row_errors(errors: &[DMatrix<f64>], period: f64) -> MotionError {
    let omega = TAU / period;
    // An error n_h adds 2 Re(n_h e^{ihωt}) to a row, of variance 2 E|n_h|².
    let of_order = |order: i32| {
        let terms = errors.iter().enumerate().skip(1);
        let terms = terms.map(|(h, errors)| errors * (2.0 * (h as f64 * omega).powi(2 * order)));
        let constant = &errors[0] * if order == 0 { 1.0 } else { 0.0 };
        JointErrors::of_covariance(terms.fold(constant, |sum, term| sum + term))
    };
    MotionError {
        position: of_order(0),
        velocity: of_order(1),
        acceleration: of_order(2),
    }
}

/// A joint stands still where nothing moves it by more than this share of its position, which is rounding.
const ROUNDING: f64 = 1e-14;

/// Coefficients of the mean of one joint and their noise variances, from the mean and from the
/// differences of the periods, one after the other.
pub(super) fn analyse(mean: &[f64], differences: &[f64]) -> (Vec<Complex<f64>>, Vec<f64>) {
    let periods: Vec<_> = differences.chunks(mean.len()).map(coefficients).collect();
    let mut mean = coefficients(mean);
    if let [place, motion @ ..] = mean.as_mut_slice()
        && motion.iter().all(|c| c.norm() <= ROUNDING * place.norm())
    {
        motion.fill(Complex::new(0.0, 0.0));
    }
    let noise = noise_of_mean(&mean, &periods);
    (mean, noise)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    const PERIOD: f64 = 10.0;

    /// The acceleration over one period.
    fn acceleration(coefficients: &[Complex<f64>], summed: usize, samples: usize) -> Vec<f64> {
        let spectrum = JointSpectrum {
            coefficients: coefficients.to_vec(),
            noise: Vec::new(),
            summed,
            shrinks: false,
        };
        let [_, _, acceleration] = spectrum.sum(samples, PERIOD);
        acceleration
    }

    /// Amplitudes that fall off as h⁻³, up to harmonic 30, sampled with white noise.
    fn noisy(sd: f64, samples: usize, periods: usize) -> (Vec<f64>, Vec<f64>) {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(7);
        let clean = |k: usize| -> f64 {
            let phase = TAU * k as f64 / samples as f64;
            (1..=30)
                .map(|h| (h as f64 * phase + h as f64).sin() / (h as f64).powi(3))
                .sum()
        };
        let all: Vec<Vec<f64>> = (0..periods)
            .map(|_| {
                let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
                (0..samples).map(|k| clean(k) + sd * draw()).collect()
            })
            .collect();
        let mean = |k: usize| all.iter().map(|p| p[k]).sum::<f64>() / periods as f64;
        let mean: Vec<f64> = (0..samples).map(mean).collect();
        let difference = |period: &Vec<f64>| {
            let pairs = period.iter().zip(&mean);
            pairs.map(|(x, m)| x - m).collect::<Vec<f64>>()
        };
        let differences = all.iter().flat_map(difference).collect();
        (mean, differences)
    }

    fn error(mean: &[f64], truth: &[f64]) -> f64 {
        let squares: f64 = mean.iter().zip(truth).map(|(a, b)| (a - b).powi(2)).sum();
        (squares / mean.len() as f64).sqrt()
    }

    #[test]
    fn chooses_nearly_the_best_number_of_harmonics() {
        let (truth, _) = noisy(0.0, 1001, 1);
        let exact = coefficients(&truth);
        let clean = acceleration(&exact, 30, 1001);
        for (sd, periods) in [(1e-6, 6), (1e-5, 6), (1e-4, 4), (1e-3, 6), (1e-5, 1)] {
            let (mean, all) = noisy(sd, 1001, periods);
            let (c, noise) = analyse(&mean, &all);
            let of = |harmonics| error(&acceleration(&c, harmonics, 1001), &clean);
            let chosen = choose_harmonics(&c, &noise, 1001);
            let best = (1..=60).map(of).fold(f64::INFINITY, f64::min);
            // The error is flat about its least; the criterion's own scatter costs little of it.
            assert!(of(chosen) <= 1.3 * best, "sd {sd}: {chosen} harmonics");
        }
    }

    /// 25 cycles in 1540 samples repeat five times within the period, so that their rounding has a line in every fifth
    /// harmonic and nothing between. Rounding that is taken for motion would reach up to half the rate.
    #[test]
    fn rounding_of_one_harmonic_is_no_motion() {
        let (samples, cycles, step) = (1540, 25, TAU / 1_048_576.0);
        let rounded = |k: usize| {
            let sine = (TAU * (cycles * k) as f64 / samples as f64 + 0.05).sin();
            (0.09 * sine / step).round() * step
        };
        let mean: Vec<f64> = (0..samples).map(rounded).collect();
        let (c, noise) = analyse(&mean, &vec![0.0; 10 * samples]);
        let chosen = choose_harmonics(&c, &noise, samples);
        assert!(
            (cycles..10 * cycles).contains(&chosen),
            "{chosen} harmonics"
        );
    }

    #[test]
    fn recovers_known_variance_of_the_acceleration() {
        let (sd, samples, periods) = (1e-4, 1000, 6);
        let (mean, all) = noisy(sd, samples, periods);
        let (_, noise) = analyse(&mean, &all);
        let errors: Vec<DMatrix<f64>> = (noise[..=10].iter())
            .map(|variance| DMatrix::from_element(1, 1, *variance))
            .collect();
        let found = row_errors(&errors, PERIOD)
            .acceleration
            .deviation(0)
            .powi(2);
        let per_harmonic = sd * sd / (samples * periods) as f64;
        let omega = TAU / PERIOD;
        let sum: f64 = (1..=10).map(|h| (h as f64 * omega).powi(4)).sum();
        let exact = 2.0 * per_harmonic * sum;
        // Median of 15 powers of 5 degrees of freedom each: relative standard error about 0.15.
        assert!((found / exact - 1.0).abs() < 0.5);
    }

    #[test]
    fn matches_closed_form_derivatives_of_a_sine() {
        for samples in [100, 101] {
            let sine = |k: usize| (TAU * 3.0 * k as f64 / samples as f64).sin();
            let position: Vec<f64> = (0..samples).map(sine).collect();
            let c = coefficients(&position);
            let spectrum = JointSpectrum {
                noise: vec![0.0; c.len()],
                coefficients: c,
                summed: 5,
                shrinks: false,
            };
            let [_, velocity, acceleration] = spectrum.sum(samples, PERIOD);
            let omega = TAU * 3.0 / PERIOD;
            for k in 0..samples {
                let cosine = (TAU * 3.0 * k as f64 / samples as f64).cos();
                assert!((velocity[k] - omega * cosine).abs() < 1e-12);
                assert!((acceleration[k] + omega * omega * sine(k)).abs() < 1e-11);
            }
        }
    }

    /// Sums of h⁴ (|c|² − 2 ν) with ν = 1: 1 up to the first harmonic, −15 up to the second, 0.39 up to the third, which is
    /// less than the first alone.
    #[test]
    fn harmonics_are_those_of_the_least_error_of_the_acceleration() {
        let chosen = |third: f64| {
            let mut powers = vec![0.0; 51];
            powers[1..4].copy_from_slice(&[3.0, 1.0, third]);
            let mean: Vec<Complex<f64>> = powers
                .iter()
                .map(|p| Complex::new(f64::sqrt(*p), 0.0))
                .collect();
            choose_harmonics(&mean, &[1.0; 51], 100)
        };
        assert_eq!(chosen(2.19), 1);
        assert_eq!(chosen(2.21), 3);
        assert_eq!(
            choose_harmonics(&[Complex::new(0.0, 0.0); 51], &[1.0; 51], 100),
            1
        );
    }
}
