//! How well a model predicts recordings, channel by channel, and how much of the error is noise.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::evaluate::{BLOCK, Evaluator, bodies};
use crate::chain::model::{Model, Signal};
use crate::estimate::noise::predict;
use crate::outcome::joint::JointFigures;
use crate::recording::split::Split;
use crate::robot::derivatives::Derivatives;
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
    let of = |recording: &Prepared| predict(model, values, recording);
    data.recordings.iter().map(of).collect()
}

/// Figures of all active channels.
pub fn figures(
    model: &Model,
    values: &DVector<f64>,
    (data, predictions): (&Dataset, &Predictions),
) -> Vec<JointFigures> {
    let raw: Vec<Vec<Vec<f64>>> = data
        .recordings
        .iter()
        .map(|r| whole(model, values, r))
        .collect();
    let held_out = data.of(Split::Validation).next().is_some();
    let noise = noise_rms(model, values, data);
    let mut out = Vec::new();
    for (c, channel) in model.channels().iter().enumerate() {
        if !channel.active {
            continue;
        }
        let sums = |split: Split| {
            let (mut rows, mut samples) = (Sums::default(), Sums::default());
            for (k, recording) in data.recordings.iter().enumerate() {
                if recording.split == split {
                    add_rows(&mut rows, recording, (&predictions[k][c], c));
                    add_raw(&mut samples, recording, (&raw[k][c], c));
                }
            }
            (rows, samples)
        };
        let (train, train_raw) = sums(Split::Train);
        let validation = held_out.then(|| sums(Split::Validation));
        let judged = validation.map_or(train.rmse(), |(rows, _)| rows.rmse());
        let floor = noise.as_ref().map(|noise| noise[c]);
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
            noise_rms: floor,
            lack_of_fit: floor.map(|floor| (judged / floor).powi(2)),
        });
    }
    out
}

fn add_rows(sums: &mut Sums, recording: &Prepared, (predicted, channel): (&[f64], usize)) {
    let recorded = recording.signal(channel);
    for row in (0..recording.rows()).filter(|&row| recording.counts(row)) {
        sums.add(predicted[row], recorded[row]);
    }
}

/// Prediction at every row of the experiment, without the filter over signal and model.
fn whole(model: &Model, values: &DVector<f64>, recording: &Prepared) -> Vec<Vec<f64>> {
    let rows = recording.experiment.rows();
    let mut out = vec![Vec::with_capacity(rows); model.channels().len()];
    let mut evaluator = Evaluator::new(model, values, &[]);
    for start in (0..rows).step_by(BLOCK) {
        let range = start..rows.min(start + BLOCK);
        let block = evaluator.evaluate(recording.whole(), range);
        for (c, series) in out.iter_mut().enumerate() {
            series.extend_from_slice(block.value(c));
        }
    }
    out
}

/// Adds every recorded sample, unfiltered, against the prediction at its time.
fn add_raw(sums: &mut Sums, recording: &Prepared, (predicted, channel): (&[f64], usize)) {
    let raw = &recording.experiment.raw;
    for (k, recorded) in raw.signal[channel].iter().enumerate() {
        if raw.mask.as_ref().is_some_and(|mask| !mask[k]) {
            continue;
        }
        let at = raw.locate(k);
        let value = (1.0 - at.weight) * predicted[at.before] + at.weight * predicted[at.after];
        sums.add(value, *recorded);
    }
}

/// Every so many rows the derivatives of the model are taken for the noise of the motion.
const DERIVATIVE_STRIDE: usize = 7;

/// Standard deviation of one row per channel that the scatter between periods gives, over the recordings
/// that the figures judge; the motion's own error is carried through the model:
/// `σ² = σ_s² + Σ_j (∂s/∂q_j)² σ²_{q,j} + (∂s/∂q̇_j)² σ²_{q̇,j} + (∂s/∂q̈_j)² σ²_{q̈,j}`.
pub fn noise_rms(model: &Model, values: &DVector<f64>, data: &Dataset) -> Option<Vec<f64>> {
    let split = match data.of(Split::Validation).next() {
        Some(_) => Split::Validation,
        None => Split::Train,
    };
    let mut sum = vec![0.0; model.channels().len()];
    let mut rows = 0.0;
    for recording in data.of(split) {
        let noise = recording.experiment.noise.as_ref()?;
        let motion = motion_variance(model, values, recording);
        for (c, total) in sum.iter_mut().enumerate() {
            let variance = noise.signal_covariance[(c, c)] + motion[c];
            *total += variance * recording.rows() as f64;
        }
        rows += recording.rows() as f64;
    }
    (rows > 0.0).then(|| sum.iter().map(|total| (total / rows).sqrt()).collect())
}

/// Mean variance per channel that the noise of the motion causes.
fn motion_variance(model: &Model, values: &DVector<f64>, recording: &Prepared) -> Vec<f64> {
    let channels = model.channels();
    let mut out = vec![0.0; channels.len()];
    let Some(noise) = &recording.experiment.noise else {
        return out;
    };
    let n = model.tree().len();
    let parameters = bodies(model, values, recording.loaded);
    let coupling = model.coupling(values);
    let mut derivatives = Derivatives::new(model.tree());
    let motors = recording.segment().motors;
    let rows: Vec<usize> = (0..recording.rows()).step_by(DERIVATIVE_STRIDE).collect();
    for &row in &rows {
        let at = |series: &[Vec<f64>]| DVector::from_fn(n, |j, _| series[j][row]);
        let q = &coupling * at(motors.q) + model.offset();
        let (dq, ddq) = (&coupling * at(motors.dq), &coupling * at(motors.ddq));
        let state = [q.as_slice(), dq.as_slice(), ddq.as_slice()];
        derivatives.evaluate(model.tree(), &parameters, state);
        let parts = [
            (
                &derivatives.position,
                &noise.position_sd,
                &derivatives.base[0],
            ),
            (
                &derivatives.velocity,
                &noise.velocity_sd,
                &derivatives.base[1],
            ),
            (
                &derivatives.mass,
                &noise.acceleration_sd,
                &derivatives.base[2],
            ),
        ];
        for (torque, deviation, base) in parts {
            let at_motors = coupling.tr_mul(&(torque * &coupling));
            for (c, channel) in channels.iter().enumerate() {
                for j in 0..n {
                    let slope = match channel.joint {
                        Some(i) => at_motors[(i, j)] / model.joints()[i].torque_constant,
                        None => base[(wrench_row(model, c), j)],
                    };
                    out[c] += (slope * deviation[j]).powi(2);
                }
            }
        }
    }
    out.iter().map(|v| v / rows.len().max(1) as f64).collect()
}

fn wrench_row(model: &Model, channel: usize) -> usize {
    match model.signal() {
        Signal::Both => channel - model.tree().len(),
        _ => channel,
    }
}
