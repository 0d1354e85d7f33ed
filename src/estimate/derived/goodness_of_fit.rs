//! Goodness of fit: prediction errors channel by channel, and how much of them is noise.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::effect::Memory;
use crate::chain::evaluate::{BLOCK, Evaluator, Segment};
use crate::chain::model::{Channel, Model};
use crate::estimate::residual::noise::predict;
use crate::outcome::joint::JointFigures;
use crate::recording::split::Split;
use crate::robot::batch::Trajectory;
use nalgebra::DVector;

/// Sums of one channel over recordings.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    squares: f64,
    absolute: f64,
    signal: f64,
    rows: f64,
}

impl Sums {
    fn add(&mut self, predicted: f64, recorded: f64) {
        let error = predicted - recorded;
        self.squares += error * error;
        self.absolute += error.abs();
        self.signal += recorded * recorded;
        self.rows += 1.0;
    }

    fn rmse(&self) -> f64 {
        (self.squares / self.rows).sqrt()
    }
}

/// Predicted signals of every recording, `[recording][channel][row]`.
pub type Predictions = Vec<Vec<Vec<f64>>>;

/// Predicts every recording of a dataset at parameter values.
pub fn predictions(model: &Model, values: &DVector<f64>, data: &Dataset) -> Predictions {
    predictions_by_recording(model, &|_| values, data)
}

/// Predicted signals of all recordings, with values of the parameters for each recording by its number.
pub fn predictions_by_recording<'v>(
    model: &Model,
    values: &dyn Fn(usize) -> &'v DVector<f64>,
    data: &Dataset,
) -> Predictions {
    let recordings = data.recordings.iter().enumerate();
    let of = |(k, recording): (usize, &Prepared)| predict(model, values(k), recording);
    recordings.map(of).collect()
}

/// Figures of all active channels.
pub fn figures(
    model: &Model,
    values: &DVector<f64>,
    data: &Dataset,
    predictions: &Predictions,
) -> Vec<JointFigures> {
    let values = ValuesByRecording {
        training: values,
        own: &|_| values,
    };
    figures_by_recording(model, values, data, predictions)
}

/// Values of the parameters where recordings have some of their own.
#[derive(Clone, Copy)]
pub struct ValuesByRecording<'a, 'v> {
    /// Those of the training recordings.
    pub training: &'a DVector<f64>,
    /// Those of each recording by its number.
    pub own: &'a dyn Fn(usize) -> &'v DVector<f64>,
}

/// Figures of all active channels, with values of the parameters for each recording.
pub fn figures_by_recording(
    model: &Model,
    values: ValuesByRecording<'_, '_>,
    data: &Dataset,
    predictions: &Predictions,
) -> Vec<JointFigures> {
    let recordings = data.recordings.iter().enumerate();
    let raw: Vec<Vec<Vec<f64>>> = recordings
        .map(|(k, r)| signals(model, (values.own)(k), r.whole()))
        .collect();
    let held_out = data.of(Split::Validation).next().is_some();
    let noise = noise_rms(model, values.training, data);
    let mut out = Vec::new();
    for (c, channel) in model.channels().iter().enumerate() {
        if !channel.active {
            continue;
        }
        let sums = |split: Split| {
            let (mut rows, mut samples) = (Sums::default(), Sums::default());
            for (k, recording) in data.recordings.iter().enumerate() {
                if recording.split == split {
                    add_rows(&mut rows, recording, &predictions[k][c], c);
                    add_raw(&mut samples, recording, &raw[k][c], c);
                }
            }
            (rows, samples)
        };
        let (train, train_raw) = sums(Split::Train);
        let validation = held_out.then(|| sums(Split::Validation));
        let judged = validation.map_or(train.rmse(), |(rows, _)| rows.rmse());
        let level = noise.as_ref().map(|noise| noise[c]);
        let relative = |s: &Sums| (s.squares / s.signal).sqrt();
        out.push(JointFigures {
            joint: channel.name.clone(),
            unit: channel.unit.to_string(),
            rmse_train: train.rmse(),
            rmse_validation: validation.map(|(rows, _)| rows.rmse()),
            rmse_train_raw: train_raw.rmse(),
            rmse_validation_raw: validation.map(|(_, samples)| samples.rmse()),
            mae_train: train.absolute / train.rows,
            mae_validation: validation.map(|(rows, _)| rows.absolute / rows.rows),
            relative_train: relative(&train),
            relative_validation: validation.map(|(rows, _)| relative(&rows)),
            noise_rms: level,
            lack_of_fit: level.map(|level| (judged / level).powi(2)),
        });
    }
    out
}

fn add_rows(sums: &mut Sums, recording: &Prepared, predicted: &[f64], channel: usize) {
    let recorded = recording.signal(channel);
    for row in recording.counting_for(channel) {
        sums.add(predicted[row], recorded[row]);
    }
}

