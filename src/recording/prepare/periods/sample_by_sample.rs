//! The recorded samples of a periodic recording in place of the average over periods, raw signal included.

use crate::recording::prepare::experiment::{Experiment, Motion, Noise, Raw, RowMap};

impl Experiment {
    /// Every whole period one after the other: the motion is that of the average, the signal as recorded.
    ///
    /// `None` without whole periods.
    pub fn unfolded(&self) -> Option<Self> {
        let periods = self.periods?;
        let (count, samples) = (periods.count, periods.samples);
        let repeat = |series: &Vec<f64>| series.repeat(count);
        let all = |set: &[Vec<f64>]| -> Vec<Vec<f64>> { set.iter().map(repeat).collect() };
        let channels = self.signal.len();
        let mut signal: Vec<Vec<f64>> = (0..channels)
            .map(|c| (0..count).flat_map(|p| self.period_signal(c, p)).collect())
            .collect();
        if let Some(filter) = &self.parallel {
            signal.iter_mut().for_each(|series| filter.apply(series));
        }
        let rows = count * samples;
        let t: Vec<f64> = (0..rows)
            .map(|k| self.t[0] + k as f64 / self.rate_hz)
            .collect();
        Some(Self {
            motion: Motion {
                position: all(&self.motion.position),
                velocity: all(&self.motion.velocity),
                acceleration: all(&self.motion.acceleration),
            },
            raw: Raw {
                t: t.clone(),
                signal: signal.clone(),
                temperature: None,
                mask: None,
                map: RowMap::Same,
                rows,
            },
            mask: self.masks_of_periods(count),
            motion_error: self.motion_error.clone(),
            remarks: self.remarks.clone(),
            white_noise: Vec::new(),
            noise: self.noise.as_ref().map(|noise| of_sample(noise, count)),
            t,
            signal,
            periods: None,
            file: self.file.clone(),
            bandwidth: self.bandwidth.clone(),
            timing: self.timing.clone(),
            parallel: self.parallel.clone(),
            ..*self
        })
    }
}

/// The noise of one recorded sample from that of the mean over periods; the motion stays the average.
fn of_sample(noise: &Noise, count: usize) -> Noise {
    let factor = count as f64;
    let scaled = |series: &Vec<f64>| series.iter().map(|x| x * factor).collect();
    Noise {
        signal_covariance: &noise.signal_covariance * factor,
        autocovariance: noise.autocovariance.iter().map(scaled).collect(),
        ..noise.clone()
    }
}
