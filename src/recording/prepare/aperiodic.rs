//! Motion and signal of a recording of which no periods are averaged. The motion is smoothed, or low-passed where that is asked
//! for; the signal stays as it was recorded, for a filter of the signal alone would make dry friction look smooth. Where the
//! motion repeats after no whole number of samples, its periods tell the noise.

use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::fault::Place;
use crate::recording::channels::samples::Recording;
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::formats::table::LEAST_ROWS;
use crate::recording::prepare::derivatives::differentiate::{
    Differentiated, LONG_GAP, gaps, low_passed, smoothed,
};
use crate::recording::prepare::experiment::{Experiment, Raw, RowMap};
use crate::recording::prepare::filter::parallel;
use crate::recording::prepare::noise_level::{hiding_step, pieces, white_deviation};
use crate::recording::prepare::periods::scatter;
use crate::recording::prepare::settings::{Method, Preparation};
use crate::recording::series::interpolation::{Ends, fill, fill_motion};
use crate::recording::series::zero_phase::ZeroPhase;
use crate::recording::time_base::sample_rows::SampleRows;
use crate::recording::time_base::timing::{Grid, Timing, even_motion, take_stamps};

/// A piece between two gaps loses at most one part in so many on each side, so that at least a third of it counts.
const SHARE_OF_NEIGHBOURS: usize = 3;

pub(in crate::recording) fn prepare(
    mut recording: Recording,
    preparation: &Preparation,
    timing: Timing,
    period: Option<f64>,
) -> Result<Experiment, RecordingError> {
    let t = take_stamps(&mut recording, timing.rate_hz);
    let raw = Raw {
        signal: recording.signal.clone(),
        temperature: recording.temperature.take(),
        mask: recording.signal_mask(),
        map: RowMap::Same,
        rows: t.len(),
        t,
    };
    let uneven = (!timing.uniform).then(|| SampleRows::new(&raw.t, 1.0 / timing.rate_hz));
    let rate_hz = uneven.as_ref().map_or(timing.rate_hz, SampleRows::rate_hz);
    let parallel = parallel(&recording.file, preparation, rate_hz)?;
    let noise =
        period.and_then(|period| scatter::noise(&recording, &raw.t, period, parallel.as_ref()));
    fill_masked(&mut recording)?;
    let rows = match uneven {
        None => Rows::of_even_samples(recording, raw, preparation, &timing)?,
        Some(rows) => {
            let differentiated = differentiate_at(&rows, &recording, preparation, &timing)?;
            Rows::of_uneven_samples(recording, raw, rows, differentiated)
        }
    };
    let mut experiment = rows.assembled(timing, parallel)?;
    experiment.noise = noise;
    if experiment.parallel.is_none() {
        let remark = coarse_signals(&experiment);
        experiment.remarks.extend(remark);
    }
    Ok(experiment)
}

/// What a reader should know of signals whose steps are coarser than their noise.
fn coarse_signals(experiment: &Experiment) -> Option<String> {
    let steps = (experiment.signal.iter().enumerate()).filter_map(|(channel, series)| {
        Some((
            channel,
            hiding_step(&pieces(series, experiment.mask.as_deref()))?,
        ))
    });
    let named: Vec<String> = steps
        .map(|(channel, step)| format!("{} ({step:.4})", channel + 1))
        .collect();
    (!named.is_empty()).then(|| {
        format!(
            "Signals of {} come in steps that hide their noise: channels with their steps are {}. Rounding to a step h adds \
             h²/12 to the variance of the residuals, on which intervals rest.",
            experiment.file.display(),
            named.join(", ")
        )
    })
}

/// Motion and signal of the same instants.
struct Rows {
    file: PathBuf,
    /// s.
    t: Vec<f64>,
    rate_hz: f64,
    differentiated: Differentiated,
    signal: Vec<Vec<f64>>,
    mask: Option<Vec<bool>>,
    raw: Raw,
}

/// The motion of a recording by the method that is asked for.
fn differentiate(
    recording: &Recording,
    preparation: &Preparation,
    timing: &Timing,
) -> Result<Differentiated, RecordingError> {
    match preparation.differentiation.method {
        Some(Method::Lowpass) => low_passed(recording, preparation, timing),
        _ => smoothed(recording, preparation, timing),
    }
}