/// Adds every recorded sample, unfiltered, against the prediction at its time.
fn add_raw(sums: &mut Sums, recording: &Prepared, predicted: &[f64], channel: usize) {
    let raw = &recording.experiment.raw;
    for (k, recorded) in raw.signal[channel].iter().enumerate() {
        if raw.mask.as_ref().is_some_and(|mask| !mask[k]) {
            continue;
        }
        sums.add(predicted[raw.row_of(k)], *recorded);
    }
}

/// Standard deviation of one row per channel that the scatter between periods gives, or where nothing repeats the
/// differences of successive samples, over the recordings
/// that the figures judge; the noise of the motion is carried through the model, friction near
/// reversals included:
/// `σ² = σ_s² + Σ_x ∂s/∂x Cov(x) (∂s/∂x)ᵀ`, x the positions, the velocities and the accelerations of all joints.
pub fn noise_rms(model: &Model, values: &DVector<f64>, data: &Dataset) -> Option<Vec<f64>> {
    let mut sum = vec![0.0; model.channels().len()];
    let mut rows = 0.0;
    for recording in judged(data) {
        let signal = signal_variances(model, recording)?;
        let motion = motion_variance(model, values, recording);
        for (c, total) in sum.iter_mut().enumerate() {
            let variance = signal[c] + motion[c];
            *total += variance * recording.rows() as f64;
        }
        rows += recording.rows() as f64;
    }
    (rows > 0.0).then(|| sum.iter().map(|total| (total / rows).sqrt()).collect())
}

/// The recordings that the figures judge: those held out, where there are any.
fn judged(data: &Dataset) -> impl Iterator<Item = &Prepared> {
    let split = match data.of(Split::Validation).next() {
        Some(_) => Split::Validation,
        None => Split::Train,
    };
    data.of(split)
}

/// Whether the recordings that the figures judge tell the noise of every active channel.
pub fn tells_noise(model: &Model, data: &Dataset) -> bool {
    judged(data).all(|recording| signal_variances(model, recording).is_some())
}

/// Variance of the noise of one row of every channel: the scatter of periods, or where nothing repeats the noise
/// of samples that is seen to be white; `None` where neither tells it of every active channel.
fn signal_variances(model: &Model, recording: &Prepared) -> Option<Vec<f64>> {
    let experiment = &recording.experiment;
    if let Some(noise) = &experiment.noise {
        return Some(noise.signal_covariance.diagonal().iter().copied().collect());
    }
    let channels = model.channels().iter().enumerate();
    let of = |(c, channel): (usize, &Channel)| match channel.active {
        true => experiment.white_noise.get(c).copied().flatten(),
        false => Some(0.0),
    };
    let deviations: Option<Vec<f64>> = channels.map(of).collect();
    Some(deviations?.into_iter().map(|d| d * d).collect())
}

/// Mean variance per channel that the errors of the motion cause: of every row, half the difference of the signals
/// with each independent part of the errors of positions, velocities and accelerations added and taken away.
fn motion_variance(model: &Model, values: &DVector<f64>, recording: &Prepared) -> Vec<f64> {
    let mut out = vec![0.0; model.channels().len()];
    let Some(error) = &recording.experiment.motion_error else {
        return out;
    };
    let segment = recording.segment();
    let motors = segment.motors;
    for (order, errors) in error.orders().into_iter().enumerate() {
        for part in errors.root().column_iter().filter(|part| part.amax() > 0.0) {
            let signal = |sign: f64| {
                let mut moved = [motors.q.to_vec(), motors.dq.to_vec(), motors.ddq.to_vec()];
                for (series, deviation) in moved[order].iter_mut().zip(&part) {
                    series.iter_mut().for_each(|x| *x += sign * deviation);
                }
                let [q, dq, ddq] = &moved;
                let motors = Trajectory { q, dq, ddq };
                signals(model, values, Segment { motors, ..segment })
            };
            let (ahead, behind) = (signal(1.0), signal(-1.0));
            for (c, total) in out.iter_mut().enumerate() {
                let pairs = ahead[c].iter().zip(&behind[c]);
                let squares: f64 = pairs.map(|(a, b)| (0.5 * (a - b)).powi(2)).sum();
                *total += squares / recording.rows().max(1) as f64;
            }
        }
    }
    out
}

/// Signals of the chain along a motion, `[channel][row]`.
fn signals(model: &Model, values: &DVector<f64>, segment: Segment<'_>) -> Vec<Vec<f64>> {
    let rows = segment.motors.len();
    let channels = model.channels().len();
    if model.memory() == Memory::WholeMotion {
        let mut evaluator = Evaluator::along(model, values, &[], rows);
        let block = evaluator.evaluate_whole(segment);
        return (0..channels).map(|c| block.value(c).to_vec()).collect();
    }
    let mut evaluator = Evaluator::new(model, values, &[]);
    let mut signals = vec![Vec::with_capacity(rows); channels];
    for start in (0..rows).step_by(BLOCK) {
        let block = evaluator.evaluate(segment, start..rows.min(start + BLOCK));
        for (c, series) in signals.iter_mut().enumerate() {
            series.extend_from_slice(block.value(c));
        }
    }
    signals
}
