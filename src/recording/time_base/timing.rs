//! The time base of a recording: whether the stamps increase, at which rate, how evenly; and interpolation of the motion to an
//! even grid where they do not come evenly.

use crate::fault::Place;
use crate::recording::channels::samples::Recording;
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::formats::table::require_rows;
use crate::recording::series::differences::steps;
use crate::recording::series::interpolation::{Bracket, Stencil, brackets};

/// How the samples lie in time.
#[derive(Debug, Clone, PartialEq)]
pub struct Timing {
    /// Hz: (n - 1) / duration of even stamps, else the inverse of the median step.
    pub rate_hz: f64,
    /// Root mean square deviation of the steps from the median step, gaps left out, s.
    pub jitter_rms_s: f64,
    /// Steps longer than 1.5 median steps, where samples are missing: line after the gap, length in s.
    pub gaps: Vec<(usize, f64)>,
    /// The stamps lie on an even grid, but for their own rounding.
    pub uniform: bool,
}

/// A step longer than this many median steps is a gap: one sample missing makes two steps.
pub(in crate::recording) const GAP_STEPS: f64 = 1.5;

/// Stamps within this fraction of a step of an even grid are even: at 5 % of a step the error of a
/// position is what the joint moves in 5 % of a sample, below what interpolation would add.
pub(in crate::recording) const UNIFORM_STEPS: f64 = 0.05;

/// Given and found rate may differ by this fraction; more is a wrong unit or a wrong rate.
const RATE_AGREEMENT: f64 = 0.05;

/// An even grid may have this many times the recorded samples: beyond that most of it would be
/// invented, and one wrong stamp could take all memory.
const MOST_STRETCH: f64 = 2.0;

/// Examines the time base of a recording; `rate` in Hz is needed where there are no stamps.
///
/// Errors: too few samples, no stamps and no rate, stamps that do not increase, that contradict the
/// rate, or that leave out more than they hold.
pub fn examine(recording: &Recording, rate: Option<f64>) -> Result<Timing, RecordingError> {
    let place = || Place::file(&recording.file);
    require_rows(
        &recording.file,
        recording.position.first().map_or(0, Vec::len),
    )?;
    if let Some(value) = rate.filter(|rate| !(rate.is_finite() && *rate > 0.0)) {
        let requirement = "positive and finite, in Hz".into();
        let kind = RecordingErrorKind::InvalidSetting { value, requirement };
        return Err(RecordingError::new(place().key("rate"), kind));
    }
    let Some(time) = &recording.time else {
        let rate_hz =
            rate.ok_or_else(|| RecordingError::new(place(), RecordingErrorKind::NoTimeBase))?;
        return Ok(Timing {
            rate_hz,
            jitter_rms_s: 0.0,
            gaps: Vec::new(),
            uniform: true,
        });
    };
    if let Some(k) = (1..time.len()).find(|&k| time[k] <= time[k - 1]) {
        let kind = RecordingErrorKind::TimeNotIncreasing {
            before: time[k - 1],
            found: time[k],
        };
        let place = place().line(recording.line(k)).key("time");
        return Err(RecordingError::new(place, kind));
    }
    let mut timing = of_stamps(time);
    (timing.gaps.iter_mut()).for_each(|(line, _)| *line = recording.line(*line));
    let expected = (time[time.len() - 1] - time[0]) * timing.rate_hz;
    let longest = timing.gaps.iter().max_by(|a, b| a.1.total_cmp(&b.1));
    if let Some(&(line, seconds)) = longest.filter(|_| expected > MOST_STRETCH * time.len() as f64)
    {
        let kind = RecordingErrorKind::GapTooLong { seconds };
        return Err(RecordingError::new(place().line(line).key("time"), kind));
    }
    // A rate is that of the rows of the file or, where these repeat samples, that of the samples.
    let rates = [recording.rows_per_sample(), 1.0].map(|per_sample| per_sample * timing.rate_hz);
    let is_near = |given: f64| rates.map(|rate| (rate / given - 1.0).abs() <= RATE_AGREEMENT);
    match rate {
        Some(given) if !is_near(given).contains(&true) => {
            let found = rates[0];
            let kind = RecordingErrorKind::RateContradictsTime { given, found };
            Err(RecordingError::new(place().key("rate"), kind))
        }
        _ => Ok(timing),
    }
}

/// The time stamps of a recording that cannot do without.
pub(in crate::recording) fn stamps(recording: &Recording) -> Result<&[f64], RecordingError> {
    let none = || RecordingError::new(Place::file(&recording.file), RecordingErrorKind::NoTimeBase);
    recording.time.as_deref().ok_or_else(none)
}