/// The motion at samples that do not come evenly: it is smooth, so that it can be worked out on an even grid and interpolated.
fn differentiate_at(
    rows: &SampleRows,
    recording: &Recording,
    preparation: &Preparation,
    timing: &Timing,
) -> Result<Differentiated, RecordingError> {
    let grid = Grid::spanning(&rows.t, timing.rate_hz);
    let mut even = even_motion(recording, &rows.stamps(), grid);
    fill_masked(&mut even)?;
    Ok(differentiate(&even, preparation, timing)?.at(&rows.t, grid))
}

impl Rows {
    /// One row for every sample.
    fn of_even_samples(
        recording: Recording,
        raw: Raw,
        preparation: &Preparation,
        timing: &Timing,
    ) -> Result<Self, RecordingError> {
        let differentiated = differentiate(&recording, preparation, timing)?;
        let rows = 0..raw.t.len();
        Ok(Self {
            mask: recording.signal_mask(),
            file: recording.file,
            t: rows.map(|k| k as f64 / timing.rate_hz).collect(),
            rate_hz: timing.rate_hz,
            differentiated,
            signal: recording.signal,
            raw,
        })
    }

    /// One row for every sample, and masked ones in gaps.
    fn of_uneven_samples(
        recording: Recording,
        raw: Raw,
        rows: SampleRows,
        differentiated: Differentiated,
    ) -> Self {
        let count = rows.t.len();
        let signal = recording.signal.iter().map(|s| rows.spread(s)).collect();
        Self {
            rate_hz: rows.rate_hz(),
            differentiated,
            signal,
            mask: rows.mask(recording.signal_mask().as_deref()),
            file: recording.file,
            t: rows.t,
            raw: Raw {
                map: RowMap::Listed(rows.of_samples),
                rows: count,
                ..raw
            },
        }
    }

    /// What is known of the motion with the signal of the same rows.
    fn assembled(
        self,
        timing: Timing,
        parallel: Option<ZeroPhase>,
    ) -> Result<Experiment, RecordingError> {
        let Self {
            file,
            mut t,
            rate_hz,
            differentiated,
            mut signal,
            mask,
            mut raw,
        } = self;
        let inner_edge = parallel.as_ref().map_or(0.0, ZeroPhase::edge_s);
        let inner = (inner_edge * rate_hz).ceil() as usize;
        let rows = kept_rows(&differentiated, &file, inner, rate_hz)?;
        let mut mask = differentiated.mask(mask, &rows);
        let mut motion = differentiated.motion;
        for series in [
            &mut motion.position,
            &mut motion.velocity,
            &mut motion.acceleration,
            &mut signal,
        ] {
            keep(series, &rows);
        }
        keep(std::slice::from_mut(&mut t), &rows);
        let left = parallel
            .as_ref()
            .map_or(1.0, ZeroPhase::gain_of_white_noise);
        let deviation = |series: &Vec<f64>| {
            white_deviation(&pieces(series, mask.as_deref())).map(|deviation| left * deviation)
        };
        let white_noise = signal.iter().map(deviation).collect();
        if let Some(filter) = &parallel {
            signal.iter_mut().for_each(|series| filter.apply(series));
            let all = mask.unwrap_or_else(|| vec![true; rows.len()]);
            let apart = mask_reach(all, inner, &file)?;
            mask = Some(mask_edges(apart, inner));
        }
        let edge_s = t[0];
        raw.keep_rows(&rows);
        Ok(Experiment {
            t,
            rate_hz,
            motion,
            motion_error: Some(differentiated.error),
            method: differentiated.method,
            signal,
            mask,
            noise: None,
            white_noise,
            raw,
            file,
            bandwidth: differentiated.bandwidth,
            timing,
            periods: None,
            edge_s,
            parallel,
            remarks: Vec::new(),
        })
    }
}

