//! Detection of upsampled channels: rows that repeat a sample (zero-order hold) or lie on a line between two (first-order hold).
//!
//! At less than two rows for each sample only some samples are repeated: rows in which all channels at once are those of the row
//! before, spaced as evenly as two clocks allow. At a number of rows that is not whole, rows on a line come at even phases of
//! the samples: of r rows for each sample, those that do not lie beside one make up the share 1 − 2/r.
//!
//! Of a series that is repeated, `Δx = x(k) − x(k − 1)` is zero but where a sample is new; of one that is interpolated,
//! `Δ²x = x(k + 1) − 2x(k) + x(k − 1)` is zero but at the samples. Where the rows that are not zero lie at every r-th place,
//! the others tell nothing that these do not: r-fold data would make intervals too narrow by √r and more, as noise that is
//! held looks like motion. Of n rows that change by chance the share r^(1−n) would lie so.

use std::collections::HashSet;

use realfft::num_complex::Complex;

use crate::fault::Place;
use crate::recording::channels::samples::{Manner, Recording, Upsampled};
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::series::differences::steps;
use crate::recording::series::spectrum::coefficients;
use crate::recording::time_base::timing::GAP_STEPS;
use crate::stats::robust::{median, quantile};

/// Most rows of one sample: 10 Hz written at 1 kHz.
const MOST_ROWS: usize = 100;

/// Fewest changes that show a pattern: with two rows for each sample the chance is 2^-49.
const LEAST_CHANGES: usize = 50;

/// Share of the changes that may be elsewhere: a logger and its source that slip against one another.
const ELSEWHERE: f64 = 0.01;

/// Share of the spacings of two clocks that are the whole numbers on both sides of their ratio; others span a sample that is
/// like the one before it.
const USUAL: f64 = 0.8;

/// Share of changes by more than the least one: the counts of a slow encoder also come regularly, but one by one.
const MANY_COUNTS: f64 = 0.1;

/// Bend of most rows between samples over the median bend at samples: lines that were rounded when written bend little. Of
/// fifty noisy bends, or fifty that a coarse step makes zero, those at one place are not ten times those at all others.
const STRAIGHT: f64 = 0.1;
const MOST: f64 = 0.9;

/// Bends below this share of a series are the rounding of double precision.
const ROUNDING: f64 = 1e-12;

/// Bend of rows on a line that was rounded when written, over that of nine rows in ten.
const FEW_BEND: f64 = 0.01;

/// Share of rows on a line below which it is not told how many rows there are for each sample: less than 2.1.
const LEAST_STRAIGHT: f64 = 0.05;

/// Share of the rows on a line that may lie beside samples: where the samples themselves lie on a line.
const STRAY: f64 = 0.05;

/// Share by which the number of rows for each sample may exceed what the share of rows on a line says.
const NEAR: f64 = 0.05;

/// Steps of a turn to which phases are told.
const STEPS: f64 = 16.0;

/// Rows in which interpolation is looked for; the pattern is held against the rest.
const SEARCHED: usize = 5_000;

/// Samples on either side by whose rows the clock of the samples is told.
const BESIDE: usize = 10;

/// Share of the samples of one channel that have to be those of every other.
const TOGETHER: f64 = 0.9;

/// The rows in which one channel has a sample of its own.
#[derive(Clone)]
struct Pattern {
    manner: Manner,
    /// Of one sample, on average.
    factor: f64,
    rows: Vec<usize>,
}

impl Pattern {
    fn every(manner: Manner, every: usize, phase: usize, length: usize) -> Self {
        Self {
            manner,
            factor: every as f64,
            rows: (phase..length).step_by(every).collect(),
        }
    }

    /// Whether the samples of this channel are samples of the other too.
    fn is_within(&self, other: &Pattern) -> bool {
        let rows: HashSet<usize> = other.rows.iter().copied().collect();
        let first = other.rows.first().copied().unwrap_or(0);
        let own = self.rows.iter().filter(|row| **row >= first);
        let together = own.clone().filter(|row| rows.contains(row)).count();
        together as f64 >= TOGETHER * own.count() as f64
    }
}

