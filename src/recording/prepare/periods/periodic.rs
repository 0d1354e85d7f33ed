//! Whole periods: their mean, and the noise that their scatter about it shows.
//!
//! x̄(k) = (1/P) Σ_p x_p(k),   Σ = Σ_k Σ_p e_p(k) e_p(k)ᵀ / ((P - 1) N)   with e_p = x_p - x̄:
//! the covariance of one recorded sample; that of the mean is Σ / P.

use crate::fault::Place;
use crate::recording::channels::samples::Recording;
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::formats::table::LEAST_ROWS;
use crate::recording::prepare::experiment::{
    Bandwidth, Chosen, Experiment, Motion, MotionError, Noise, Raw, RowMap,
};
use crate::recording::prepare::filter::parallel;
use crate::recording::prepare::periods::fourier::{self, Series};
use crate::recording::prepare::periods::period_average::PeriodAverage;
use crate::recording::prepare::periods::row_noise::Scatter;
use crate::recording::prepare::settings::{Method, Preparation};
use crate::recording::series::zero_phase::{ZeroPhase, gain};
use crate::recording::time_base::timing::{Timing, take_stamps};

pub(in crate::recording) fn prepare(
    mut recording: Recording,
    preparation: &Preparation,
    timing: Timing,
    period: f64,
    chosen: Chosen,
) -> Result<Experiment, RecordingError> {
    let samples = rows_of(&recording, &timing, period)?;
    let rate_hz = samples as f64 / period;
    let t = take_stamps(&mut recording, timing.rate_hz);
    let temperature = recording.temperature.take();
    let recorded_mask = recording.signal_mask();
    let average = PeriodAverage::new(&recording, samples, period)?;
    let average_of_signal = average.with_mask(recorded_mask.as_deref());
    let first = average.first;
    let start = t[first];
    let parallel = parallel(&recording.file, preparation, rate_hz)?;
    let positions = std::mem::take(&mut recording.position);
    let joints = Joints::new(&positions, &average, preparation, period);
    let recorded_signal = &recording.signal;
    let noise = noise(
        &average_of_signal,
        recorded_signal,
        &positions,
        parallel.as_ref(),
    );
    drop(positions);
    let signal = averages(&average_of_signal, recorded_signal, parallel.as_ref());
    Ok(Experiment {
        t: (0..samples).map(|k| start + k as f64 / rate_hz).collect(),
        rate_hz,
        motion_error: Some(joints.error()),
        motion: joints.motion,
        method: match preparation.differentiation.method {
            Some(Method::Lowpass) => Method::Lowpass,
            _ => Method::Fourier,
        },
        signal,
        mask: average_of_signal.row_mask(),
        noise,
        white_noise: Vec::new(),
        raw: Raw {
            t,
            signal: recording.signal,
            temperature,
            mask: recorded_mask,
            map: RowMap::Periodic { first },
            rows: samples,
        },
        file: recording.file,
        bandwidth: joints.bandwidth,
        timing,
        periods: Some(average.periods(chosen)),
        edge_s: 0.0,
        parallel,
        remarks: Vec::new(),
    })
}

/// Period averages of all channels, filtered.
fn averages(
    average: &PeriodAverage,
    signal: &[Vec<f64>],
    filter: Option<&ZeroPhase>,
) -> Vec<Vec<f64>> {
    let mut means: Vec<Vec<f64>> = signal.iter().map(|s| average.mean(s)).collect();
    if let Some(filter) = filter {
        means
            .iter_mut()
            .for_each(|mean| filter.apply_periodic(mean));
    }
    means
}

/// Rows of one period: the recorded samples it holds, to the nearest whole number.
///
/// Errors: a period of too few samples, or longer than the recording.
pub(in crate::recording) fn rows_of(
    recording: &Recording,
    timing: &Timing,
    period: f64,
) -> Result<usize, RecordingError> {
    let fault = |kind| RecordingError::new(Place::file(&recording.file).key("period"), kind);
    let exact = timing.rate_hz * period;
    if exact < LEAST_ROWS as f64 {
        let least = LEAST_ROWS as f64 / timing.rate_hz;
        let requirement = format!("at least {least:.6} s, which are {LEAST_ROWS} samples");
        let value = period;
        return Err(fault(RecordingErrorKind::InvalidSetting {
            value,
            requirement,
        }));
    }
    let duration = match &recording.time {
        Some(time) => time[time.len() - 1] - time[0] + 1.0 / timing.rate_hz,
        None => recording.position[0].len() as f64 / timing.rate_hz,
    };
    // Half a step: the last sample of a period may be stamped a little early.
    if duration + 0.5 / timing.rate_hz < period {
        return Err(fault(RecordingErrorKind::ShorterThanPeriod {
            duration,
            period,
        }));
    }
    Ok(exact.round() as usize)
}

