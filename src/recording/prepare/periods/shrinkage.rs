//! What noise leaves of the motion of all joints: the expected motion given the data.
//!
//! The coefficients c_h of the joints at harmonic h are the true ones and noise of the variances σ²_h, independent
//! of joint to joint. The expected true ones given the data are (Wiener, 1949)
//!
//! ```text
//! ĉ_h = S (S + Σ)⁻¹ c_h       S: powers of the motion across joints, Σ = diag(σ²_h)
//! ```
//!
//! with the errors of covariance S (S + Σ)⁻¹ Σ, orthogonal to the estimate, so that they bias no parameter and no filter of
//! the motion can look like physics. The joints are taken together, since a jump of one joint's friction moves its neighbours
//! by the inertia that couples them: where accelerations nearly cancel in a torque their noise does not, and what is best
//! for each joint alone leaves several times the noise in that torque.
//!
//! S is that of the band about a harmonic, over m coefficients with a real and an imaginary part of n joints. Eigenvalues λ of
//! Σ^{-1/2} (mean of c cᴴ) Σ^{-1/2} up to `(1 + √γ)²`, γ = (n − 1) / 2m, are those of noise; above it λ comes from a
//! power ℓ of the motion in units of its noise, along a direction that is off by the angle θ (Donoho, Gavish and
//! Johnstone 2018, sec. 1, whose ℓ is the sum of this one and the noise's 1):
//!
//! ```text
//! ℓ = (λ + 1 − γ + √((λ + 1 − γ)² − 4 λ)) / 2 − 1       cos²θ = (1 − γ/ℓ²) / (1 + γ/ℓ)
//! ```
//!
//! and what a direction has of the motion is ℓ cos²θ.
//!
//! What many joints say of one that has no motion of its own is noise too: m coefficients follow by chance what they can of
//! tr G directions. By Stein's (1981) estimate the error of s ĉ_h at joint j, G = S (S + Σ)⁻¹, is
//!
//! ```text
//! |c_h − s ĉ_h|² − σ²_h + 2 s (G_jj + (1 − G_jj) tr G / 2m) σ²_h
//! ```
//!
//! s is that of the least sum in the band, from 0 to 1, and the series of a joint ends where the sum of (hω)⁴ times what its
//! harmonics take from the error is largest.

use std::ops::Range;

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use realfft::num_complex::Complex;

use crate::recording::prepare::periods::fourier::{JointSpectrum, harmonics_worth_having};
use crate::recording::series::spectrum::{BAND_LEAST, BAND_RATIO};

/// Noise of coefficients below this share of a position and its motion is rounding.
const ROUNDING: f64 = 1e-12;

/// A band follows the harmonics in steps of this share of its half width.
const STEP: f64 = 0.125;

/// Shrinks what is summed of the spectra to the share of it that is motion, where that is estimated, and ends it where more adds
/// noise alone. Gives the covariance across joints of the errors of the coefficients, for every harmonic.
pub(super) fn shrink(spectra: &mut [JointSpectrum]) -> Vec<DMatrix<f64>> {
    for spectrum in spectra.iter_mut() {
        spectrum.shrinks &= !is_rounding(spectrum);
    }
    let estimated = spectra.iter().filter(|s| s.shrinks).map(|s| s.summed);
    let widest = estimated.max().unwrap_or(0);
    for spectrum in spectra.iter_mut().filter(|s| s.shrinks) {
        spectrum.summed = widest;
    }
    let recorded = spectra.to_vec();
    let summed = recorded.iter().map(|s| s.summed).max().unwrap_or(0);
    let mut errors: Vec<DMatrix<f64>> = (0..=summed)
        .map(|h| DMatrix::from_diagonal(&noise(&recorded, h)))
        .collect();
    let gains = gains(&recorded, widest);
    for (h, gain) in (1..).zip(&gains) {
        errors[h] = &gain.matrix * &errors[h];
    }
    for (j, spectrum) in spectra.iter_mut().enumerate().filter(|(_, s)| s.shrinks) {
        let own = JointGains {
            recorded: &recorded,
            gains: &gains,
            joint: j,
        };
        let estimates: Vec<Complex<f64>> = (1..=widest).map(|h| own.estimate(h)).collect();
        let shares = own.shares(&estimates);
        let scaled: Vec<Complex<f64>> =
            estimates.iter().zip(&shares).map(|(c, s)| c * *s).collect();
        spectrum.summed = own.worth_having(&scaled, &shares);
        spectrum.coefficients[1..=widest].copy_from_slice(&scaled);
        for (h, share) in (1..=widest).zip(&shares) {
            let share = if h <= spectrum.summed {
                share.sqrt()
            } else {
                0.0
            };
            errors[h].row_mut(j).scale_mut(share);
            errors[h].column_mut(j).scale_mut(share);
        }
    }
    errors
}