/// Keeps the samples of a recording whose file repeats or interpolates them; `rate` in Hz is that of its rows.
///
/// Errors: channels whose samples were taken at different instants.
pub fn thinned(mut recording: Recording, rate: Option<f64>) -> Result<Recording, RecordingError> {
    let joints = recording.position.len();
    let series = recording.position.iter().chain(&recording.signal);
    let steady = recording.time.as_deref().is_none_or(is_steady);
    let mut patterns: Vec<Option<Pattern>> = series.map(|series| pattern(series, steady)).collect();
    if patterns.iter().all(Option::is_none) {
        patterns = sometimes_repeated(&recording);
    }
    let found = || patterns.iter().flatten();
    let Some(slowest) = found().max_by(|a, b| a.factor.total_cmp(&b.factor)) else {
        return Ok(recording);
    };
    if let Some(other) = found().find(|other| !slowest.is_within(other)) {
        let kind = RecordingErrorKind::HeldApart {
            factors: [slowest.factor, other.factor],
        };
        return Err(RecordingError::new(Place::file(&recording.file), kind));
    }
    let [position, signal] = [&patterns[..joints], &patterns[joints..]]
        .map(|patterns| patterns.iter().any(Option::is_some));
    let held = Upsampled {
        manner: slowest.manner,
        factor: slowest.factor,
        rows: slowest.rows.clone(),
        channels: match (position, signal) {
            (true, true) => "positions and signals",
            (true, false) => "positions",
            (false, _) => "signals",
        },
    };
    if let (None, Some(rate)) = (&recording.time, rate) {
        let length = recording.position.first().map_or(0, Vec::len);
        recording.time = Some((0..length).map(|k| k as f64 / rate).collect());
    }
    let even = match (&recording.time, held.channels) {
        (Some(time), "positions and signals") => Some(clock_of_samples(time, &held.rows)),
        _ => None,
    };
    recording.keep(&held.rows);
    recording.time = even.or(recording.time);
    recording.held = Some(held);
    Ok(recording)
}

/// Times of samples that all channels have at some rows, s: on an even clock, for by the clock of the rows a sample comes up to a
/// row late.
fn clock_of_samples(time: &[f64], rows: &[usize]) -> Vec<f64> {
    let last = rows.len().saturating_sub(1);
    let at = |k: usize| {
        let beside = BESIDE.min(k).min(last - k);
        let near = &rows[k - beside..=k + beside];
        let row = near.iter().sum::<usize>() as f64 / near.len() as f64;
        let before = (row as usize).min(time.len().saturating_sub(2));
        time[before] + (row - before as f64) * (time[before + 1] - time[before])
    };
    (0..rows.len()).map(at).collect()
}

/// Whether few rows are missing: where they are, a motion bends as samples do with lines between them.
fn is_steady(time: &[f64]) -> bool {
    let steps = steps(time);
    let usual = median(&steps).unwrap_or(0.0);
    let gaps = steps.iter().filter(|step| **step > GAP_STEPS * usual);
    gaps.count() as f64 <= ELSEWHERE * steps.len() as f64
}

/// Where the samples of a channel are, of rows that come steadily or not; `None` where every row is one, or nothing tells.
fn pattern(series: &[f64], steady: bool) -> Option<Pattern> {
    let on_lines = || interpolated(series).or_else(|| on_lines(series));
    repeated(series).or_else(|| steady.then(on_lines).flatten())
}

fn repeated(series: &[f64]) -> Option<Pattern> {
    let length = series.len();
    let changed: Vec<usize> = (1..length)
        .filter(|&k| series[k] != series[k - 1])
        .collect();
    let count = changed.len();
    if count < LEAST_CHANGES || count > length / 2 + 1 || one_by_one(series, &changed) {
        return None;
    }
    let at_every = |&every: &usize| {
        let mut phases = vec![0; every];
        changed.iter().for_each(|k| phases[k % every] += 1);
        let most = (0..every).max_by_key(|p| phases[*p])?;
        (phases[most] as f64 >= (1.0 - ELSEWHERE) * count as f64).then_some((every, most))
    };
    if let Some((every, phase)) = (2..=MOST_ROWS).rev().find_map(|every| at_every(&every)) {
        return Some(Pattern::every(Manner::Repeated, every, phase, length));
    }
    by_two_clocks(&changed, length)
}