/// Motion, bandwidth and noise of all joints.
struct Joints {
    motion: Motion,
    bandwidth: Vec<Bandwidth>,
    /// Variances of a row's position, velocity and acceleration, per joint.
    variances: Vec<[f64; 3]>,
}

impl Joints {
    fn new(
        positions: &[Vec<f64>],
        average: &PeriodAverage,
        preparation: &Preparation,
        period: f64,
    ) -> Self {
        let mut joints = Self {
            motion: Motion::default(),
            bandwidth: Vec::new(),
            variances: Vec::new(),
        };
        for recorded in positions {
            let (series, bandwidth) = differentiate(recorded, average, preparation, period);
            joints.motion.position.push(series.position);
            joints.motion.velocity.push(series.velocity);
            joints.motion.acceleration.push(series.acceleration);
            joints.variances.push(series.variances);
            joints.bandwidth.push(bandwidth);
        }
        joints
    }

    fn error(&self) -> MotionError {
        let deviation = |order: usize| {
            let variances = self.variances.iter();
            variances.map(|v| v[order].sqrt()).collect::<Vec<f64>>()
        };
        MotionError {
            position: deviation(0),
            velocity: deviation(1),
            acceleration: deviation(2),
        }
    }
}

/// The mean position of one joint with its derivatives, by the method asked for.
fn differentiate(
    recorded: &[f64],
    average: &PeriodAverage,
    preparation: &Preparation,
    period: f64,
) -> (Series, Bandwidth) {
    let n = average.samples;
    let mean = average.mean(recorded);
    let differences = average.differences(recorded, &mean);
    let (mut coefficients, mut noise) = fourier::analyse(&mean, &differences);
    let settings = &preparation.differentiation;
    let chosen = match settings.cutoff_hz {
        Some(_) => Chosen::Given,
        None => Chosen::Data,
    };
    let harmonics = match settings.cutoff_hz {
        Some(cutoff) => (cutoff * period + 1e-9) as usize,
        None => fourier::choose_harmonics(&coefficients, &noise, n),
    };
    let harmonics = harmonics.max(1).min(fourier::most_harmonics(n));
    let cutoff_hz = settings.cutoff_hz.unwrap_or(harmonics as f64 / period);
    let mut bandwidth = Bandwidth {
        reversals: 0,
        harmonics: Some(harmonics),
        cutoff_hz,
        clear_hz: match chosen {
            Chosen::Given => cutoff_hz,
            Chosen::Data => {
                fourier::clear_harmonics(&coefficients, &noise, harmonics) as f64 / period
            }
        },
        chosen,
    };
    let mut summed = harmonics;
    if settings.method == Some(Method::Lowpass) {
        for (h, (c, variance)) in coefficients.iter_mut().zip(&mut noise).enumerate() {
            let gain = gain(h as f64 / period, cutoff_hz, n as f64 / period);
            *c *= gain;
            *variance *= gain * gain;
        }
        bandwidth.harmonics = None;
        summed = fourier::most_harmonics(n);
    } else if chosen == Chosen::Data {
        noise = fourier::shrink(&mut coefficients, &noise, harmonics);
    } else {
        // What a given bandwidth leaves out is left out on purpose.
        noise.truncate(harmonics + 1);
    }
    let series = fourier::series(&coefficients, &noise, summed, n, period);
    (series, bandwidth)
}

/// Noise of the means of all channels; None without two valid periods.
fn noise(
    average: &PeriodAverage,
    signal: &[Vec<f64>],
    positions: &[Vec<f64>],
    parallel: Option<&ZeroPhase>,
) -> Option<Noise> {
    let degrees = average.degrees() as f64;
    if average.count < 2 || degrees == 0.0 {
        return None;
    }
    let differences = |series: &Vec<f64>| average.differences(series, &average.mean(series));
    let mut scatter: Vec<Vec<f64>> = signal.iter().map(differences).collect();
    if let Some(filter) = parallel {
        // Filtered means are means of filtered periods, so their scatter is that of the differences
        // after the filter.
        let periods = scatter
            .iter_mut()
            .flat_map(|e| e.chunks_mut(average.samples));
        periods.for_each(|period| filter.apply_periodic(period));
    }
    let of_periods = Scatter {
        signal: scatter,
        position: positions.iter().map(differences).collect(),
        divisor: degrees,
        degrees,
        averaged: average.count as f64,
        period: average.period,
        samples: average.samples,
    };
    Some(of_periods.noise())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_roots_of_the_variances_of_their_own_order() {
        let joints = Joints {
            motion: Motion::default(),
            bandwidth: Vec::new(),
            variances: vec![[1.0, 4.0, 9.0], [16.0, 25.0, 36.0]],
        };
        let error = joints.error();
        assert_eq!(error.position, [1.0, 4.0]);
        assert_eq!(error.velocity, [2.0, 5.0]);
        assert_eq!(error.acceleration, [3.0, 6.0]);
    }
}