/// Whether all noise of a joint is rounding, which tells nothing of other joints.
fn is_rounding(spectrum: &JointSpectrum) -> bool {
    let size: f64 = spectrum.coefficients.iter().map(|c| c.norm_sqr()).sum();
    let mut noise = spectrum.noise.iter();
    noise.all(|variance| *variance <= ROUNDING * ROUNDING * size)
}

/// What multiplies the coefficients of every harmonic from the first to the last.
fn gains(spectra: &[JointSpectrum], last: usize) -> Vec<Gain> {
    let mut gains = Vec::with_capacity(last);
    for Neighbours { harmonics, reach } in neighbours(last) {
        let centre = harmonics.start + harmonics.len() / 2;
        let band = Band::about(spectra, centre, reach);
        gains.extend(harmonics.map(|h| band.gain(spectra, h)));
    }
    gains
}

/// Harmonics that have a band in common.
struct Neighbours {
    harmonics: Range<usize>,
    /// How far the band reaches to both sides of them.
    reach: usize,
}

/// Those of all harmonics from the first to the last.
fn neighbours(last: usize) -> impl Iterator<Item = Neighbours> {
    let mut start = 1;
    std::iter::from_fn(move || {
        let reach = ((0.5 * (BAND_RATIO - 1.0) * start as f64) as usize).max(BAND_LEAST / 2);
        let step = ((STEP * reach as f64) as usize).max(1);
        let harmonics = start..(start + step).min(last + 1);
        start = harmonics.end;
        (!harmonics.is_empty()).then_some(Neighbours { harmonics, reach })
    })
}

/// The gains of one joint.
struct JointGains<'a> {
    recorded: &'a [JointSpectrum],
    gains: &'a [Gain],
    joint: usize,
}

impl JointGains<'_> {
    fn estimate(&self, h: usize) -> Complex<f64> {
        let gain = self.gains[h - 1].matrix.row(self.joint);
        let of = |b: usize| self.recorded[b].coefficients[h] * gain[b];
        let sources = (0..self.recorded.len()).filter(|&b| gain[b] != 0.0);
        sources.map(of).sum()
    }

    /// What noise alone adds to the product of a coefficient and its estimate.
    fn of_noise(&self, h: usize) -> f64 {
        let gain = &self.gains[h - 1];
        let own = gain.matrix[(self.joint, self.joint)];
        (own + (1.0 - own) * gain.by_chance) * self.recorded[self.joint].noise[h]
    }

    /// What multiplies each estimate from the first on for the least error in its band.
    fn shares(&self, estimates: &[Complex<f64>]) -> Vec<f64> {
        let own = &self.recorded[self.joint].coefficients;
        let share = |band: Range<usize>| {
            let product = |h: usize| (own[h] * estimates[h - 1].conj()).re - self.of_noise(h);
            let explained: f64 = band.clone().map(product).sum();
            let size: f64 = band.map(|h| estimates[h - 1].norm_sqr()).sum();
            if explained > 0.0 {
                (explained / size).min(1.0)
            } else {
                0.0
            }
        };
        let last = estimates.len();
        let of = |Neighbours { harmonics, reach }| {
            let low = harmonics.start.saturating_sub(reach).max(1);
            let high = (harmonics.end + reach).min(last + 1);
            vec![share(low..high); harmonics.len()]
        };
        neighbours(last).flat_map(of).collect()
    }

    /// Harmonics up to which estimates lower the error of the acceleration.
    fn worth_having(&self, estimates: &[Complex<f64>], shares: &[f64]) -> usize {
        let own = &self.recorded[self.joint].coefficients;
        let taken = (1..).zip(estimates.iter().zip(shares));
        harmonics_worth_having(taken.map(|(h, (estimate, share))| {
            let left = (own[h] - estimate).norm_sqr();
            own[h].norm_sqr() - left - 2.0 * share * self.of_noise(h)
        }))
    }
}

