//! Estimation of the period of a recorded motion.
//!
//! d(l) = Σ_j Σ_k (q_j(k) - q_j(k + l))² / (n - l) / (2 Var q) is near 1 for unrelated samples and 0
//! where the motion repeats; the least lag l at which it returns to its lowest level is the period.
//! Source: de Cheveigné and Kawahara (2002), eq. 6, for the pitch of speech.

use crate::recording::channels::samples::Recording;
use crate::recording::formats::table::LEAST_ROWS;
use crate::recording::prepare::experiment::Chosen;
use crate::recording::series::differences::fourth;
use crate::recording::series::spectrum::lagged_products;
use crate::recording::time_base::timing::{Grid, Timing, even_motion};

/// The motion must have left its start by this much of its variance before it can return.
const LEFT: f64 = 0.1;

/// A lag at which d falls below this is a repetition: a hundredth of the motion's power remains, as
/// noise and wandering from period to period.
const RETURNED: f64 = 0.01;

/// Of several repetitions the first whose d is within this of the best.
const AS_GOOD: f64 = 3.0;

/// A motion that repeats this well is averaged over its periods unasked: a hundredth of its amplitude, as
/// a controller and its encoders repeat a commanded motion.
const EXACT: f64 = 1e-4;

/// A period whose whole number of samples drifts by less than this many steps over the recording is that
/// whole number: controllers repeat a table of samples.
const WHOLE_STEPS: f64 = 0.05;

/// The samples of the last period may lie off those of the first by this fraction of a step.
const ALIGNED_STEPS: f64 = 0.05;

/// Samples to which a recording is thinned: periods need no more.
const MOST_SAMPLES: usize = 40_000;

/// A motion that repeats.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Repetition {
    /// s.
    pub period: f64,
    /// Share of the motion's power that changes from period to period, d at the period.
    pub changed: f64,
    /// Share of it that is noise of the positions.
    pub noise: f64,
}

impl Repetition {
    /// Whether periods may be averaged: nothing but noise changes from one to the next.
    pub fn is_exact(&self) -> bool {
        repeats(self.changed, self.noise)
    }
}

/// Whether a motion repeats of which these shares change and are noise. What is called noise is known within a few per
/// cent; half as much again is motion.
fn repeats(changed: f64, noise: f64) -> bool {
    changed <= EXACT + 1.5 * noise
}

/// Share of the power of positions that is white noise, from their fourth differences, `Σ (Δ⁴q)² / 70`, which hardly
/// contain the motion. Two periods differ by twice the noise, and d is half the square of what differs.
fn noise_share(positions: &[Vec<f64>]) -> f64 {
    let (mut noise, mut power) = (0.0, 0.0);
    for q in positions {
        let differences = q.windows(5).map(|x| fourth(x, 1));
        let squares: f64 = differences.map(|d| d * d).sum();
        noise += squares / 70.0 / q.len().saturating_sub(4).max(1) as f64;
        power += variance(q);
    }
    if power > 0.0 { noise / power } else { 0.0 }
}

/// How the motion of a recording repeats; None if it does not, or not twice.
pub fn find(recording: &Recording, timing: &Timing) -> Option<Repetition> {
    let (positions, rate_hz) = thinned(recording, timing);
    let found = of_positions(&positions, rate_hz)?;
    let exact = found.period * timing.rate_hz;
    if exact < LEAST_ROWS as f64 {
        return None;
    }
    let samples = recording.position.first().map_or(0, Vec::len);
    let period = whole(found.period, timing, samples as f64 / timing.rate_hz);
    Some(Repetition { period, ..found })
}

/// The period of a recording that is averaged over, and what a reader should know of it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ChosenPeriod {
    /// s; None where the motion does not repeat.
    pub period: Option<(f64, Chosen)>,
    /// What to know of a period that was found, or that differs from the one that was given.
    pub remark: Option<String>,
}

/// A period that is stated is right as long as another one near it does not repeat so many times better: the power that
/// changes between periods that are out of step grows with the square of the shift.
const BETTER: f64 = 3.0;

/// How far from a stated period a better one is looked for, as a share of it.
const NEAR: f64 = 0.02;

