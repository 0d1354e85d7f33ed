//! A wider band where a joint reverses.
//!
//! Dry friction turns over within milliseconds of a reversal; a joint that a controller leads falls behind its course there and
//! is brought back, faster than it moves otherwise. A smoother with the band of the rest of the motion draws that out, and the
//! error of its acceleration biases the friction that is fitted, or looks like bristles. So the white noise that drives the
//! motion may be stronger about reversals, by the factor r⁸ for a band that is r times as wide. That it is so is seen in the
//! positions: the smoother's innovations behind reversals are larger than those behind extremes of the speed (a test of their
//! ratio), and a wider band makes the samples likelier,
//!
//! ```text
//! ln L = -½ N ln(Σ ν²/S / N) - ½ Σ ln S,
//! ```
//!
//! with innovations ν of variances S (Schweppe 1965), by more than chance does (Wilks 1938). About the reversals of a joint the
//! others, which it pushes, are asked the same. The signal has the last word: a wider band is taken where it leaves less of it.

use rayon::prelude::*;

use crate::recording::prepare::derivatives::cutoff::HIGHEST_CUTOFF;
use crate::recording::prepare::derivatives::smoother::{Forward, Smoothed, Smoother, Unrest};
use crate::stats::deviation::rms;
use crate::stats::distribution::Distribution;
use crate::stats::likelihood_ratio::is_beyond_chance;

/// With what probability an even motion is taken for such.
const CONFIDENCE: f64 = 0.99;

/// How many times as wide a band may be about reversals.
const RATIOS: [f64; 3] = [2.0, 4.0, 8.0];

/// How far a wider band may reach to either side of a reversal, in time constants of the smoother; begun with the second.
const REACHES: [f64; 3] = [1.0, 2.0, 4.0];

/// Reversals are between speeds of at least this share of the RMS speed to either side; less may be noise of a joint at rest.
const CLEAR_SPEED: f64 = 0.03;

/// Rows that tell how wide a band is: so many that a factor of the noise of a hundredth of them is known to a tenth.
const ROWS: usize = 20_000;

/// Where the band of each joint is wider.
pub(super) struct AboutReversals {
    /// Of all joints, at which one of them stands out.
    pub reversals: usize,
    /// By joint.
    pub unrest: Vec<Unrest>,
}

