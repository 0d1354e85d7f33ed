//! Whole periods: their mean, and the noise that their scatter about it shows.
//!
//! x̄(k) = (1/P) Σ_p x_p(k),   Σ = Σ_k Σ_p e_p(k) e_p(k)ᵀ / ((P - 1) N)   with e_p = x_p - x̄:
//! the covariance of one recorded sample; that of the mean is Σ / P.

use crate::fault::Place;
use crate::recording::channels::samples::Recording;
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::formats::table::LEAST_ROWS;
use crate::recording::prepare::experiment::{
    Bandwidth, Chosen, Experiment, Motion, Noise, Raw, RowMap,
};
use crate::recording::prepare::filter::parallel;
use crate::recording::prepare::motion_error::MotionError;
use crate::recording::prepare::periods::fourier::{self, JointSpectrum};
use crate::recording::prepare::periods::period_average::PeriodAverage;
use crate::recording::prepare::periods::row_noise::Scatter;
use crate::recording::prepare::periods::shrinkage;
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
    let mean = MeanMotion::of(&positions, &average, preparation, period);
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
        motion_error: Some(mean.error),
        motion: mean.motion,
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
        bandwidth: mean.bandwidth,
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

/// The mean motion of all joints with its derivatives.
struct MeanMotion {
    motion: Motion,
    error: MotionError,
    bandwidth: Vec<Bandwidth>,
}

impl MeanMotion {
    /// By the method asked for.
    fn of(
        positions: &[Vec<f64>],
        average: &PeriodAverage,
        preparation: &Preparation,
        period: f64,
    ) -> Self {
        let spectra = positions
            .iter()
            .map(|recorded| spectrum(recorded, average, preparation, period));
        let (mut spectra, mut bandwidth): (Vec<_>, Vec<_>) = spectra.unzip();
        let error = fourier::row_errors(&shrinkage::shrink(&mut spectra), period);
        for (bandwidth, spectrum) in bandwidth.iter_mut().zip(&spectra) {
            if spectrum.shrinks {
                bandwidth.harmonics = Some(spectrum.summed);
                bandwidth.cutoff_hz = spectrum.summed as f64 / period;
            }
        }
        let mut motion = Motion::default();
        for spectrum in spectra {
            let [position, velocity, acceleration] = spectrum.sum(average.samples, period);
            motion.position.push(position);
            motion.velocity.push(velocity);
            motion.acceleration.push(acceleration);
        }
        Self {
            motion,
            error,
            bandwidth,
        }
    }
}

/// The series of the mean position of one joint, and how far it reaches by the method asked for.
fn spectrum(
    recorded: &[f64],
    average: &PeriodAverage,
    preparation: &Preparation,
    period: f64,
) -> (JointSpectrum, Bandwidth) {
    let n = average.samples;
    let mean = average.mean(recorded);
    let differences = average.differences(recorded, &mean);
    let (coefficients, noise) = fourier::analyse(&mean, &differences);
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
    let clear_hz = match chosen {
        Chosen::Given => cutoff_hz,
        Chosen::Data => fourier::clear_harmonics(&coefficients, &noise, harmonics) as f64 / period,
    };
    let is_filtered = settings.method == Some(Method::Lowpass);
    let mut spectrum = JointSpectrum {
        coefficients,
        noise,
        summed: harmonics,
        // What a given bandwidth leaves out is left out on purpose.
        shrinks: chosen == Chosen::Data && !is_filtered,
    };
    if is_filtered {
        spectrum.summed = fourier::most_harmonics(n);
        spectrum.filter(|h| gain(h as f64 / period, cutoff_hz, n as f64 / period));
    }
    let bandwidth = Bandwidth {
        reversals: 0,
        harmonics: (!is_filtered).then_some(harmonics),
        cutoff_hz,
        clear_hz,
        chosen,
    };
    (spectrum, bandwidth)
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
