//! Motion and signal of a recording without a period: a zero-phase low-pass of everything, then
//! central differences of what was not measured.

use std::ops::Range;
use std::path::Path;

use crate::fault::Place;
use crate::recording::columns::Recording;
use crate::recording::cutoff::{Cutoff, Sampling, choose_cutoff};
use crate::recording::differences::{first, second};
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::experiment::{Bandwidth, Chosen, Experiment, Motion, Raw, RowMap};
use crate::recording::fill::{Ends, fill};
use crate::recording::settings::Preparation;
use crate::recording::table::LEAST_ROWS;
use crate::recording::timing::{Grid, Timing, resample, take_stamps};
use crate::recording::zero_phase::{ZeroPhase, edge_s};

pub(super) fn prepare(
    mut recording: Recording,
    preparation: &Preparation,
    timing: Timing,
) -> Result<Experiment, RecordingError> {
    let rate_hz = timing.rate_hz;
    let t = take_stamps(&mut recording, rate_hz);
    let mut raw = Raw {
        signal: recording.signal.clone(),
        temperature: recording.temperature.take(),
        mask: recording.mask.clone(),
        map: RowMap::Same,
        rows: t.len(),
        t,
    };
    if !timing.uniform {
        recording.time = Some(raw.t.clone());
        recording = resample(recording, Grid::spanning(&raw.t, rate_hz));
    }
    fill_masked(&mut recording)?;
    let bandwidth = bandwidths(&recording, preparation, &timing);
    let filters = Filters::new(&recording.file, &bandwidth, rate_hz)?;
    let parallel = parallel(&recording.file, preparation, rate_hz)?;
    let edge = (filters.edge_s() * rate_hz).ceil() as usize;
    let inner_edge = parallel.as_ref().map_or(0.0, ZeroPhase::edge_s);
    let inner = (inner_edge * rate_hz).ceil() as usize;
    let rows = kept_rows(&recording, edge, inner)?;
    let file = std::mem::take(&mut recording.file);
    let mut signal = filters.signal(std::mem::take(&mut recording.signal));
    let mut mask = recording.mask.take();
    let mut motion = filters.motion(recording, 1.0 / rate_hz);
    keep(&mut motion.position, &rows);
    keep(&mut motion.velocity, &rows);
    keep(&mut motion.acceleration, &rows);
    keep(&mut signal, &rows);
    mask = mask.map(|mask| mask[rows.clone()].to_vec());
    if let Some(filter) = &parallel {
        signal.iter_mut().for_each(|series| filter.apply(series));
        mask = Some(mask_edges(mask, rows.len(), inner));
    }
    let start = rows.start as f64 / rate_hz;
    raw.keep_span(&rows, start, &timing);
    Ok(Experiment {
        t: (0..rows.len())
            .map(|k| start + k as f64 / rate_hz)
            .collect(),
        rate_hz,
        motion,
        signal,
        mask,
        noise: None,
        raw,
        file,
        bandwidth,
        timing,
        periods: None,
        edge_s: edge as f64 / rate_hz,
        parallel,
    })
}

/// The parallel filter asked for.
pub(super) fn parallel(
    file: &Path,
    preparation: &Preparation,
    rate_hz: f64,
) -> Result<Option<ZeroPhase>, RecordingError> {
    match preparation.differentiation.parallel_hz {
        Some(cutoff) => filter(file, cutoff, rate_hz, "parallel_hz").map(Some),
        None => Ok(None),
    }
}

fn filter(
    file: &Path,
    cutoff_hz: f64,
    rate_hz: f64,
    key: &str,
) -> Result<ZeroPhase, RecordingError> {
    ZeroPhase::new(cutoff_hz, rate_hz).map_err(|wrong| {
        let kind = RecordingErrorKind::InvalidSetting {
            value: wrong.cutoff_hz,
            requirement: format!("above 0 and below {:.6} Hz", 0.5 * wrong.rate_hz),
        };
        RecordingError::new(Place::file(file).key(key), kind)
    })
}

/// Straight lines over masked samples: what is recorded there must not leak through the filters.
fn fill_masked(recording: &mut Recording) -> Result<(), RecordingError> {
    let Some(mask) = &recording.mask else {
        return Ok(());
    };
    if mask.iter().filter(|&&valid| valid).count() < LEAST_ROWS {
        let kind = RecordingErrorKind::NothingUnmasked;
        return Err(RecordingError::new(Place::file(&recording.file), kind));
    }
    let measured = [&mut recording.velocity, &mut recording.acceleration];
    let channels = recording.position.iter_mut().chain(&mut recording.signal);
    for series in channels.chain(measured.into_iter().flatten().flatten()) {
        fill(series, mask, Ends::Held);
    }
    Ok(())
}

/// Bandwidth of every joint: given, or from the channel that the acceleration comes from.
fn bandwidths(recording: &Recording, preparation: &Preparation, timing: &Timing) -> Vec<Bandwidth> {
    let sampling = match timing.uniform {
        true => Sampling::Recorded,
        false => Sampling::Interpolated,
    };
    let of = |joint: usize| match preparation.differentiation.cutoff_hz {
        Some(hz) => (Cutoff { hz, clear_hz: hz }, Chosen::Given),
        None => {
            let (series, order) = match (&recording.acceleration, &recording.velocity) {
                (Some(acceleration), _) => (&acceleration[joint], 0),
                (None, Some(velocity)) => (&velocity[joint], 1),
                (None, None) => (&recording.position[joint], 2),
            };
            let cutoff = choose_cutoff(series, order, timing.rate_hz, sampling);
            (cutoff, Chosen::Data)
        }
    };
    (0..recording.position.len())
        .map(of)
        .map(|(cutoff, chosen)| Bandwidth {
            harmonics: None,
            cutoff_hz: cutoff.hz,
            clear_hz: cutoff.clear_hz,
            chosen,
        })
        .collect()
}