/// Channels in which some samples are repeated, one pattern for all of them: positions and signals, or signals alone.
fn sometimes_repeated(recording: &Recording) -> Vec<Option<Pattern>> {
    let joints = recording.position.len();
    let series: Vec<&Vec<f64>> = recording.position.iter().chain(&recording.signal).collect();
    let groups = [0, joints].into_iter();
    let found = groups.filter_map(|first| Some((first, repeated_rows(&series[first..])?)));
    let found = found.take(1).collect::<Vec<_>>().pop();
    let of = |k: usize| {
        let (first, pattern) = found.as_ref()?;
        (k >= *first).then(|| pattern.clone())
    };
    (0..series.len()).map(of).collect()
}

/// The pattern of rows that are those before them in all of some channels, one for several samples.
fn repeated_rows(series: &[&Vec<f64>]) -> Option<Pattern> {
    let length = series.first()?.len();
    let is_repeated = |k: usize| k > 0 && series.iter().all(|s| s[k] == s[k - 1]);
    let (repeated, rows): (Vec<usize>, Vec<usize>) = (0..length).partition(|k| is_repeated(*k));
    let mut spacings: Vec<usize> = repeated.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if spacings.len() < LEAST_CHANGES {
        return None;
    }
    spacings.sort_unstable();
    let middle = spacings[spacings.len() / 2];
    let near = |least: usize| {
        let usual = spacings.iter().filter(|s| (least..=least + 1).contains(*s));
        usual.count()
    };
    let least = (middle.saturating_sub(1)..=middle).max_by_key(|least| near(*least))?;
    let is_even = near(least) as f64 >= USUAL * spacings.len() as f64;
    (is_even && least >= 2).then(|| Pattern {
        manner: Manner::Repeated,
        factor: length as f64 / rows.len() as f64,
        rows,
    })
}

/// Whether a series changes by one least step at a time.
fn one_by_one(series: &[f64], changed: &[usize]) -> bool {
    let steps = || changed.iter().map(|&k| (series[k] - series[k - 1]).abs());
    let least = steps().fold(f64::INFINITY, f64::min);
    let more = steps().filter(|step| *step > 1.5 * least).count();
    (more as f64) < MANY_COUNTS * changed.len() as f64
}

/// Samples that are repeated a number of times that is not whole, or that slips.
fn by_two_clocks(changed: &[usize], length: usize) -> Option<Pattern> {
    let mut spacings: Vec<usize> = changed.windows(2).map(|pair| pair[1] - pair[0]).collect();
    spacings.sort_unstable();
    let least = *spacings.get((ELSEWHERE * spacings.len() as f64) as usize)?;
    let usual: Vec<usize> = (spacings.iter().copied())
        .filter(|s| (least..=least + 1).contains(s))
        .collect();
    if least < 2 || (usual.len() as f64) < USUAL * spacings.len() as f64 {
        return None;
    }
    let factor = usual.iter().sum::<usize>() as f64 / usual.len() as f64;
    let mut rows = Vec::new();
    for (&from, to) in changed.iter().zip(changed.iter().skip(1).chain([&length])) {
        // Samples that are like the one before them change nothing.
        let samples = ((to - from) as f64 / factor).round().max(1.0) as usize;
        rows.extend((0..samples).map(|k| from + (k as f64 * factor).round() as usize));
    }
    Some(Pattern {
        manner: Manner::Repeated,
        factor,
        rows,
    })
}