/// Noise variances of what is summed of a harmonic.
fn noise(spectra: &[JointSpectrum], h: usize) -> DVector<f64> {
    let of = |s: &JointSpectrum| if h <= s.summed { s.noise[h] } else { 0.0 };
    DVector::from_iterator(spectra.len(), spectra.iter().map(of))
}

/// What multiplies the coefficients of all joints.
struct Gain {
    /// S (S + Σ)⁻¹; the unit matrix among joints whose noise is not estimated.
    matrix: DMatrix<f64>,
    /// Share of the noise of a joint that follows the others by chance, tr G / 2m.
    by_chance: f64,
}

/// Coefficients of neighbouring harmonics.
struct Band {
    /// Σ Re(c cᴴ), joints x joints.
    powers: DMatrix<f64>,
    /// Coefficients of each joint.
    count: usize,
}

/// Re(c cᴴ) of one harmonic.
fn powers(spectra: &[JointSpectrum], h: usize) -> DMatrix<f64> {
    let joints = spectra.len();
    DMatrix::from_fn(joints, joints, |a, b| {
        (spectra[a].coefficients[h] * spectra[b].coefficients[h].conj()).re
    })
}

impl Band {
    fn about(spectra: &[JointSpectrum], centre: usize, reach: usize) -> Self {
        let ends = spectra.iter().map(|s| s.coefficients.len()).min();
        let high = (centre + reach + 1).min(ends.unwrap_or(0));
        let low = centre.saturating_sub(reach).max(1).min(high);
        Self {
            powers: (low..high).map(|h| powers(spectra, h)).sum(),
            count: high - low,
        }
    }

    /// What multiplies the coefficients of the joints at a harmonic.
    fn gain(&self, spectra: &[JointSpectrum], h: usize) -> Gain {
        let shrinks = |&j: &usize| {
            let spectrum = &spectra[j];
            spectrum.shrinks && h <= spectrum.summed && spectrum.noise[h] > 0.0
        };
        let joints: Vec<usize> = (0..spectra.len()).filter(shrinks).collect();
        let deviation = |a: usize| spectra[joints[a]].noise[h].sqrt();
        let whitened = DMatrix::from_fn(joints.len(), joints.len(), |a, b| {
            let power = self.powers[(joints[a], joints[b])] / self.count as f64;
            power / (deviation(a) * deviation(b))
        });
        let shares = self.shares_of_motion(whitened);
        let mut matrix = DMatrix::identity(spectra.len(), spectra.len());
        for (a, &row) in joints.iter().enumerate() {
            for (b, &column) in joints.iter().enumerate() {
                matrix[(row, column)] = deviation(a) * shares[(a, b)] / deviation(b);
            }
        }
        Gain {
            matrix,
            by_chance: shares.trace() / (2 * self.count) as f64,
        }
    }

    /// The gain of coefficients in units of their noise.
    fn shares_of_motion(&self, whitened: DMatrix<f64>) -> DMatrix<f64> {
        let joints = whitened.nrows();
        let mut shares = DMatrix::zeros(joints, joints);
        if joints == 0 {
            return shares;
        }
        // The direction of a single joint is known.
        let gamma = (joints - 1) as f64 / (2 * self.count) as f64;
        let eigen = SymmetricEigen::new(whitened);
        let pairs = eigen
            .eigenvalues
            .iter()
            .zip(eigen.eigenvectors.column_iter());
        for (&value, direction) in pairs {
            let power = power_of_motion(value, gamma);
            shares += direction * direction.transpose() * (power / (power + 1.0));
        }
        shares
    }
}