/// Timing of increasing stamps, s; gaps by the sample after them.
fn of_stamps(time: &[f64]) -> Timing {
    let mut steps = steps(time);
    let gaps_beyond = |median: f64| move |step: &f64| *step > GAP_STEPS * median;
    let median = {
        let mut sorted = steps.clone();
        let middle = sorted.len() / 2;
        *sorted.select_nth_unstable_by(middle, f64::total_cmp).1
    };
    let is_gap = gaps_beyond(median);
    let gaps: Vec<(usize, f64)> = steps
        .iter()
        .enumerate()
        .filter(|(_, step)| is_gap(step))
        .map(|(k, step)| (k + 1, *step))
        .collect();
    let count = steps.len();
    let span = time[count] - time[0];
    let uniform = gaps.is_empty() && is_even(time, span / count as f64);
    steps.retain(|step| !is_gap(step));
    let squares: f64 = steps.iter().map(|step| (step - median).powi(2)).sum();
    Timing {
        rate_hz: if uniform {
            count as f64 / span
        } else {
            1.0 / median
        },
        jitter_rms_s: (squares / steps.len().max(1) as f64).sqrt(),
        gaps,
        uniform,
    }
}

/// Whether all stamps lie on an even grid to 5 % of a step, or to half a unit of their last decimal.
pub(super) fn is_even(time: &[f64], step: f64) -> bool {
    let deviations = || {
        let start = time[0];
        let grid = move |k: usize| start + k as f64 * step;
        time.iter().enumerate().map(move |(k, t)| t - grid(k))
    };
    let (low, high) = deviations().fold((0.0_f64, 0.0_f64), |(low, high), deviation| {
        (low.min(deviation), high.max(deviation))
    });
    // The grid through the first and last stamp may lie half a unit off at either end; the spread
    // is free of that.
    let spread = 0.5 * (high - low);
    spread <= (UNIFORM_STEPS * step).max(0.51 * decimal_unit(time, step))
}

/// Unit of the last decimal of the stamps, s, if it is below the step; else 0.
fn decimal_unit(time: &[f64], step: f64) -> f64 {
    let rounded_to = |decimals: i32| {
        let scale = 10f64.powi(decimals);
        time.iter()
            .all(|t| (t * scale - (t * scale).round()).abs() <= 1e-6 * (1.0 + t.abs()))
    };
    (1..=6)
        .find(|&decimals| rounded_to(decimals))
        .map(|decimals| 10f64.powi(-decimals))
        .filter(|unit| *unit < step)
        .unwrap_or(0.0)
}

/// The stamps from 0 on, taken out of the recording, or made from the rate.
pub(in crate::recording) fn take_stamps(recording: &mut Recording, rate_hz: f64) -> Vec<f64> {
    match recording.time.take() {
        Some(mut time) => {
            let zero = time.first().copied().unwrap_or(0.0);
            time.iter_mut().for_each(|t| *t -= zero);
            time
        }
        None => {
            let length = recording.position.first().map_or(0, Vec::len);
            (0..length).map(|k| k as f64 / rate_hz).collect()
        }
    }
}

/// An even grid: sample m is at `start + m / rate_hz`, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Time of sample 0, s.
    pub start: f64,
    /// Samples per second, Hz.
    pub rate_hz: f64,
    /// How many there are.
    pub samples: usize,
}

impl Grid {
    /// The grid of the given rate that the stamps span.
    pub fn spanning(time: &[f64], rate_hz: f64) -> Self {
        let (start, end) = (time[0], time[time.len() - 1]);
        // A hundredth of a step: the last point may lie beyond the last stamp by rounding.
        let samples = ((end - start) * rate_hz + 0.01).floor() as usize + 1;
        Self {
            start,
            rate_hz,
            samples,
        }
    }

    /// Of all samples, s.
    pub fn times(&self) -> Vec<f64> {
        (0..self.samples).map(|m| self.time(m)).collect()
    }

    /// Of a sample, s.
    pub fn time(&self, sample: usize) -> f64 {
        self.start + sample as f64 / self.rate_hz
    }
}