/// Lines over masked samples: what is recorded there must not leak through the filters.
fn fill_masked(recording: &mut Recording) -> Result<(), RecordingError> {
    let Some(of_signal) = recording.signal_mask() else {
        return Ok(());
    };
    if of_signal.iter().filter(|&&valid| valid).count() < LEAST_ROWS {
        let kind = RecordingErrorKind::NothingUnmasked;
        return Err(RecordingError::new(Place::file(&recording.file), kind));
    }
    for series in &mut recording.signal {
        fill(series, &of_signal, Ends::Held);
    }
    let Some(mask) = &recording.mask else {
        return Ok(());
    };
    for series in &mut recording.position {
        fill_motion(series, mask);
    }
    let measured = [&mut recording.velocity, &mut recording.acceleration];
    for series in measured.into_iter().flatten().flatten() {
        fill(series, mask, Ends::Held);
    }
    Ok(())
}

/// The rows from the first to the last whose motion is known, if enough are left once the parallel filter has its edges
/// as well.
fn kept_rows(
    differentiated: &Differentiated,
    file: &Path,
    inner: usize,
    rate_hz: f64,
) -> Result<Range<usize>, RecordingError> {
    let known = &differentiated.known;
    let start = known.iter().position(|known| *known).unwrap_or(known.len());
    let end = known
        .iter()
        .rposition(|known| *known)
        .map_or(start, |last| last + 1);
    let lost = known.len() - (end - start);
    // Shorter than a period of the cut-off, a recording shows none of the motion that is asked for.
    let cutoffs = differentiated.bandwidth.iter().map(|b| b.cutoff_hz);
    let period = rate_hz / cutoffs.fold(f64::INFINITY, f64::min);
    let least = (lost + 2 * inner)
        .saturating_add(LEAST_ROWS)
        .max(period as usize);
    if known.len() < least {
        let samples = known.len();
        let kind = RecordingErrorKind::TooShortForFilter { samples, least };
        return Err(RecordingError::new(Place::file(file), kind));
    }
    Ok(start..end)
}

fn keep(channels: &mut [Vec<f64>], rows: &Range<usize>) {
    for series in channels {
        series.truncate(rows.end);
        series.drain(..rows.start);
    }
}

/// Masks the rows at both ends in which the parallel filter knows too little.
fn mask_edges(mut mask: Vec<bool>, edge: usize) -> Vec<bool> {
    let rows = mask.len();
    mask[..edge].fill(false);
    mask[rows - edge..].fill(false);
    mask
}

/// Masks the rows within the filter's reach of a gap: what bridges the signal there is not what the model makes of what
/// bridges the motion, and the filter carries the difference to both sides. Short pieces between gaps keep their middle.
///
/// Errors: too few rows are left.
fn mask_reach(mut mask: Vec<bool>, reach: usize, file: &Path) -> Result<Vec<bool>, RecordingError> {
    let rows = mask.len();
    let long = gaps(Some(&mask), (LONG_GAP * reach as f64) as usize);
    // The reach into what lies between a gap and the next one, or the end of the recording.
    let within = |between: usize| reach.min(between / SHARE_OF_NEIGHBOURS);
    for (k, gap) in long.iter().enumerate() {
        let before = k.checked_sub(1).map_or(0, |k| long[k].end);
        let after = long.get(k + 1).map_or(rows, |next| next.start);
        let (start, end) = (within(gap.start - before), within(after - gap.end));
        mask[gap.start - start..gap.end + end].fill(false);
    }
    if mask.iter().filter(|&&counts| counts).count() < LEAST_ROWS {
        let kind = RecordingErrorKind::NothingUnmasked;
        return Err(RecordingError::new(Place::file(file), kind));
    }
    Ok(mask)
}