/// Power of the motion along an eigenvector of the powers of a band, in units of the noise.
fn power_of_motion(eigenvalue: f64, gamma: f64) -> f64 {
    if eigenvalue <= (1.0 + gamma.sqrt()).powi(2) {
        return 0.0;
    }
    let sum = eigenvalue + 1.0 - gamma;
    let power = 0.5 * (sum + (sum * sum - 4.0 * eigenvalue).max(0.0).sqrt()) - 1.0;
    let cosine_squared = (1.0 - gamma / (power * power)) / (1.0 + gamma / power);
    power * cosine_squared
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const HARMONICS: usize = 200;

    const NOISE: f64 = 0.04;

    /// Coefficients of this mean power E|c|².
    fn random(power: f64, rng: &mut ChaCha8Rng) -> Vec<Complex<f64>> {
        let mut draw = || -> f64 { StandardNormal.sample(rng) };
        (0..=HARMONICS + 50)
            .map(|_| Complex::new(draw(), draw()) * (0.5 * power).sqrt())
            .collect()
    }

    /// Two joints that one cause moves, by these amounts.
    fn moved(amounts: [f64; 2], rng: &mut ChaCha8Rng) -> [Vec<Complex<f64>>; 2] {
        let cause = random(1.0, rng);
        amounts.map(|amount| cause.iter().map(|c| c * amount).collect())
    }

    fn recorded(motion: &[Vec<Complex<f64>>], rng: &mut ChaCha8Rng) -> Vec<JointSpectrum> {
        let with_noise = |motion: &Vec<Complex<f64>>| {
            let pairs = motion.iter().zip(random(NOISE, rng));
            JointSpectrum {
                coefficients: pairs.map(|(c, n)| c + n).collect(),
                noise: vec![NOISE; motion.len()],
                summed: HARMONICS,
                shrinks: true,
            }
        };
        motion.iter().map(with_noise).collect()
    }

    /// Mean power of the errors of a sum of the joints.
    fn error(spectra: &[JointSpectrum], motion: &[Vec<Complex<f64>>], weights: &[f64]) -> f64 {
        let of = |h: usize| {
            let joints = spectra.iter().zip(motion).zip(weights);
            let sum: Complex<f64> = joints
                .map(|((s, m), weight)| (s.coefficients[h] - m[h]) * *weight)
                .sum();
            sum.norm_sqr()
        };
        (1..=HARMONICS).map(of).sum::<f64>() / HARMONICS as f64
    }

    fn announced(errors: &[DMatrix<f64>], weights: &[f64]) -> f64 {
        let weights = DVector::from_column_slice(weights);
        let of = |errors: &DMatrix<f64>| (weights.transpose() * errors * &weights)[0];
        errors[1..].iter().map(of).sum::<f64>() / HARMONICS as f64
    }

    /// A torque of 1.05 of one acceleration and 0.5 of the other, in which the motion, −1 for each 2, nearly cancels.
    #[test]
    fn joints_that_move_together_lose_the_noise_in_what_nearly_cancels() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let motion = moved([-1.0, 2.0], &mut rng);
        let torque = [1.05, 0.5];
        let mut together = recorded(&motion, &mut rng);
        let before = error(&together, &motion, &torque);
        let mut alone = together.clone();
        for spectrum in &mut alone {
            shrink(std::slice::from_mut(spectrum));
        }
        let errors = shrink(&mut together);
        let [own, both] = [&alone, &together].map(|s| error(s, &motion, &torque));
        // Nearly all noise of this torque is across the motion, where each joint alone keeps it.
        assert!(own > 0.8 * before, "{own} of {before}");
        assert!(both < 0.2 * before, "{both} of {before}");
        // Of the sum of both a fifth of the noise of a joint is along the motion.
        let left = error(&together, &motion, &[1.0, 1.0]);
        let ratio = announced(&errors, &[1.0, 1.0]) / left;
        assert!((0.6..1.6).contains(&ratio), "{ratio}");
    }

    #[test]
    fn shrinking_lowers_the_error_and_announces_it() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        for power in [0.5 * NOISE, NOISE, 4.0 * NOISE] {
            let motion = [random(power, &mut rng)];
            let mut spectra = recorded(&motion, &mut rng);
            let plain = error(&spectra, &motion, &[1.0]);
            let errors = shrink(&mut spectra);
            let shrunk = error(&spectra, &motion, &[1.0]);
            // What is left of the noise at best is the share of the motion.
            let best = NOISE * power / (power + NOISE);
            assert!(shrunk < 0.95 * plain, "{shrunk} of {plain}");
            assert!(shrunk < 1.3 * best, "{shrunk} of {best}");
            let ratio = announced(&errors, &[1.0]) / shrunk;
            assert!((0.6..1.6).contains(&ratio), "{ratio}");
        }
    }

    /// Six joints, more than noise alone makes look like motion.
    #[test]
    fn noise_of_joints_at_rest_is_no_motion() {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let motion = vec![random(0.0, &mut rng); 6];
        let mut spectra = recorded(&motion, &mut rng);
        let errors = shrink(&mut spectra);
        let left = error(&spectra, &motion, &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert!(left < 0.05 * NOISE, "{left}");
        assert!(announced(&errors, &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]) < 0.05 * NOISE);
    }

    /// What is left out of one joint and not of its neighbour does not cancel in a torque.
    #[test]
    fn joints_that_move_together_have_one_band() {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let motion = moved([-1.0, 2.0], &mut rng);
        let mut spectra = recorded(&motion, &mut rng);
        spectra[0].summed = HARMONICS / 2;
        shrink(&mut spectra);
        assert_eq!([0, 1].map(|j: usize| spectra[j].summed), [HARMONICS; 2]);
    }

    /// Five joints move, each by itself, and tell by chance what they can of a sixth.
    #[test]
    fn a_joint_at_rest_has_little_of_what_others_say_of_it() {
        let mut rng = ChaCha8Rng::seed_from_u64(13);
        let (mut told, mut kept, mut by_chance) = (0.0, 0.0, 0.0);
        for _ in 0..20 {
            let mut motion = vec![random(1.0, &mut rng); 5];
            motion
                .iter_mut()
                .for_each(|own| *own = random(1.0, &mut rng));
            motion.push(random(0.0, &mut rng));
            let mut spectra = recorded(&motion, &mut rng);
            let gains = gains(&spectra, HARMONICS);
            by_chance += gains.iter().map(|gain| gain.by_chance).sum::<f64>() / HARMONICS as f64;
            shrink(&mut spectra);
            let of = |last: usize| -> f64 {
                let weighed = |h: usize| (h as f64).powi(4) * spectra[5].coefficients[h].norm_sqr();
                (1..=last).map(weighed).sum()
            };
            let noise: f64 = (1..=HARMONICS).map(|h| (h as f64).powi(4) * NOISE).sum();
            told += of(HARMONICS) / noise;
            kept += of(spectra[5].summed) / noise;
        }
        // The gains alone leave six tenths of it.
        assert!(told < 0.3 * by_chance, "{told} of {by_chance}");
        // The last harmonics add noise alone.
        assert!(kept < 0.9 * told, "{kept} of {told}");
    }

    #[test]
    fn what_is_given_stays_as_it_is_and_exact_joints_lose_nothing() {
        let mut rng = ChaCha8Rng::seed_from_u64(9);
        let motion = moved([1.0, 1.0], &mut rng);
        let mut spectra = recorded(&motion, &mut rng);
        spectra[0].shrinks = false;
        let given = spectra[0].coefficients.clone();
        let errors = shrink(&mut spectra);
        assert_eq!(spectra[0].coefficients, given);
        assert_eq!(errors[1][(0, 0)], NOISE);
        let mut spectra = recorded(&motion, &mut rng);
        spectra[0].coefficients = motion[0].clone();
        spectra[0].noise.fill(0.0);
        let errors = shrink(&mut spectra);
        assert_eq!(spectra[0].coefficients, motion[0]);
        assert_eq!(errors[1][(0, 0)], 0.0);
    }

    /// λ = ℓ₁ (1 + γ / (ℓ₁ − 1)) is what a power ℓ₁ = ℓ + 1 comes out as: 4 at γ = 0.3 as 4.4, with cos²θ = (1 − 0.3/9) / (1 + 0.1).
    #[test]
    fn recovers_a_known_power_from_its_eigenvalue() {
        let expected = 3.0 * (1.0 - 0.3 / 9.0) / 1.1;
        assert!((power_of_motion(4.4, 0.3) - expected).abs() < 1e-12);
        let edge = (1.0 + f64::sqrt(0.3)).powi(2);
        assert_eq!(power_of_motion(edge, 0.3), 0.0);
        assert!(power_of_motion(1.0001 * edge, 0.3) < 0.05);
    }
}