/// Holds a stated period against the motion, and finds one where none is stated. Stated periods that are not those of the
/// motion are mended, or dropped where the motion does not repeat.
pub fn settle(recording: &Recording, timing: &Timing, stated: Option<f64>) -> ChosenPeriod {
    let found = || find(recording, timing).filter(Repetition::is_exact);
    let Some(stated) = stated else {
        return ChosenPeriod {
            period: found().map(|f| (f.period, Chosen::Data)),
            remark: None,
        };
    };
    let as_stated = ChosenPeriod {
        period: Some((stated, Chosen::Given)),
        remark: None,
    };
    let (positions, rate_hz) = thinned(recording, timing);
    let Some(changed) = changed_after(&positions, stated * rate_hz) else {
        return as_stated;
    };
    let file = recording.file.display();
    let is_right = repeats(changed, noise_share(&positions));
    let better = match is_right {
        true => nearby(&positions, rate_hz, timing, stated)
            .filter(|near| BETTER * near.changed.max(ROUNDING) < changed),
        false => found(),
    };
    match better {
        Some(better) => ChosenPeriod {
            period: Some((better.period, Chosen::Data)),
            remark: Some(format!(
                "The motion of {file} repeats after {:.6} s and not after the {stated} s that are stated: at these it \
                 differs by {} of its power, at those by {}. The former are used.",
                better.period,
                percent(changed),
                percent(better.changed)
            )),
        },
        None if is_right => as_stated,
        None => ChosenPeriod {
            period: None,
            remark: Some(format!(
                "The motion of {file} does not repeat after the {stated} s that are stated: it differs by {} of its \
                 power. Every sample is used for itself and nothing is averaged.",
                percent(changed)
            )),
        },
    }
}

/// A share as it stands in a sentence.
fn percent(share: f64) -> String {
    match 100.0 * share {
        small if small > 0.0 && small < 0.01 => "less than 0.01 %".to_string(),
        percent => format!("{percent:.2} %"),
    }
}

/// The repetition nearest to a stated period.
fn nearby(
    positions: &[Vec<f64>],
    rate_hz: f64,
    timing: &Timing,
    stated: f64,
) -> Option<Repetition> {
    let lag = stated * rate_hz;
    let farthest = ((1.0 + NEAR) * lag).ceil() as usize + 1;
    let d = differences(positions, farthest)?;
    let window = ((1.0 - NEAR) * lag).floor() as usize..=((1.0 + NEAR) * lag).ceil() as usize;
    let inner = |l: &usize| *l > 0 && *l + 1 < d.len();
    let least = window
        .filter(inner)
        .min_by(|a, b| d[*a].total_cmp(&d[*b]))?;
    if d[least] > d[least - 1] || d[least] > d[least + 1] || d[least] >= RETURNED {
        return None;
    }
    let exact = over_many(&d, vertex(&d, least).0);
    let period = whole(exact / rate_hz, timing, positions[0].len() as f64 / rate_hz);
    let changed = changed_after(positions, period * rate_hz)?;
    let noise = noise_share(positions);
    Some(Repetition {
        period,
        changed,
        noise,
    })
}

/// Whether the samples of every period lie where those of the first do, so that they can be averaged as they are.
pub fn is_whole(recording: &Recording, timing: &Timing, period: f64) -> bool {
    let exact = timing.rate_hz * period;
    let periods = recording
        .position
        .first()
        .map_or(0.0, |q| q.len() as f64 / exact);
    timing.uniform && (exact - exact.round()).abs() * periods <= ALIGNED_STEPS
}

/// A period as a whole number of samples, where the recorded ones drift by next to nothing against it.
fn whole(period: f64, timing: &Timing, duration: f64) -> f64 {
    let exact = period * timing.rate_hz;
    let drift = (exact.round() - exact).abs() * duration / period;
    match timing.uniform && drift <= WHOLE_STEPS {
        true => exact.round() / timing.rate_hz,
        false => period,
    }
}

/// A series beside itself a lag later, where the lag may end between samples.
pub(super) struct Lagged<'a> {
    series: &'a [f64],
    whole: usize,
    part: f64,
    count: usize,
}

impl<'a> Lagged<'a> {
    /// None where fewer samples than a tenth of the lag lie behind it: they say nothing.
    pub fn new(series: &'a [f64], lag: f64) -> Option<Self> {
        let whole = lag.floor() as usize;
        let count = series
            .len()
            .checked_sub(whole + 2)
            .filter(|n| *n as f64 > 0.1 * lag)?;
        Some(Self {
            series,
            whole,
            part: lag.fract(),
            count,
        })
    }

    /// k and q(k) − q(k + lag).
    pub fn changes(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        (1..self.count).map(|k| {
            let later = between(&self.series[k + self.whole - 1..], self.part);
            (k, self.series[k] - later)
        })
    }
}

/// Mean square about the mean.
pub(super) fn variance(series: &[f64]) -> f64 {
    let count = series.len() as f64;
    let mean = series.iter().sum::<f64>() / count;
    series.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count
}

/// Share of the power of a motion that changes after a lag between samples, `Σ (q(k) − q(k + l))² / 2 Var q` over all
/// joints; None where hardly anything lies behind it.
pub fn changed_after(positions: &[Vec<f64>], lag: f64) -> Option<f64> {
    let (mut change, mut power) = (0.0, 0.0);
    for q in positions {
        let lagged = Lagged::new(q, lag)?;
        power += variance(q);
        let squares = lagged.changes().map(|(_, change)| change * change);
        change += squares.sum::<f64>() / lagged.count as f64;
    }
    (power > 0.0).then(|| change / (2.0 * power))
}