/// What was recorded of a motion, on an even grid, by cubics through four samples; the signal is left out. The mask takes the
/// nearer sample, and grid points inside a gap are masked.
pub fn even_motion(recording: &Recording, time: &[f64], grid: Grid) -> Recording {
    let stencils: Vec<Stencil> = brackets(time, &grid.times())
        .into_iter()
        .map(|at| Stencil::at(time, at))
        .collect();
    let channels = |channels: &Vec<Vec<f64>>| -> Vec<Vec<f64>> {
        let evenly = |series: &Vec<f64>| stencils.iter().map(|s| s.of(series)).collect();
        channels.iter().map(evenly).collect()
    };
    Recording {
        velocity: recording.velocity.as_ref().map(channels),
        acceleration: recording.acceleration.as_ref().map(channels),
        mask: mask_on(time, grid, recording.mask.as_deref()),
        ..Recording::of_samples(&recording.file, channels(&recording.position), Vec::new())
    }
}

/// Which points of a grid were measured, by the samples of these times and their mask; None: all.
pub(in crate::recording) fn mask_on(
    time: &[f64],
    grid: Grid,
    mask: Option<&[bool]>,
) -> Option<Vec<bool>> {
    let gap = GAP_STEPS / grid.rate_hz;
    let has_gap = time.windows(2).any(|pair| pair[1] - pair[0] > gap);
    if mask.is_none() && !has_gap {
        return None;
    }
    let valid = |&Bracket { before: k, share }: &Bracket| {
        // A point on a sample is measured, whatever is missing beside it.
        let beside = share > 0.01 && share < 0.99;
        let measured = !beside || time[k + 1] - time[k] <= gap;
        let nearest = if share < 0.5 { k } else { k + 1 };
        measured && mask.is_none_or(|mask| mask[nearest])
    };
    Some(brackets(time, &grid.times()).iter().map(valid).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stamps(of: impl Fn(usize) -> f64) -> Vec<f64> {
        (0..1000).map(of).collect()
    }

    #[test]
    fn stamps_rounded_to_milliseconds_are_even_at_their_mean_rate() {
        let time = stamps(|k| (k as f64 / 300.0 * 1e3).round() / 1e3);
        let timing = of_stamps(&time);
        assert!(timing.uniform);
        // Both ends are rounded by at most 0.5 ms of 3.33 s.
        assert!((timing.rate_hz / 300.0 - 1.0).abs() <= 1e-3 / 3.33);
    }

    #[test]
    fn alternating_steps_are_not_even_and_jitter_is_their_spread() {
        let time = stamps(|k| 0.01 * k as f64 + 0.002 * ((k * k / 3) % 2) as f64);
        let timing = of_stamps(&time);
        assert!(!timing.uniform);
        assert!(timing.jitter_rms_s > 0.5e-3 && timing.jitter_rms_s <= 2e-3);
    }

    #[test]
    fn a_missing_sample_is_a_gap_before_the_next() {
        let time = stamps(|k| 0.01 * (k + usize::from(k >= 500)) as f64);
        let timing = of_stamps(&time);
        assert_eq!(timing.gaps.len(), 1);
        assert_eq!(timing.gaps[0].0, 500);
        assert!((timing.gaps[0].1 - 0.02).abs() < 1e-12);
        assert!(!timing.uniform);
    }

    #[test]
    fn motions_are_resampled_as_cubics() {
        let time = stamps(|k| 0.01 * k as f64 + 0.002 * (k as f64).sin());
        let grid = Grid::spanning(&time, 100.0);
        let cubic = |t: f64| 3.0 - 2.0 * t + 0.5 * (t - 4.0).powi(3);
        let position = time.iter().map(|t| cubic(*t)).collect();
        let recorded = Recording::of_samples("made.csv", vec![position], Vec::new());
        let even = even_motion(&recorded, &time, grid);
        for (m, value) in even.position[0].iter().enumerate().skip(1) {
            let exact = cubic((grid.start + m as f64 / 100.0).min(time[999]));
            assert!((value - exact).abs() <= 1e-11, "{m}: {value} {exact}");
        }
    }

    #[test]
    fn points_within_a_gap_were_not_measured() {
        let time = [0.0, 1.0, 2.0, 5.0, 6.0];
        let grid = Grid::spanning(&time, 1.0);
        let measured = [true, true, true, false, false, true, true];
        assert_eq!(mask_on(&time, grid, None), Some(measured.to_vec()));
        let mask = [true, false, true, true, true];
        let measured = [true, false, true, false, false, true, true];
        assert_eq!(mask_on(&time, grid, Some(&mask)), Some(measured.to_vec()));
        assert_eq!(mask_on(&time[..3], Grid { samples: 3, ..grid }, None), None);
    }
}
