//! A preprocessed recording: the motion with its derivatives, the signal, the noise that
//! the differences between periods show, and the way back to every recorded sample.

use std::path::PathBuf;

use nalgebra::DMatrix;

use crate::recording::prepare::motion_error::MotionError;
use crate::recording::prepare::settings::Method;
use crate::recording::series::zero_phase::ZeroPhase;
use crate::recording::time_base::timing::Timing;

/// Motion of n joints over N rows: `[j][k]`, joint j, row k.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Motion {
    /// rad or m.
    pub position: Vec<Vec<f64>>,
    /// rad/s or m/s.
    pub velocity: Vec<Vec<f64>>,
    /// rad/s² or m/s².
    pub acceleration: Vec<Vec<f64>>,
}

/// Whether a bandwidth was asked for or follows from the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Chosen {
    /// Asked for.
    Given,
    /// By the data.
    Data,
}

/// Bandwidth of the motion of one joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bandwidth {
    /// Harmonics of the Fourier series; None for the smoother and the low-pass.
    pub harmonics: Option<usize>,
    /// Highest frequency of the motion that is kept, Hz.
    pub cutoff_hz: f64,
    /// Up to here the motion stands clear of its noise; the cut-off where it was given.
    pub clear_hz: f64,
    /// Where the bandwidth is from.
    pub chosen: Chosen,
    /// About how many reversals the band is wider; 0 where it is even.
    pub reversals: usize,
}

/// Noise, as the scatter of the periods about one another shows it.
#[derive(Debug, Clone, PartialEq)]
pub struct Noise {
    /// After which the motion repeats, s.
    pub period: f64,
    /// Degrees of freedom of the scatter.
    pub degrees: f64,
    /// Covariance of one row of `Experiment::signal`, channels x channels, unit of the signal squared: where rows are averages,
    /// that of a recorded sample divided by the number of periods.
    pub signal_covariance: DMatrix<f64>,
    /// Autocovariance of one row by channel and lag: `[c][l]`, lags of l rows from 0 on.
    pub autocovariance: Vec<Vec<f64>>,
    /// Standard deviation of one recorded position, per joint, rad or m.
    pub recorded_position_sd: Vec<f64>,
}

/// Which rows of the motion a recorded sample belongs to.
#[derive(Debug, Clone, PartialEq)]
pub enum RowMap {
    /// Sample k is row k.
    Same,
    /// Sample k is the row that stands here; other rows lie in gaps.
    Listed(Vec<usize>),
    /// Sample `first + m` is row m modulo the rows.
    Periodic {
        /// Sample at which row 0 is.
        first: usize,
    },
}

/// Every recorded sample for which there is motion, unfiltered.
#[derive(Debug, Clone, PartialEq)]
pub struct Raw {
    /// s, from the first sample of the file.
    pub t: Vec<f64>,
    /// `[c][k]`, as recorded.
    pub signal: Vec<Vec<f64>>,
    /// °C, `[j][k]`, as recorded.
    pub temperature: Option<Vec<Vec<f64>>>,
    /// false: left out.
    pub mask: Option<Vec<bool>>,
    /// Which row of the motion each sample belongs to.
    pub map: RowMap,
    pub(in crate::recording) rows: usize,
}

/// Whole periods found in a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Periods {
    /// Whole periods that were averaged.
    pub count: usize,
    /// Rows of one period.
    pub samples: usize,
    /// s.
    pub period: f64,
    /// Whether the period was asked for or follows from the motion.
    pub chosen: Chosen,
}

/// A recording made ready for a model.
#[derive(Debug, Clone, PartialEq)]
pub struct Experiment {
    /// The file that was read.
    pub file: PathBuf,
    /// s, from the first sample of the file; about even.
    pub t: Vec<f64>,
    /// Rows per second on the average, Hz.
    pub rate_hz: f64,
    /// Positions, velocities and accelerations of the joints at the rows.
    pub motion: Motion,
    /// None where nothing tells the noise of the positions.
    pub motion_error: Option<MotionError>,
    /// How the motion follows from the positions.
    pub method: Method,
    /// `[c][k]`: averaged over periods, or as recorded; in the unit of the recording.
    pub signal: Vec<Vec<f64>>,
    /// false: the row is there to keep the rows about even in time, but counts for nothing.
    pub mask: Option<Vec<bool>>,
    /// None where nothing repeats, so that there are no two periods to compare.
    pub noise: Option<Noise>,
    /// Per channel the deviation of a row's noise where that of the samples is seen to be white, behind the parallel filter if
    /// there is one, in the unit of the recording; empty where periods tell the noise.
    pub white_noise: Vec<Option<f64>>,
    /// Every recorded sample with its way back to the rows.
    pub raw: Raw,
    /// Per joint.
    pub bandwidth: Vec<Bandwidth>,
    /// What the time stamps are like.
    pub timing: Timing,
    /// The periods of which the rows are averages; None where rows are samples.
    pub periods: Option<Periods>,
    /// Seconds dropped at the start, and about as many at the end, where too little is known of the motion.
    pub edge_s: f64,
    /// The parallel filter, already run over `signal`.
    pub parallel: Option<ZeroPhase>,
    /// What a reader of any result should know of how the recording was taken.
    pub remarks: Vec<String>,
}

