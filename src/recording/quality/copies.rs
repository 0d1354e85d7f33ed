//! Duplicate rows of two recordings: copies, pieces of one run, copies shifted in time.
//!
//! Row k of one recording is row k + s of another where every position and every signal is the same to the last digit that
//! both are written with. Two runs of one motion have noise of their own. That five samples in a row are the same by chance
//! has at most the probability p_c that two fourth differences of channel c of one run are the same, and n rows in a row
//!
//! ```text
//! P = Π_c p_c^(n/5)
//! ```
//!
//! A run that rests, or whose signal stands still, has p_c = 1 and is no evidence; coarse steps make p_c large and the run
//! that is needed long. Shifts are found in linear time: windows of rows have keys, by their values and by where their
//! signals rise (which rounding hardly touches), and equal keys vote for a shift.

use std::collections::HashMap;

use crate::recording::channels::samples::Recording;
use crate::recording::quality::resolution::NumberFormat;
use crate::recording::series::differences::fourth;

/// Natural logarithm of the chance P below which rows are those of one run: 1e-9, in some 1e13 pairs of rows of two long
/// recordings.
const SURE: f64 = -50.0;

/// Samples of a fourth difference.
const SPAN: usize = 5;

/// Rows between the fourth differences that are compared: they have no sample in common.
const APART: usize = 7;

/// Bits of a key.
const KEY_BITS: usize = 64;

/// Windows of all recordings together that get a key; where there are more, every 2^m-th by its key.
const MOST_KEYS: usize = 1_000_000;

/// A key that comes more often than this in one recording tells no shift.
const MOST_ALIKE: usize = 4;

/// Shifts of two recordings that are held against their values, those with most votes.
const MOST_SHIFTS: usize = 4;

/// What two recordings have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shared {
    /// Indices of the recordings among those compared.
    pub first: usize,
    /// Index of the other recording, after the first one.
    pub second: usize,
    /// First row of the longest common run in either.
    pub first_row: usize,
    /// The same in the second.
    pub second_row: usize,
    /// Rows of that run.
    pub rows: usize,
    /// Rows in common in all.
    pub total: usize,
}

impl Shared {
    /// The same, with the recordings in the other order.
    pub fn turned(self) -> Self {
        Self {
            first: self.second,
            second: self.first,
            first_row: self.second_row,
            second_row: self.first_row,
            ..self
        }
    }
}

/// All pairs of recordings that have rows in common.
pub fn find(recordings: &[&Recording]) -> Vec<Shared> {
    let compared: Vec<Compared<'_>> = recordings.iter().map(|r| Compared::new(r)).collect();
    let votes = votes(&compared);
    let mut pairs: Vec<(usize, usize)> = votes.keys().map(|(a, b, _)| (*a, *b)).collect();
    pairs.sort_unstable();
    pairs.dedup();
    let mut found = Vec::new();
    for (first, second) in pairs {
        let of_pair = votes
            .iter()
            .filter(|((a, b, _), _)| (*a, *b) == (first, second));
        let mut shifts: Vec<(usize, isize)> =
            of_pair.map(|((_, _, shift), n)| (*n, *shift)).collect();
        shifts.sort_unstable_by(|a, b| b.cmp(a));
        shifts.truncate(MOST_SHIFTS);
        let pair = [&compared[first], &compared[second]];
        let runs: Vec<Run> = shifts.iter().flat_map(|(_, s)| runs(pair, *s)).collect();
        let Some(longest) = runs.iter().max_by_key(|run| run.rows) else {
            continue;
        };
        found.push(Shared {
            first,
            second,
            first_row: longest.row,
            second_row: (longest.row as isize + longest.shift) as usize,
            rows: longest.rows,
            total: runs.iter().map(|run| run.rows).sum(),
        });
    }
    found
}

/// The channels of a recording with the format of their numbers.
struct Compared<'a> {
    channels: Vec<&'a [f64]>,
    written: Vec<NumberFormat>,
    /// The signals begin here among the channels.
    signals: usize,
    rows: usize,
}

