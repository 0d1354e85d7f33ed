//! Rows of a recording whose samples do not come evenly: one for every sample, at its own time, so that no signal is
//! interpolated. Where samples are missing, masked rows in their place keep the rows about even in time.

use crate::recording::channels::lost::LostSignal;
use crate::recording::channels::samples::Recording;
use crate::recording::series::interpolation::{Ends, fill};
use crate::recording::time_base::timing::{GAP_STEPS, Timing, is_even};

/// A recording whose samples come evenly but for gaps, with masked samples in these; any other as it is.
pub fn with_gaps_masked(recording: Recording, timing: Timing) -> (Recording, Timing) {
    let Some(time) = recording.time.as_ref().filter(|_| !timing.uniform) else {
        return (recording, timing);
    };
    let rows = SampleRows::new(time, 1.0 / timing.rate_hz);
    if !is_even(&rows.t, 1.0 / rows.rate_hz()) {
        return (recording, timing);
    }
    let timing = Timing {
        rate_hz: rows.rate_hz(),
        uniform: true,
        ..timing
    };
    (rows.filled(recording), timing)
}

/// Rows at samples and in gaps.
pub(in crate::recording) struct SampleRows {
    /// s.
    pub t: Vec<f64>,
    /// Row of every sample.
    pub of_samples: Vec<usize>,
}

impl SampleRows {
    /// Of increasing stamps with this usual step, s.
    pub fn new(time: &[f64], step: f64) -> Self {
        let mut rows = Self {
            t: Vec::with_capacity(time.len()),
            of_samples: Vec::with_capacity(time.len()),
        };
        for &stamp in time {
            if let Some(&last) = rows.t.last()
                && stamp - last > GAP_STEPS * step
            {
                let steps = ((stamp - last) / step).round().max(1.0);
                let missing = (1..steps as usize).map(|k| k as f64 / steps);
                rows.t
                    .extend(missing.map(|share| last + share * (stamp - last)));
            }
            rows.of_samples.push(rows.t.len());
            rows.t.push(stamp);
        }
        rows
    }

    /// Rows per second, Hz.
    pub fn rate_hz(&self) -> f64 {
        let last = self.t.len() - 1;
        last as f64 / (self.t[last] - self.t[0])
    }

    /// Times of the samples, s.
    pub fn stamps(&self) -> Vec<f64> {
        self.of_samples.iter().map(|&row| self.t[row]).collect()
    }

    /// A series of samples on the rows, with lines over gaps.
    pub fn spread(&self, series: &[f64]) -> Vec<f64> {
        if self.t.len() == series.len() {
            return series.to_vec();
        }
        let mut values = vec![0.0; self.t.len()];
        for (&row, &value) in self.of_samples.iter().zip(series) {
            values[row] = value;
        }
        fill(&mut values, &self.measured(), Ends::Held);
        values
    }

    /// A recording with a sample in every row.
    fn filled(self, recording: Recording) -> Recording {
        let channels = |channels: &Vec<Vec<f64>>| -> Vec<Vec<f64>> {
            channels.iter().map(|series| self.spread(series)).collect()
        };
        let mut lines = vec![0; self.t.len()];
        let places = self.of_samples.iter().enumerate();
        places.for_each(|(sample, &row)| lines[row] = recording.line(sample));
        for row in 1..lines.len() {
            lines[row] = lines[row].max(lines[row - 1]);
        }
        Recording {
            position: channels(&recording.position),
            velocity: recording.velocity.as_ref().map(channels),
            acceleration: recording.acceleration.as_ref().map(channels),
            signal: channels(&recording.signal),
            temperature: recording.temperature.as_ref().map(channels),
            mask: self.mask(recording.mask.as_deref()),
            lost: recording.lost.map(|lost| LostSignal {
                valid: self.mask(Some(&lost.valid)).unwrap_or_default(),
                ..lost
            }),
            lines: Some(lines),
            time: Some(self.t),
            ..recording
        }
    }

    /// Which rows count, of samples with this mask; None: all.
    pub fn mask(&self, mask: Option<&[bool]>) -> Option<Vec<bool>> {
        if mask.is_none() && self.t.len() == self.of_samples.len() {
            return None;
        }
        let mut counts = self.measured();
        if let Some(mask) = mask {
            let samples = self.of_samples.iter().zip(mask);
            samples.for_each(|(&row, &valid)| counts[row] = valid);
        }
        Some(counts)
    }

    fn measured(&self) -> Vec<bool> {
        let mut measured = vec![false; self.t.len()];
        self.of_samples.iter().for_each(|&row| measured[row] = true);
        measured
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_have_rows_of_their_own_and_gaps_have_masked_ones() {
        let time = [0.0, 1.1, 1.9, 5.0, 6.0];
        let rows = SampleRows::new(&time, 1.0);
        assert_eq!(rows.of_samples, [0, 1, 2, 5, 6]);
        assert!((rows.t[3] - (1.9 + 3.1 / 3.0)).abs() < 1e-12);
        assert_eq!(rows.rate_hz(), 1.0);
        let measured = [true, true, true, false, false, true, true];
        assert_eq!(rows.mask(None), Some(measured.to_vec()));
        let mask = rows.mask(Some(&[true, false, true, true, true])).unwrap();
        assert_eq!(mask, [true, false, true, false, false, true, true]);
        let values = rows.spread(&[3.0, 4.0, 5.0, 8.0, 9.0]);
        assert_eq!(values[2..6], [5.0, 6.0, 7.0, 8.0]);
        let even = SampleRows::new(&time[..3], 1.0);
        assert_eq!((even.mask(None), even.t.len()), (None, 3));
    }
}