impl Experiment {
    /// Rows of the motion and the signal.
    pub fn rows(&self) -> usize {
        self.t.len()
    }

    /// s from a row to the next; behind the last as on the average.
    pub fn step_after(&self, row: usize) -> f64 {
        match (self.t.get(row), self.t.get(row + 1)) {
            (Some(now), Some(next)) => next - now,
            _ => 1.0 / self.rate_hz,
        }
    }

    /// Temperatures at the rows, °C, `[joint][row]`: between samples on a straight line, beyond the first and the last as
    /// there. Empty where none was recorded.
    pub fn temperatures(&self) -> Vec<Vec<f64>> {
        let series = self.raw.temperature.iter().flatten();
        let at = |series: &[f64], t: f64| {
            let times = &self.raw.t;
            let next = times.partition_point(|other| *other < t);
            match (next.checked_sub(1), series.get(next)) {
                (Some(before), Some(there)) => {
                    let share = (t - times[before]) / (times[next] - times[before]);
                    series[before] + share * (there - series[before])
                }
                (None, Some(first)) => *first,
                (_, None) => series.last().copied().unwrap_or(f64::NAN),
            }
        };
        let of = |series: &Vec<f64>| self.t.iter().map(|t| at(series, *t)).collect();
        series.map(of).collect()
    }

    /// Runs the parallel filter, if there is one, over a series of one value per row.
    pub fn apply_parallel(&self, series: &mut [f64]) {
        match (&self.parallel, &self.periods) {
            (Some(filter), Some(_)) => filter.apply_periodic(series),
            (Some(filter), None) => filter.apply(series),
            (None, _) => {}
        }
    }

    /// The rows of one channel in one period, from 0; empty without such a period.
    pub fn period_signal(&self, channel: usize, period: usize) -> Vec<f64> {
        let Some(periods) = self.periods.filter(|periods| period < periods.count) else {
            return Vec::new();
        };
        let start = self.raw.first() + period * periods.samples;
        self.raw.signal[channel][start..][..periods.samples].to_vec()
    }
}

impl Experiment {
    /// Which rows of one period were measured in it, from 0; None: all that the mask of the rows has.
    pub fn period_mask(&self, period: usize) -> Option<Vec<bool>> {
        let periods = self.periods.filter(|periods| period < periods.count)?;
        let start = self.raw.first() + period * periods.samples;
        let mask = self.raw.mask.as_ref()?;
        Some(mask[start..][..periods.samples].to_vec())
    }

    /// The mask of all periods one after the other.
    pub(super) fn masks_of_periods(&self, count: usize) -> Option<Vec<bool>> {
        let rows = || {
            let all = || vec![true; self.rows()];
            self.mask.clone().unwrap_or_else(all)
        };
        let masks: Vec<Option<Vec<bool>>> = (0..count).map(|p| self.period_mask(p)).collect();
        if self.mask.is_none() && masks.iter().all(Option::is_none) {
            return None;
        }
        let of_period = |mask: Option<Vec<bool>>| match mask {
            Some(mask) => (mask.iter().zip(rows())).map(|(a, b)| *a && b).collect(),
            None => rows(),
        };
        Some(masks.into_iter().flat_map(of_period).collect())
    }
}

impl Raw {
    /// Row of the motion that a recorded sample belongs to.
    pub fn row_of(&self, sample: usize) -> usize {
        match &self.map {
            RowMap::Same => sample,
            RowMap::Listed(rows) => rows[sample],
            RowMap::Periodic { first } => (sample + self.rows - first % self.rows) % self.rows,
        }
    }

    /// Sample of row 0 of the first period.
    fn first(&self) -> usize {
        match self.map {
            RowMap::Periodic { first } => first,
            _ => 0,
        }
    }
}