/// Where the motions of the joints of one recording, smoothed with an even band, ask for a wider one: about a joint's own
/// reversals, and about those of the joints that push it there.
pub(super) fn about_reversals(
    joints: &[Smoother<'_>],
    even: &[Smoothed],
) -> Option<AboutReversals> {
    let turns: Vec<Turns> = even.iter().map(|e| Turns::of(&e.motion[1])).collect();
    let with = joints.par_iter().zip(&turns);
    let own: Vec<Option<Unrest>> = with.map(|(joint, turns)| turns.unrest(joint)).collect();
    let any = own.iter().flatten().cloned().reduce(Unrest::or)?;
    let found = turns.iter().zip(&own).filter(|(_, own)| own.is_some());
    let reversals = found.map(|(turns, _)| turns.reversals.len()).sum();
    let with = joints.par_iter().zip(own);
    let unrest = with.map(|(joint, own)| beside(joint, own.unwrap_or_default(), &any));
    Some(AboutReversals {
        reversals,
        unrest: unrest.collect(),
    })
}

/// The likeliest unrest of a joint about the reversals of any, beside that about its own.
fn beside(joint: &Smoother<'_>, own: Unrest, any: &Unrest) -> Unrest {
    let tried = RATIOS.map(|ratio| {
        let unrest = any.with_factor(factor(joint, ratio)).or(own.clone());
        Tried::new(joint, ratio, unrest)
    });
    let without = joint.log_likelihood(&own, ROWS);
    let best = likeliest(tried).filter(|best| best.is_needed(without, 1));
    best.map_or(own, |best| best.unrest)
}

/// Of the noise that drives a motion, for a band so many times as wide, or as wide as the rate lets it be.
fn factor(joint: &Smoother<'_>, ratio: f64) -> f64 {
    let widest = HIGHEST_CUTOFF * joint.band.rate_hz / joint.band.cutoff_hz;
    ratio.min(widest).powi(8)
}

/// What was tried.
struct Tried {
    /// Of the width of the band about reversals to that elsewhere.
    ratio: f64,
    unrest: Unrest,
    log_likelihood: f64,
}

impl Tried {
    fn new(joint: &Smoother<'_>, ratio: f64, unrest: Unrest) -> Self {
        Self {
            ratio,
            log_likelihood: joint.log_likelihood(&unrest, ROWS),
            unrest,
        }
    }

    /// Whether it is likelier than without it, and so many parameters less, by more than chance makes it.
    fn is_needed(&self, log_likelihood_without: f64, parameters: usize) -> bool {
        let gain = self.log_likelihood - log_likelihood_without;
        is_beyond_chance(2.0 * gain, parameters, CONFIDENCE)
    }
}

fn likeliest(tried: impl IntoIterator<Item = Tried>) -> Option<Tried> {
    let likelier = |a: &Tried, b: &Tried| a.log_likelihood.total_cmp(&b.log_likelihood);
    tried.into_iter().max_by(likelier)
}

/// Rows of a motion.
struct Turns {
    /// The first with the other sign of the speed.
    reversals: Vec<usize>,
    /// Greatest speed between two reversals.
    extremes: Vec<usize>,
}

impl Turns {
    fn of(speed: &[f64]) -> Self {
        let least = CLEAR_SPEED * rms(speed);
        let (mut reversals, mut extremes) = (Vec::new(), Vec::new());
        let (mut sign, mut crossing, mut extreme) = (0.0, 0, 0);
        for (row, v) in speed.iter().enumerate() {
            if row > 0 && v.signum() != speed[row - 1].signum() {
                crossing = row;
            }
            if v.abs() < least {
                continue;
            }
            if v.signum() != sign {
                if sign != 0.0 {
                    reversals.push(crossing);
                    extremes.push(extreme);
                }
                (sign, extreme) = (v.signum(), row);
            }
            if v.abs() > speed[extreme].abs() {
                extreme = row;
            }
        }
        Self {
            reversals,
            extremes,
        }
    }

    /// The likeliest unrest about reversals, where there is any.
    fn unrest(&self, joint: &Smoother<'_>) -> Option<Unrest> {
        let even = joint.forward(&Unrest::default());
        if !self.stand_out(joint, &even) {
            return None;
        }
        let tried = |ratio: f64, reach: f64| {
            let rows = joint.rows_of(reach);
            let unrest = self.about(rows, factor(joint, ratio), even.rows());
            Tried::new(joint, ratio, unrest)
        };
        let [least, usual, most] = REACHES;
        let first = likeliest(RATIOS.map(|ratio| tried(ratio, usual)))?;
        let [nearer, farther] = [least, most].map(|reach| tried(first.ratio, reach));
        let best = likeliest([nearer, farther, first])?;
        let without = even.log_likelihood(ROWS);
        best.is_needed(without, 2).then_some(best.unrest)
    }

    /// Unrest to so many rows to either side of every reversal.
    fn about(&self, reach: usize, factor: f64, rows: usize) -> Unrest {
        let mut factors = vec![1.0; rows];
        for &row in &self.reversals {
            factors[row.saturating_sub(reach)..(row + reach + 1).min(rows)].fill(factor);
        }
        Unrest { factor: factors }
    }

    /// Whether innovations behind reversals are larger than those behind extremes. Those of one window count as one, as they may
    /// depend on each other.
    fn stand_out(&self, joint: &Smoother<'_>, even: &Forward) -> bool {
        let mean = |rows: &[usize]| even.mean_innovation_behind(rows, joint.rows_of(2.0));
        let windows = self.reversals.len() as f64;
        if windows < 1.0 {
            return false;
        }
        let by_chance = Distribution::variance_ratio(windows);
        mean(&self.reversals) > mean(&self.extremes) * by_chance.quantile(CONFIDENCE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::prepare::derivatives::smoother::{Band, Channel};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution as _, StandardNormal};
    use std::f64::consts::TAU;

    const RATE: f64 = 100.0;
    const NOISE: f64 = 4e-6;

    /// Position and acceleration, sample by sample.
    struct Led {
        position: Vec<f64>,
        acceleration: Vec<f64>,
    }

    /// An inertia of 1 kg·m² with dry friction, in N·m, that a controller leads along two sines with a bandwidth of 6 Hz; its
    /// positions have noise.
    fn led(friction: f64, seed: u64) -> Led {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let course = |t: f64| {
            let of = |size: f64, hz: f64| {
                let w = TAU * hz;
                [
                    size * (w * t).sin(),
                    size * w * (w * t).cos(),
                    -size * w * w * (w * t).sin(),
                ]
            };
            let (a, b) = (of(0.5, 0.31), of(0.2, 0.83));
            [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
        };
        let (stiffness, damping) = ((TAU * 6.0).powi(2), 2.0 * TAU * 6.0);
        let fine = 200;
        let step = 1.0 / (RATE * fine as f64);
        let [mut q, mut v, _] = course(0.0);
        let mut led = Led {
            position: Vec::new(),
            acceleration: Vec::new(),
        };
        for k in 0..3000 * fine {
            let [r, rv, ra] = course(k as f64 * step);
            let a = ra + stiffness * (r - q) + damping * (rv - v) - friction * (v / 0.01).tanh();
            if k % fine == 0 {
                let noise: f64 = StandardNormal.sample(&mut random);
                led.position.push(q + NOISE * noise);
                led.acceleration.push(a);
            }
            v += step * a;
            q += step * v;
        }
        led
    }

    fn smoother(positions: &[f64]) -> Smoother<'_> {
        let position = Channel {
            series: positions,
            order: 0,
            variance: NOISE * NOISE,
        };
        let band = Band {
            cutoff_hz: 10.0,
            rate_hz: RATE,
        };
        Smoother::new(vec![position], None, band)
    }

    #[test]
    fn accelerations_about_reversals_with_dry_friction_are_nearer_to_the_truth() {
        let led = led(2.0, 1);
        let smoothers = [smoother(&led.position)];
        let even = smoothers[0].smoothed(&Unrest::default());
        let about = about_reversals(&smoothers, std::slice::from_ref(&even)).unwrap();
        assert!((40..=60).contains(&about.reversals), "{}", about.reversals);
        let wider = smoothers[0].smoothed(&about.unrest[0]);
        let rows: Vec<usize> = (50..2950)
            .filter(|&row| about.unrest[0].factor[row] > 1.0)
            .collect();
        let error = |smoothed: &Smoothed| {
            let of = |&row: &usize| smoothed.motion[2][row] - led.acceleration[row];
            rms(&rows.iter().map(of).collect::<Vec<f64>>())
        };
        let (before, after) = (error(&even), error(&wider));
        assert!(after < 0.5 * before, "{before} to {after}");
    }

    /// A chance of one in a hundred each: five of thirty and more have one of five millions.
    #[test]
    fn a_motion_without_friction_asks_for_no_wider_band() {
        let found = (0..30).filter(|&seed| {
            let led = led(0.0, seed);
            let smoothers = [smoother(&led.position)];
            let even = smoothers[0].smoothed(&Unrest::default());
            about_reversals(&smoothers, &[even]).is_some()
        });
        let found = found.count();
        assert!(found < 5, "{found}");
    }
}