impl<'a> Compared<'a> {
    fn new(recording: &'a Recording) -> Self {
        let channels: Vec<&[f64]> = (recording.position.iter())
            .chain(&recording.signal)
            .map(Vec::as_slice)
            .collect();
        Self {
            written: channels.iter().map(|c| NumberFormat::of(c)).collect(),
            signals: recording.position.len(),
            rows: channels.first().map_or(0, |c| c.len()),
            channels,
        }
    }

    fn signal(&self) -> &[&'a [f64]] {
        &self.channels[self.signals..]
    }

    /// Rows of a window of which the rises of all signals make a whole key.
    fn window(&self) -> usize {
        KEY_BITS.div_ceil(self.signal().len().max(1)).max(SPAN)
    }

    /// Keys of the window that ends at every row: by values, and by where signals rise.
    fn keys(&self) -> impl Iterator<Item = (usize, [u64; 2])> + '_ {
        let window = self.window();
        let mut rises = vec![0_u64; self.signal().len()];
        let mask = u64::MAX >> (KEY_BITS - window.min(KEY_BITS));
        let mut values: Vec<u64> = Vec::with_capacity(self.rows);
        (0..self.rows).filter_map(move |k| {
            values.push(self.channels.iter().fold(1, |key, c| {
                // Zero has two signs.
                mixed(key ^ (c[k] + 0.0).to_bits())
            }));
            for (bits, series) in rises.iter_mut().zip(self.signal()) {
                let rise = k > 0 && series[k] > series[k - 1];
                *bits = (*bits << 1 | u64::from(rise)) & mask;
            }
            // The first row of all has no row before it to rise from.
            (k >= window).then(|| {
                let of_values = values[k + 1 - window..].iter();
                let by_value = of_values.fold(2, |key, v| mixed(key ^ v));
                let by_rise = rises.iter().fold(3, |key, bits| mixed(key ^ bits));
                (k, [by_value, by_rise])
            })
        })
    }
}

