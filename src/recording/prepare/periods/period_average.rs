//! The average over the whole periods of a recording, where they lie, and the differences from it.
//!
//! x̄(k) = Σ_p x_p(k) / P   and   e_p(k) = x_p(k) - x̄(k),   over the periods in which the sample is
//! valid.

use crate::fault::Place;
use crate::recording::channels::samples::Recording;
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::prepare::experiment::{Chosen, Periods};
use crate::recording::series::interpolation::{Ends, fill};

/// The whole periods: sample `first + p N + k` is row k of period p.
pub(super) struct PeriodAverage {
    pub first: usize,
    /// Periods P.
    pub count: usize,
    /// Rows N of a period.
    pub samples: usize,
    /// s.
    pub period: f64,
    /// Of the `P N` samples; None: all are valid.
    mask: Option<Vec<bool>>,
}

impl PeriodAverage {
    /// The periods, and where they are from.
    pub fn periods(&self, chosen: Chosen) -> Periods {
        Periods {
            count: self.count,
            samples: self.samples,
            period: self.period,
            chosen,
        }
    }

    /// From the first valid sample on, as many periods of `samples` rows as fit.
    ///
    /// Errors: less than one period, no valid sample.
    pub fn new(recording: &Recording, samples: usize, period: f64) -> Result<Self, RecordingError> {
        let fault = |kind| RecordingError::new(Place::file(&recording.file).key("period"), kind);
        let length = recording.position.first().map_or(0, Vec::len);
        let first = match &recording.mask {
            Some(mask) => mask.iter().position(|&valid| valid),
            None => Some(0),
        };
        let first = first.ok_or_else(|| fault(RecordingErrorKind::NothingUnmasked))?;
        let count = (length - first) / samples;
        if count == 0 {
            let duration = (length - first) as f64 * period / samples as f64;
            return Err(fault(RecordingErrorKind::ShorterThanPeriod {
                duration,
                period,
            }));
        }
        let range = first..first + count * samples;
        Ok(Self {
            first,
            count,
            samples,
            period,
            mask: recording.mask.as_ref().map(|mask| mask[range].to_vec()),
        })
    }

    /// The same periods with another mask of all samples of the recording.
    pub fn with_mask(&self, mask: Option<&[bool]>) -> Self {
        let range = self.first..self.first + self.count * self.samples;
        Self {
            mask: mask.map(|mask| mask[range].to_vec()),
            ..*self
        }
    }

    fn valid(&self, index: usize) -> bool {
        self.mask.as_ref().is_none_or(|mask| mask[index])
    }

    /// Periods in which row k is valid.
    fn valid_count(&self, k: usize) -> usize {
        match self.mask {
            None => self.count,
            Some(_) => (0..self.count)
                .filter(|p| self.valid(p * self.samples + k))
                .count(),
        }
    }

    /// Which rows were measured in some period; None: all.
    pub fn row_mask(&self) -> Option<Vec<bool>> {
        self.mask.as_ref()?;
        let rows: Vec<bool> = (0..self.samples).map(|k| self.valid_count(k) > 0).collect();
        rows.contains(&false).then_some(rows)
    }

    /// Degrees of freedom of the differences: Σ_k (valid periods of row k - 1); (P - 1) N unmasked.
    pub fn degrees(&self) -> usize {
        (0..self.samples)
            .map(|k| self.valid_count(k).saturating_sub(1))
            .sum()
    }

    /// Mean of a recorded series over the periods; rows never measured are interpolated.
    pub fn mean(&self, series: &[f64]) -> Vec<f64> {
        let used = &series[self.first..][..self.count * self.samples];
        let mut mean: Vec<f64> = (0..self.samples)
            .map(|k| {
                let valid = (k..used.len())
                    .step_by(self.samples)
                    .filter(|&i| self.valid(i));
                let sum: f64 = valid.map(|i| used[i]).sum();
                sum / self.valid_count(k).max(1) as f64
            })
            .collect();
        if let Some(mask) = self.row_mask() {
            fill(&mut mean, &mask, Ends::Joined);
        }
        mean
    }

    /// Differences of a recorded series from its mean, period after period; 0 where masked.
    pub fn differences(&self, series: &[f64], mean: &[f64]) -> Vec<f64> {
        let used = &series[self.first..][..self.count * self.samples];
        used.iter()
            .enumerate()
            .map(|(i, value)| match self.valid(i) {
                true => value - mean[i % self.samples],
                false => 0.0,
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recording(series: Vec<f64>, mask: Option<Vec<bool>>) -> Recording {
        Recording {
            mask,
            ..Recording::of_samples("made.csv", vec![series], Vec::new())
        }
    }

    #[test]
    fn a_masked_sample_is_left_out_of_its_row_only() {
        let series = vec![1.0, 2.0, 3.0, 99.0, 5.0, 4.0, 3.0];
        let mask = vec![true, true, true, false, true, true, true];
        let recording = recording(series, Some(mask));
        let average = PeriodAverage::new(&recording, 3, 1.0).unwrap();
        assert_eq!(average.count, 2);
        assert_eq!(average.mean(&recording.position[0]), [1.0, 3.5, 3.5]);
        assert_eq!(average.degrees(), 2);
        assert_eq!(average.row_mask(), None);
    }

    #[test]
    fn a_row_masked_in_all_periods_is_masked() {
        let series = vec![1.0, 2.0, 9.0, 1.0, 2.0, 9.0];
        let mask = vec![true, true, false, true, true, false];
        let recording = recording(series, Some(mask));
        let average = PeriodAverage::new(&recording, 3, 1.0).unwrap();
        assert_eq!(average.row_mask(), Some(vec![true, true, false]));
        assert_eq!(average.mean(&recording.position[0]), [1.0, 2.0, 1.5]);
    }

    #[test]
    fn periods_start_at_the_first_valid_sample() {
        let mask = (0..10).map(|k| k >= 3).collect();
        let recording = recording((0..10).map(f64::from).collect(), Some(mask));
        let average = PeriodAverage::new(&recording, 3, 1.0).unwrap();
        assert_eq!((average.first, average.count), (3, 2));
    }

    #[test]
    fn less_than_a_period_is_an_error() {
        let of = |samples: usize, first: usize| {
            let mask = (0..10).map(|k| k >= first).collect();
            let recording = recording((0..10).map(f64::from).collect(), Some(mask));
            PeriodAverage::new(&recording, samples, 1.0)
        };
        assert_eq!(of(10, 0).unwrap().count, 1);
        assert!(of(11, 0).is_err());
        assert!(of(10, 1).is_err());
        assert!(of(3, 10).is_err());
    }
}