fn interpolated(series: &[f64]) -> Option<Pattern> {
    let length = series.len();
    let bend = |k: usize| (series[k + 1] - 2.0 * series[k] + series[k - 1]).abs();
    let begin = (length.saturating_sub(SEARCHED) / 2).max(1);
    let end = (begin + SEARCHED).min(length.saturating_sub(1));
    let rows_from = |first: usize, (from, to): (usize, usize), every: usize| {
        let offset = (first + every - from % every) % every;
        (from + offset..to).step_by(every)
    };
    let size = series.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let largest = |range: (usize, usize), every: usize| {
        let bends = |phase: usize| rows_from(phase, range, every).map(bend).collect();
        let mut bends: Vec<Vec<f64>> = (0..every).map(bends).collect();
        let middle: Vec<f64> = bends.iter_mut().map(|b| quantile(b, 0.5)).collect();
        let phase = (0..every).max_by(|a, b| middle[*a].total_cmp(&middle[*b]))?;
        let sample = middle[phase];
        let is_straight = |p: usize, bends: &mut [f64]| {
            p == phase
                || middle[p] <= STRAIGHT * sample && quantile(bends, MOST) <= STRAIGHT * sample
        };
        let mut others = bends.iter_mut().enumerate();
        let found = sample > ROUNDING * size && others.all(|(p, b)| is_straight(p, b));
        found.then_some((every, phase))
    };
    // Of two rows for each sample nearly every second is straight, of more rows more.
    let mut all: Vec<f64> = (begin..end).map(bend).collect();
    if all.is_empty() || quantile(&mut all, 0.4) > STRAIGHT * quantile(&mut all, MOST) {
        return None;
    }
    let most = (end.saturating_sub(begin) / LEAST_CHANGES).min(MOST_ROWS);
    let (every, phase) = (2..=most)
        .rev()
        .find_map(|every| largest((begin, end), every))?;
    let whole = largest((1, length - 1), every)?;
    (whole == (every, phase)).then(|| Pattern::every(Manner::Interpolated, every, phase, length))
}

/// Samples with straight lines between them, at a number of rows that is not whole: the rows nearest to the samples.
fn on_lines(series: &[f64]) -> Option<Pattern> {
    let bends: Vec<f64> = series
        .windows(3)
        .map(|x| (x[2] - 2.0 * x[1] + x[0]).abs())
        .collect();
    let usual = match bends.len() < LEAST_CHANGES {
        true => return None,
        false => quantile(&mut bends.clone(), MOST),
    };
    let size = series.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let is_straight = |bend: &f64| *bend <= (FEW_BEND * usual).max(ROUNDING * size);
    let straight: Vec<usize> = (1..)
        .zip(&bends)
        .filter(|(_, b)| is_straight(b))
        .map(|(k, _)| k)
        .collect();
    let share = straight.len() as f64 / bends.len() as f64;
    let changed: Vec<usize> = (1..series.len())
        .filter(|&k| series[k] != series[k - 1])
        .collect();
    if share < LEAST_STRAIGHT || usual <= ROUNDING * size || one_by_one(series, &changed) {
        return None;
    }
    // Samples that fall on rows make more of them straight, never fewer.
    let most = (1.0 + NEAR) * 2.0 / (1.0 - share);
    let factor = spacing(&straight, most, series.len())?;
    let turn = |k: usize| k as f64 / factor;
    let resultant = resultant(straight.iter().map(|&k| turn(k)));
    // Straight rows lie about the middle between two samples, and none beside a sample.
    let middle = resultant.arg() / std::f64::consts::TAU;
    let half = 0.5 * (1.0 - 2.0 / factor) + 1.0 / STEPS;
    let apart = |k: usize| {
        let away = turn(k) - middle;
        (away - away.round()).abs()
    };
    let elsewhere = straight.iter().filter(|k| apart(**k) > half).count();
    let bent = (1..=bends.len()).filter(|k| apart(*k) < half - 2.0 / STEPS);
    let bent = bent.filter(|&k| !is_straight(&bends[k - 1])).count();
    let few = STRAY * straight.len() as f64;
    if elsewhere as f64 > few || bent as f64 > few {
        return None;
    }
    let first = (middle + 0.5).rem_euclid(1.0) * factor;
    let samples = ((series.len() as f64 - 1.0 - first) / factor) as usize;
    let row = |n: usize| (first + n as f64 * factor).round() as usize;
    Some(Pattern {
        manner: Manner::Interpolated,
        factor,
        rows: (0..=samples).map(row).collect(),
    })
}

/// Mean of the directions that turns point to.
fn resultant(turns: impl ExactSizeIterator<Item = f64>) -> Complex<f64> {
    let count = turns.len() as f64;
    let directions = turns.map(|turn| Complex::from_polar(1.0, std::f64::consts::TAU * turn));
    directions.sum::<Complex<f64>>() / count
}