/// The cubic through four samples, between the second and the third: its error is of the order of the noise of motions
/// that are sampled finely enough for anything else.
fn between(x: &[f64], part: f64) -> f64 {
    if part == 0.0 {
        return x[1];
    }
    let (a, b, c, d) = (x[0], x[1], x[2], x[3]);
    let slope = 0.5 * (c - a);
    let curve = a - 2.5 * b + 2.0 * c - 0.5 * d;
    let bend = 0.5 * (d - a) + 1.5 * (b - c);
    b + part * (slope + part * (curve + part * bend))
}

/// Positions of a recording on an even grid of at most so many samples, with their rate in Hz.
pub fn thinned(recording: &Recording, timing: &Timing) -> (Vec<Vec<f64>>, f64) {
    let even = match (&recording.time, timing.uniform) {
        (Some(time), false) => {
            let grid = Grid::spanning(time, timing.rate_hz);
            even_motion(recording, time, grid).position
        }
        _ => recording.position.clone(),
    };
    let stride = even
        .first()
        .map_or(1, |q| q.len().div_ceil(MOST_SAMPLES))
        .max(1);
    let thin = |q: &Vec<f64>| q.iter().step_by(stride).copied().collect();
    (
        even.iter().map(thin).collect(),
        timing.rate_hz / stride as f64,
    )
}

/// How the positions `[j][k]` repeat; None if nothing repeats twice.
pub fn of_positions(positions: &[Vec<f64>], rate_hz: f64) -> Option<Repetition> {
    let d = differences(positions, 0)?;
    let left = d.iter().position(|value| *value > LEFT)?;
    let inner = left.max(1)..d.len().saturating_sub(1);
    let minima: Vec<(f64, f64, f64)> = inner
        .filter(|&l| d[l] < RETURNED && d[l] <= d[l - 1] && d[l] <= d[l + 1])
        .map(|l| vertex(&d, l))
        .collect();
    // The curvature bounds what the parabola misses between lags, as noise bounds the depth.
    let best = minima.iter().map(|m| m.1 + VERTEX_ERROR * m.2);
    let best = best.fold(f64::INFINITY, f64::min);
    let (lag, value, curvature) = *minima.iter().find(|m| m.1 <= AS_GOOD * best)?;
    Some(Repetition {
        period: over_many(&d, lag) / rate_hz,
        changed: (value - VERTEX_ERROR * curvature).max(0.0),
        noise: noise_share(positions),
    })
}

/// The lag of one period from that of as many as there are: what the vertex misses is divided by them.
fn over_many(d: &[f64], lag: f64) -> f64 {
    let (mut lag, mut count) = (lag, 1.0);
    loop {
        // Twice as far, what is missed so far is still within a step.
        let near = (2.0 * count * lag).round() as usize;
        let window = near.saturating_sub(1)..=near + 1;
        if *window.end() + 1 >= d.len() {
            return lag;
        }
        let Some(at) = window.min_by(|a, b| d[*a].total_cmp(&d[*b])) else {
            return lag;
        };
        if d[at] > d[at - 1] || d[at] > d[at + 1] || d[at] >= RETURNED {
            return lag;
        }
        count *= 2.0;
        lag = vertex(d, at).0 / count;
    }
}

/// A parabola through three lags is right at its vertex to this fraction of its curvature.
const VERTEX_ERROR: f64 = 1e-3;

/// Lag, value and curvature at the vertex of the parabola about a minimum.
fn vertex(d: &[f64], l: usize) -> (f64, f64, f64) {
    let curvature = (d[l - 1] - 2.0 * d[l] + d[l + 1]).max(ROUNDING);
    let slope = 0.5 * (d[l + 1] - d[l - 1]);
    let lag = l as f64 - slope / curvature;
    (lag, d[l] - 0.5 * slope * slope / curvature, curvature)
}

/// d below this is rounding of the transform, relative to the variance.
const ROUNDING: f64 = 1e-12;

/// d(l) for lags up to the one after half the length, or up to a farther one behind which there is anything; None if
/// nothing moves.
fn differences(positions: &[Vec<f64>], farthest: usize) -> Option<Vec<f64>> {
    let n = positions.first()?.len();
    let lags = farthest.max(n / 2 + 1).min(n.saturating_sub(2));
    let mut sum = vec![0.0; lags + 1];
    let mut variance = 0.0;
    for recorded in positions {
        let mean = recorded.iter().sum::<f64>() / n as f64;
        let series: Vec<f64> = recorded.iter().map(|q| q - mean).collect();
        variance += series.iter().map(|q| q * q).sum::<f64>() / n as f64;
        add_differences(&series, &mut sum);
    }
    let moves = variance > 0.0;
    sum.iter_mut().for_each(|d| *d /= 2.0 * variance);
    moves.then_some(sum)
}