/// A step of a multiplicative hash (Steele, Lea and Flood 2014, `mix64`).
fn mixed(key: u64) -> u64 {
    let key = key.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let key = (key ^ (key >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let key = (key ^ (key >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    key ^ (key >> 31)
}

/// Windows of two recordings with one key, counted by recordings and shift.
fn votes(compared: &[Compared<'_>]) -> HashMap<(usize, usize, isize), usize> {
    let rows: usize = compared.iter().map(|c| c.rows).sum();
    let every = (rows / MOST_KEYS + 1).next_power_of_two() as u64 - 1;
    let mut keys: Vec<(u64, u32, u32)> = Vec::new();
    for (file, recording) in compared.iter().enumerate() {
        for (row, both) in recording.keys() {
            let taken = both.iter().filter(|key| *key & every == 0);
            keys.extend(taken.map(|key| (*key, file as u32, row as u32)));
        }
    }
    keys.sort_unstable();
    let mut votes = HashMap::new();
    for alike in keys.chunk_by(|a, b| a.0 == b.0) {
        let of_files: Vec<_> = alike
            .chunk_by(|a, b| a.1 == b.1)
            .filter(|rows| rows.len() <= MOST_ALIKE)
            .collect();
        for (at, first) in of_files.iter().enumerate() {
            for second in &of_files[at + 1..] {
                for (a, b) in first
                    .iter()
                    .flat_map(|a| second.iter().map(move |b| (a, b)))
                {
                    let shift = b.2 as isize - a.2 as isize;
                    *votes
                        .entry((a.1 as usize, b.1 as usize, shift))
                        .or_insert(0) += 1;
                }
            }
        }
    }
    votes
}

/// Rows from `row` of the first recording on that are those of the second, `shift` rows later.
struct Run {
    row: usize,
    shift: isize,
    rows: usize,
}

/// Runs of common rows at a shift that no chance explains.
fn runs(pair: [&Compared<'_>; 2], shift: isize) -> Vec<Run> {
    let [a, b] = pair;
    let begin = (-shift).max(0) as usize;
    let end = (b.rows as isize - shift).max(0).min(a.rows as isize) as usize;
    let mut found = Vec::new();
    let mut row = begin;
    while row < end {
        let length = (row..end)
            .take_while(|&k| is_same(pair, [k, (k as isize + shift) as usize]))
            .count();
        if length > 0 && chance(pair, row, shift, length) < SURE {
            found.push(Run {
                row,
                shift,
                rows: length,
            });
        }
        row += length + 1;
    }
    found
}

/// Whether two rows are the same to the last digit that both are written with.
fn is_same(pair: [&Compared<'_>; 2], rows: [usize; 2]) -> bool {
    let [a, b] = pair;
    let mut channels = 0..a.channels.len().min(b.channels.len());
    channels.all(|c| {
        let (x, y) = (a.channels[c][rows[0]], b.channels[c][rows[1]]);
        // Half a unit of either; two numbers in the same format are then one.
        x == y || (x - y).abs() <= 0.6 * a.written[c].unit(x).max(b.written[c].unit(y))
    })
}

/// Natural logarithm of the chance that another run of the same motion has these rows, by the recording whose numbers are
/// written more coarsely.
fn chance(pair: [&Compared<'_>; 2], row: usize, shift: isize, rows: usize) -> f64 {
    let [a, b] = pair;
    let other = (row as isize + shift) as usize;
    let of_channel = |(c, (x, y)): (usize, (&&[f64], &&[f64]))| {
        let (x, y) = (&x[row..row + rows], &y[other..other + rows]);
        let largest = x.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let unit = |of: &Compared<'_>| of.written[of.signals + c].unit(largest);
        let (series, unit) = if unit(a) >= unit(b) {
            (x, unit(a))
        } else {
            (y, unit(b))
        };
        let bends: Vec<f64> = series.windows(SPAN).map(|x| fourth(x, 1)).collect();
        let pairs = bends.len().checked_sub(APART).filter(|n| *n > 0)?;
        // Multiples of the unit, but for the rounding of sums of sixteen numbers.
        let equal = (0.5 * unit).max(16.0 * f64::EPSILON * largest);
        let alike = (0..pairs).filter(|&k| (bends[k] - bends[k + APART]).abs() <= equal);
        let share = alike.count().max(1) as f64 / pairs as f64;
        Some(share.ln() * rows as f64 / SPAN as f64)
    };
    let channels = a.signal().iter().zip(b.signal()).enumerate();
    channels.filter_map(of_channel).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    /// A run of a motion of three joints from a time on, with noise of its own, rounded to steps.
    fn run(seed: u64, rows: usize, step: f64) -> Recording {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let mut noise = || -> f64 { StandardNormal.sample(&mut random) };
        let mut series = |size: f64, deviation: f64, step: f64| -> Vec<Vec<f64>> {
            let one = |j: usize, noise: &mut dyn FnMut() -> f64| {
                let value = |k: usize| size * (0.01 * (j + 1) as f64 * k as f64).sin();
                let rounded = |x: f64| (x / step).round() * step;
                (0..rows)
                    .map(|k| rounded(value(k) + deviation * noise()))
                    .collect()
            };
            (0..3).map(|j| one(j, &mut noise)).collect()
        };
        let position = series(1.0, 0.0, 1e-6);
        Recording::of_samples("made.csv", position, series(3.0, 0.05, step))
    }

    fn piece(of: &Recording, rows: std::ops::Range<usize>) -> Recording {
        let cut = |c: &Vec<Vec<f64>>| c.iter().map(|s| s[rows.clone()].to_vec()).collect();
        Recording {
            position: cut(&of.position),
            signal: cut(&of.signal),
            ..of.clone()
        }
    }

    #[test]
    fn recovers_known_overlap_of_two_pieces_of_one_run() {
        let whole = run(1, 11_000, 1e-9);
        let pieces = [piece(&whole, 0..6000), piece(&whole, 5000..11_000)];
        let found = find(&[&pieces[0], &run(2, 3000, 1e-9), &pieces[1]]);
        let expected = Shared {
            first: 0,
            second: 2,
            first_row: 5000,
            second_row: 0,
            rows: 1000,
            total: 1000,
        };
        assert_eq!(found, [expected]);
    }

    #[test]
    fn fresh_noise_makes_another_run_even_in_coarse_steps() {
        for step in [1e-9, 0.01, 0.05, 0.2] {
            let runs: Vec<Recording> = (0..4).map(|seed| run(seed, 20_000, step)).collect();
            assert_eq!(find(&runs.iter().collect::<Vec<_>>()), [], "{step}");
        }
    }

    #[test]
    fn copies_in_coarse_steps_are_copies() {
        let whole = run(1, 20_000, 0.2);
        let found = find(&[&whole, &piece(&whole, 4000..16_000)]);
        assert_eq!((found[0].first_row, found[0].rows), (4000, 12_000));
    }

    #[test]
    fn a_copy_with_fewer_digits_is_a_copy() {
        let whole = run(1, 5000, 1e-9);
        let read = |x: &f64| format!("{x:.4}").parse::<f64>().unwrap();
        let short = |c: &Vec<Vec<f64>>| c.iter().map(|s| s.iter().map(read).collect()).collect();
        let copy = Recording {
            position: short(&whole.position),
            signal: short(&whole.signal),
            ..whole.clone()
        };
        let found = find(&[&whole, &copy]);
        assert_eq!((found.len(), found[0].total), (1, 5000));
    }

    #[test]
    fn rest_is_no_evidence() {
        // Both stand still for 3000 rows and then move, each with noise of its own.
        let still = |seed| {
            let mut run = run(seed, 5000, 1e-9);
            for series in run.position.iter_mut().chain(&mut run.signal) {
                series[..3000].fill(0.5);
            }
            run
        };
        assert_eq!(find(&[&still(1), &still(2)]), []);
    }

    /// The rows of one series made of another.
    fn with_signals(of: Recording, signal: impl Fn(usize) -> f64) -> Recording {
        let mut made = of;
        let rows = made.position[0].len();
        made.signal = vec![(0..rows).map(signal).collect()];
        made
    }

    /// Where signals go up and down by turns, rises are the same everywhere.
    #[test]
    fn copies_whose_rises_are_all_alike_are_found_by_their_values() {
        let noise = &run(1, 5000, 1e-9).signal[0];
        let turns = |k: usize| if k.is_multiple_of(2) { 10.0 } else { -10.0 };
        let whole = with_signals(run(2, 5000, 1e-9), |k| turns(k) + noise[k]);
        let found = find(&[&whole, &piece(&whole, 1000..4000)]);
        let expected = Shared {
            first: 0,
            second: 1,
            first_row: 1000,
            second_row: 0,
            rows: 3000,
            total: 3000,
        };
        assert_eq!(found, [expected]);
    }

    /// Nothing but signals rises, and a zero of either sign is zero.
    #[test]
    fn a_copy_whose_zeros_have_another_sign_is_a_copy() {
        let noise = &run(1, 5000, 1e-9).signal[0];
        let of = |zero: f64| {
            let turns = [10.0, zero, -10.0, zero];
            with_signals(run(2, 5000, 1e-9), |k| match k % 4 {
                0 | 2 => turns[k % 4] + noise[k],
                _ => zero,
            })
        };
        assert_eq!(find(&[&of(0.0), &of(-0.0)]).len(), 1);
    }

    /// Recordings with more windows than get keys.
    #[test]
    fn copies_among_very_many_rows_are_found() {
        let rows = 2 * MOST_KEYS;
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let noise: Vec<f64> = (0..rows).map(|_| StandardNormal.sample(&mut rng)).collect();
        let whole = Recording::of_samples("made.csv", vec![noise.clone()], vec![noise]);
        let found = find(&[&whole, &piece(&whole, 100..5100)]);
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].first_row, found[0].rows), (100, 5000));
    }
}