/// The spacing up to a given one at whose phases some of so many rows come most evenly.
fn spacing(rows: &[usize], most: f64, length: usize) -> Option<f64> {
    let share = rows.len() as f64 / length as f64;
    let padded = STEPS as usize * length;
    let mut marks = vec![-share; length];
    rows.iter().for_each(|&k| marks[k] += 1.0);
    marks.resize(padded, 0.0);
    let spectrum = coefficients(&marks);
    let first = (padded as f64 / most) as usize;
    let strengths = spectrum.iter().enumerate().skip(first);
    let strongest = strengths.max_by(|a, b| a.1.norm_sqr().total_cmp(&b.1.norm_sqr()))?;
    Some(padded as f64 / strongest.0 as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    const RATE: f64 = 100.0;

    /// A motion in counts of an encoder and its signal with noise.
    fn taken(counts: f64) -> Recording {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let mut noise = || -> f64 { StandardNormal.sample(&mut random) };
        let angle = |k: usize| (0.02 * k as f64).sin() + 0.3 * (0.033 * k as f64).sin();
        let position = (0..2000).map(|k| (angle(k) * counts).round() / counts);
        let signal = (0..2000).map(|k| angle(k) + 0.05 * noise());
        Recording {
            time: Some((0..2000).map(|k| k as f64 / RATE).collect()),
            ..Recording::of_samples("made.csv", vec![position.collect()], vec![signal.collect()])
        }
    }

    /// Row m of the file is at sample m / factor.
    fn written(of: &Recording, factor: f64, at: impl Fn(&[f64], f64) -> f64) -> Recording {
        let rows = (1999.0 * factor) as usize;
        let write = |series: &Vec<f64>| (0..rows).map(|m| at(series, m as f64 / factor)).collect();
        Recording {
            time: Some((0..rows).map(|m| m as f64 / factor / RATE).collect()),
            position: of.position.iter().map(write).collect(),
            signal: of.signal.iter().map(write).collect(),
            ..of.clone()
        }
    }

    fn repeat(series: &[f64], at: f64) -> f64 {
        series[(at + 1e-9).floor() as usize]
    }

    fn line(series: &[f64], at: f64) -> f64 {
        let k = (at + 1e-9).floor() as usize;
        let value = series[k] + (at - k as f64) * (series[(k + 1).min(1999)] - series[k]);
        (value * 1e6).round() / 1e6
    }

    #[test]
    fn recovers_the_samples_that_were_repeated() {
        let taken = taken(65536.0);
        for factor in [2.0, 5.0, 10.0] {
            let found = thinned(written(&taken, factor, repeat), None).unwrap();
            assert_eq!(found.held.as_ref().unwrap().factor, factor);
            let count = found.signal[0].len();
            assert!(count >= 1998);
            let skipped = (found.time.as_ref().unwrap()[0] * RATE).round() as usize;
            assert_eq!(found.signal[0], taken.signal[0][skipped..][..count]);
            assert_eq!(found.position[0], taken.position[0][skipped..][..count]);
        }
    }

    #[test]
    fn recovers_samples_by_a_clock_that_is_no_multiple() {
        let taken = taken(65536.0);
        let found = thinned(written(&taken, 2.5, repeat), None).unwrap();
        assert!((found.held.unwrap().factor - 2.5).abs() < 0.01);
        assert!(found.signal[0].len() >= 1997);
        assert!(found.signal[0].iter().all(|x| taken.signal[0].contains(x)));
    }

    #[test]
    fn recovers_the_samples_between_straight_lines() {
        let taken = taken(65536.0);
        for factor in [2.0, 5.0, 10.0] {
            let found = thinned(written(&taken, factor, line), None).unwrap();
            assert_eq!(found.held.unwrap().manner, Manner::Interpolated);
            let pairs = found.signal[0].iter().zip(&taken.signal[0]);
            assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() <= 1e-6));
        }
    }

    #[test]
    fn held_signals_beside_free_positions_are_thinned_together() {
        let taken = taken(65536.0);
        let signal = written(&taken, 5.0, repeat).signal;
        let free = Recording {
            signal,
            ..written(&taken, 5.0, line)
        };
        let smooth = (0..free.position[0].len()).map(|m| (0.004 * m as f64).sin());
        let free = Recording {
            position: vec![smooth.collect()],
            ..free
        };
        let found = thinned(free, None).unwrap();
        assert_eq!(found.held.unwrap().channels, "signals");
    }

    #[test]
    fn recovers_samples_of_which_only_some_are_repeated() {
        for counts in [8192.0, 65536.0] {
            let taken = taken(counts);
            for factor in [1.1, 1.25, 4.0 / 3.0, 1.5, 1.6, 1.75, 1.9] {
                let found = thinned(written(&taken, factor, repeat), None).unwrap();
                let held = found.held.expect("repeated samples");
                assert!(
                    (held.factor - factor).abs() < 0.01,
                    "{factor}: {}",
                    held.factor
                );
                assert_eq!(held.channels, "positions and signals");
                let time = found.time.as_ref().unwrap();
                let inner = BESIDE..time.len() - BESIDE;
                let step = |k: usize| (time[k + 1] - time[k]) * RATE;
                assert!(
                    inner.clone().all(|k| (step(k) - 1.0).abs() < 0.1),
                    "{factor}"
                );
                assert_eq!(found.signal[0], taken.signal[0][..found.signal[0].len()]);
            }
        }
    }

    #[test]
    fn recovers_samples_on_lines_at_no_whole_number_of_rows() {
        let taken = taken(65536.0);
        for factor in [2.2, 2.5, 10.0 / 3.0, 4.7] {
            let found = thinned(written(&taken, factor, line), None).unwrap();
            let held = found.held.expect("interpolated samples");
            assert_eq!(held.manner, Manner::Interpolated);
            assert!(
                (held.factor - factor).abs() < 0.01,
                "{factor}: {}",
                held.factor
            );
            // The row nearest to a sample is within half a row of it.
            let near = (held.rows.iter()).filter(|row| {
                let at = **row as f64 / factor;
                (at - at.round()).abs() * factor <= 0.75
            });
            assert!(near.count() as f64 > 0.99 * held.rows.len() as f64);
        }
    }

    #[test]
    fn rates_are_told_of_the_samples_themselves() {
        let taken = taken(65536.0);
        let smooth = |m: usize| (0.008 * m as f64).sin();
        let written = Recording {
            position: vec![(0..4997).map(smooth).collect()],
            ..written(&taken, 2.5, repeat)
        };
        let found = thinned(written, None).unwrap();
        let words = found.held_words(83.0).unwrap();
        assert!(
            words.contains("at 100.0") && words.contains("at 250.0"),
            "{words}"
        );
    }

    #[test]
    fn samples_at_different_instants_are_refused() {
        let taken = taken(65536.0);
        let mut apart = written(&taken, 5.0, repeat);
        apart.signal[0].drain(..2);
        let rows = apart.signal[0].len();
        apart.position[0].truncate(rows);
        apart.time.as_mut().unwrap().truncate(rows);
        let error = thinned(apart, None).unwrap_err();
        assert!(matches!(error.kind, RecordingErrorKind::HeldApart { .. }));
    }

    #[test]
    fn counts_of_a_slow_encoder_are_samples() {
        // Less than one count for every row: a tenth of them, and one in five at constant speed.
        for counts in [20.0, 200.0, 2000.0, 65536.0] {
            assert_eq!(thinned(taken(counts), None).unwrap().held, None, "{counts}");
        }
        let steady = Recording {
            position: vec![(0..2000).map(|k| f64::from(k / 5)).collect()],
            ..taken(200.0)
        };
        assert_eq!(thinned(steady, None).unwrap().held, None);
    }

    /// The first sample of its own lies behind rows that were begun before the file.
    #[test]
    fn samples_know_their_lines() {
        let mut file = written(&taken(65536.0), 5.0, repeat);
        let series = file.position.iter_mut().chain(&mut file.signal);
        series.chain(&mut file.time).for_each(|s| {
            s.drain(..2);
        });
        let found = thinned(file.clone(), None).unwrap();
        let rows = &found.held.as_ref().unwrap().rows;
        assert!(rows[0] > 0);
        for sample in [0, 1, 777] {
            assert_eq!(found.line(sample), file.line(rows[sample]));
        }
    }
}