/// Adds Σ_k (x(k) - x(k + l))² / (n - l) = (E(0, n-l) + E(l, n) - 2 R(l)) / (n - l) for each lag l.
fn add_differences(series: &[f64], sum: &mut [f64]) {
    let n = series.len();
    let products = lagged_products(series, sum.len().saturating_sub(1));
    let total: f64 = series.iter().map(|x| x * x).sum();
    let (mut head, mut tail) = (total, total);
    for (l, d) in sum.iter_mut().enumerate() {
        let squares = head + tail - 2.0 * products[l];
        *d += squares.max(0.0) / (n - l) as f64;
        head -= series[n - 1 - l].powi(2);
        tail -= series[l].powi(2);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use std::f64::consts::TAU;

    fn motion(period: f64, harmonics: &[usize]) -> Vec<f64> {
        let of = |k: usize, h: usize| (TAU * h as f64 * k as f64 / period + h as f64).sin();
        (0..5000)
            .map(|k| harmonics.iter().map(|&h| of(k, h) / h as f64).sum())
            .collect()
    }

    #[test]
    fn shares_in_sentences_are_percentages() {
        let words = [0.0, 0.284, 1e-6].map(percent);
        assert_eq!(words, ["0.00 %", "28.40 %", "less than 0.01 %"]);
    }

    #[test]
    fn recovers_known_period_between_samples() {
        // Two joints that repeat after a half and a third of the common period.
        let positions = [motion(1200.4, &[2, 4, 6]), motion(1200.4, &[3, 6])];
        let found = of_positions(&positions, 100.0).unwrap();
        // A parabola through the lowest three lags of a smooth minimum: within a hundredth of a step, over
        // the two periods that a lag of half the recording spans.
        assert!((found.period - 12.004).abs() < 0.5e-4, "{found:?}");
        assert!(found.is_exact(), "{found:?}");
    }

    #[test]
    fn recovers_known_period_of_two_periods_and_no_more() {
        let found = of_positions(&[motion(2500.0, &[1, 2, 3])], 100.0).unwrap();
        assert!((found.period - 25.0).abs() < 0.5e-4, "{found:?}");
    }

    #[test]
    fn finds_none_where_nothing_repeats() {
        let sweep: Vec<f64> = (0..5000).map(|k| ((k * k) as f64 * 1e-5).sin()).collect();
        assert_eq!(of_positions(&[sweep], 100.0), None);
        assert_eq!(of_positions(&[vec![1.0; 100]], 100.0), None);
        assert_eq!(of_positions(&[], 100.0), None);
    }

    #[test]
    fn recovers_known_share_that_changes_between_periods() {
        // Amplitudes 1, 1 + e, 1: the mean of (e sin)² over 2 Var q.
        let e = 0.05;
        let grown: Vec<f64> = (0..3000)
            .map(|k| {
                let size = if k / 1000 == 1 { 1.0 + e } else { 1.0 };
                size * (TAU * k as f64 / 1000.0).sin()
            })
            .collect();
        let found = of_positions(&[grown], 100.0).unwrap();
        let expected = 0.5 * e * e / ((2.0 + (1.0 + e) * (1.0 + e)) / 3.0);
        assert!((found.changed / expected - 1.0).abs() < 0.05, "{found:?}");
        assert!(!found.is_exact());
    }

    /// A cubic of this kind follows parabolas.
    #[test]
    fn matches_parabolas_between_samples() {
        let parabola = |t: f64| 2.0 - 3.0 * t + 0.7 * t * t;
        let x = [-1.0, 0.0, 1.0, 2.0].map(parabola);
        for part in [0.0, 0.3, 0.9] {
            assert!((between(&x, part) - parabola(part)).abs() < 1e-12);
        }
    }

    /// White noise is all noise, half of it half of the power, and a smooth motion none.
    #[test]
    fn noise_is_a_share_of_the_power() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(2);
        let noise: Vec<f64> = (0..5000).map(|_| StandardNormal.sample(&mut rng)).collect();
        let smooth = motion(1000.0, &[1, 2]);
        assert!((noise_share(std::slice::from_ref(&noise)) - 1.0).abs() < 0.1);
        assert!(noise_share(std::slice::from_ref(&smooth)) < 1e-6);
        let power = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
        let factor = (power(&smooth) / power(&noise)).sqrt();
        let pairs = smooth.iter().zip(&noise);
        let both = pairs.map(|(s, n)| s + factor * n).collect::<Vec<f64>>();
        assert!((noise_share(&[both]) - 0.5).abs() < 0.05);
    }
}