/// The low-pass of every joint, and that of the signal.
struct Filters {
    joints: Vec<ZeroPhase>,
    /// Of the widest bandwidth: a channel carries torque that the motion of any joint causes.
    signal: Option<ZeroPhase>,
}

impl Filters {
    fn new(file: &Path, bandwidth: &[Bandwidth], rate_hz: f64) -> Result<Self, RecordingError> {
        let joints = bandwidth
            .iter()
            .map(|joint| filter(file, joint.cutoff_hz, rate_hz, "cutoff_hz"))
            .collect::<Result<Vec<_>, _>>()?;
        let wider = |a: &&ZeroPhase, b: &&ZeroPhase| a.cutoff_hz().total_cmp(&b.cutoff_hz());
        let signal = joints.iter().max_by(wider).cloned();
        Ok(Self { joints, signal })
    }

    /// Seconds lost at each end: those of the lowest cut-off.
    fn edge_s(&self) -> f64 {
        self.joints
            .iter()
            .map(|joint| edge_s(joint.cutoff_hz()))
            .fold(0.0, f64::max)
    }

    fn signal(&self, mut channels: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        if let Some(filter) = &self.signal {
            channels.iter_mut().for_each(|series| filter.apply(series));
        }
        channels
    }

    /// Filters what was measured of the motion and differentiates the rest, step in s.
    fn motion(&self, recording: Recording, step: f64) -> Motion {
        let filtered = |mut channels: Vec<Vec<f64>>| {
            for (series, filter) in channels.iter_mut().zip(&self.joints) {
                filter.apply(series);
            }
            channels
        };
        let derived = |channels: &[Vec<f64>], derivative: fn(&[f64], f64) -> Vec<f64>| {
            channels
                .iter()
                .map(|series| derivative(series, step))
                .collect::<Vec<_>>()
        };
        let position = filtered(recording.position);
        let measured = recording.velocity.map(filtered);
        let acceleration = match (recording.acceleration, &measured) {
            (Some(acceleration), _) => filtered(acceleration),
            (None, Some(velocity)) => derived(velocity, first),
            (None, None) => derived(&position, second),
        };
        Motion {
            velocity: measured.unwrap_or_else(|| derived(&position, first)),
            position,
            acceleration,
        }
    }
}

/// The rows between the edges, if enough are left once the parallel filter has its edges as well.
fn kept_rows(
    recording: &Recording,
    edge: usize,
    inner: usize,
) -> Result<Range<usize>, RecordingError> {
    let samples = recording.position.first().map_or(0, Vec::len);
    let edges = edge.saturating_add(inner).saturating_mul(2);
    let least = edges.saturating_add(LEAST_ROWS);
    if samples < least {
        let kind = RecordingErrorKind::TooShortForFilter { samples, least };
        return Err(RecordingError::new(Place::file(&recording.file), kind));
    }
    Ok(edge..samples - edge)
}

fn keep(channels: &mut [Vec<f64>], rows: &Range<usize>) {
    for series in channels {
        series.truncate(rows.end);
        series.drain(..rows.start);
    }
}

/// Masks the rows at both ends in which the parallel filter knows too little.
fn mask_edges(mask: Option<Vec<bool>>, rows: usize, edge: usize) -> Vec<bool> {
    let mut mask = mask.unwrap_or_else(|| vec![true; rows]);
    mask[..edge].fill(false);
    mask[rows - edge..].fill(false);
    mask
}

impl Raw {
    /// Keeps the recorded samples within the span of the rows, the first of which is at `start`.
    fn keep_span(&mut self, rows: &Range<usize>, start: f64, timing: &Timing) {
        let mut samples = rows.clone();
        if !timing.uniform {
            let rate_hz = timing.rate_hz;
            let end = (rows.end - 1) as f64 / rate_hz;
            samples = self.t.partition_point(|t| *t < start)..self.t.partition_point(|t| *t <= end);
            self.map = RowMap::Grid { start, rate_hz };
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

    fn recording(sd: f64) -> Recording {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
        let position: Vec<f64> = (0..10_000)
            .map(|k| truth(k as f64 / RATE).0 + sd * draw())
            .collect();
        Recording {
            file: "made.csv".into(),
            time: None,
            first_line: 2,
            signal: vec![position.clone()],
            position: vec![position],
            velocity: None,
            acceleration: None,
            temperature: None,
            mask: None,
        }
    }

    fn prepared(sd: f64, cutoff_hz: Option<f64>) -> Experiment {
        let mut preparation = Preparation {
            rate: Some(RATE),
            ..Preparation::default()
        };
        preparation.differentiation.cutoff_hz = cutoff_hz;
        crate::recording::experiment::prepare(recording(sd), &preparation).unwrap()
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
    fn drops_two_cycles_of_the_cutoff_at_both_ends() {
        let experiment = prepared(1e-6, Some(8.0));
        assert_eq!(experiment.edge_s, 0.25);
        assert_eq!(experiment.rows(), 10_000 - 2 * 125);
        assert_eq!(experiment.t[0], 0.25);
        let pairs = experiment.raw.t.iter().zip(&experiment.t);
        assert!(
            pairs
                .into_iter()
                .all(|(raw, row)| (raw - row).abs() < 1e-12)
        );
    }
}