impl Raw {
    /// Keeps the recorded samples of some rows.
    fn keep_rows(&mut self, rows: &Range<usize>) {
        let mut samples = rows.clone();
        if let RowMap::Listed(of_samples) = &mut self.map {
            let before = |end: usize| of_samples.partition_point(|&row| row < end);
            samples = before(rows.start)..before(rows.end);
            *of_samples = of_samples[samples.clone()].to_vec();
            of_samples.iter_mut().for_each(|row| *row -= rows.start);
        }
        self.rows = rows.len();
        keep(std::slice::from_mut(&mut self.t), &samples);
        keep(&mut self.signal, &samples);
        if let Some(temperature) = &mut self.temperature {
            keep(temperature, &samples);
        }
        self.mask = self.mask.take().map(|mask| mask[samples].to_vec());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use std::f64::consts::TAU;

    const RATE: f64 = 500.0;

    /// Position and acceleration with content up to about 5 Hz.
    fn truth(t: f64) -> (f64, f64) {
        let terms = [(0.3, 1.0), (1.1, 0.5), (2.9, 0.05), (4.7, 0.01)];
        terms
            .iter()
            .fold((0.0, 0.0), |(q, a), (frequency, amplitude)| {
                let omega = TAU * frequency;
                let value = amplitude * (omega * t + frequency).sin();
                (q + value, a - omega * omega * value)
            })
    }

    /// Samples of the motion, which repeats after 5000: not twice.
    const ROWS: usize = 9_900;

    fn recording(sd: f64) -> Recording {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
        let position: Vec<f64> = (0..ROWS)
            .map(|k| truth(k as f64 / RATE).0 + sd * draw())
            .collect();
        Recording::of_samples("made.csv", vec![position.clone()], vec![position])
    }

    fn prepared(sd: f64, cutoff_hz: Option<f64>) -> Experiment {
        let mut preparation = Preparation {
            rate: Some(RATE),
            ..Preparation::default()
        };
        preparation.differentiation.cutoff_hz = cutoff_hz;
        crate::recording::prepare::preprocess::prepare(recording(sd), &preparation).unwrap()
    }

    /// Root mean square error of the acceleration a second away from the ends, where the edges of
    /// all cut-offs compared end.
    fn error(experiment: &Experiment) -> f64 {
        let pairs = experiment.t.iter().zip(&experiment.motion.acceleration[0]);
        let inner = pairs.filter(|(t, _)| **t > 1.0 && **t < 19.0);
        let squares: Vec<f64> = inner.map(|(t, a)| (a - truth(*t).1).powi(2)).collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    }

    #[test]
    fn chooses_nearly_the_best_cutoff() {
        for sd in [1e-7, 1e-6, 1e-5, 1e-4] {
            let chosen = error(&prepared(sd, None));
            let best = (2..80)
                .map(|cutoff| error(&prepared(sd, Some(f64::from(cutoff)))))
                .fold(f64::INFINITY, f64::min);
            assert!(chosen <= 1.3 * best, "sd {sd}: {chosen} for {best}");
        }
    }

    #[test]
    fn a_low_pass_drops_two_cycles_of_its_cutoff_at_both_ends() {
        let mut preparation = Preparation {
            rate: Some(RATE),
            ..Preparation::default()
        };
        preparation.differentiation.method = Some(Method::Lowpass);
        preparation.differentiation.cutoff_hz = Some(8.0);
        let experiment =
            crate::recording::prepare::preprocess::prepare(recording(1e-6), &preparation).unwrap();
        assert_eq!(experiment.edge_s, 0.25);
        assert_eq!(experiment.rows(), ROWS - 2 * 125);
        assert_eq!(experiment.t[0], 0.25);
        let pairs = experiment.raw.t.iter().zip(&experiment.t);
        assert!(
            pairs
                .into_iter()
                .all(|(raw, row)| (raw - row).abs() < 1e-12)
        );
    }

    #[test]
    fn the_signal_is_left_as_it_was_recorded() {
        let recording = recording(1e-4);
        let signal = recording.signal[0].clone();
        let experiment = prepared(1e-4, None);
        let first = (experiment.t[0] * RATE).round() as usize;
        assert!(experiment.edge_s < 0.2);
        assert_eq!(experiment.signal[0], signal[first..][..experiment.rows()]);
    }

    #[test]
    fn announces_the_error_of_the_motion() {
        for sd in [1e-6, 1e-5, 1e-4] {
            let experiment = prepared(sd, None);
            let stated = experiment
                .motion_error
                .as_ref()
                .unwrap()
                .acceleration
                .deviation(0);
            let ratio = error(&experiment) / stated;
            assert!((0.5..1.5).contains(&ratio), "sd {sd}: {ratio}");
        }
    }
}
