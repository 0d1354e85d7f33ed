//! How well the constants predict the currents of the steady parts.

use crate::motors::constants::Part;
use crate::motors::joint_fit::{JointFit, Steady};
use crate::outcome::joint::JointFigures;
use crate::recording::split::Split;

/// Recorded and predicted currents of one recording, its steady parts only.
#[derive(Debug)]
pub struct Predicted {
    /// Name of the recording.
    pub recording: String,
    /// Whether it was fitted or held out.
    pub split: Split,
    /// Of the rows of its steady parts, s.
    pub t: Vec<f64>,
    /// For each joint recorded, then predicted, A; NaN where the joint stands.
    pub columns: Vec<Vec<f64>>,
}

/// Current of each sample by the constants of the joint; by the first stage where the speeds do not tell
/// the friction terms apart.
fn predict(joint: &JointFit, part: &Part) -> Vec<f64> {
    let inverse = joint.constant.inverse().value;
    let speeds = &joint.stage.speeds;
    let nearest = speeds.iter().min_by(|a, b| {
        (a.speed - part.speed)
            .abs()
            .total_cmp(&(b.speed - part.speed).abs())
    });
    let friction = match (&joint.friction, nearest) {
        (Some(friction), _) => friction.current(part.speed),
        (None, Some(at)) => at.sums.current - inverse * at.sums.torque,
        (None, None) => f64::NAN,
    };
    part.torque.iter().map(|g| inverse * g + friction).collect()
}

/// Errors by joint, of every recorded sample of the steady parts.
pub(super) fn joints(joints: &[JointFit], recordings: &[Steady]) -> Vec<JointFigures> {
    let moved = joints.iter().filter(|joint| !joint.parts.is_empty());
    moved
        .map(|joint| {
            let errors = |split| Errors::of(joint, recordings, split);
            let (train, validation) = (errors(Split::Train), errors(Split::Validation));
            let held_out = |value: f64| (validation.count > 0.0).then_some(value);
            JointFigures {
                joint: joint.name.clone(),
                unit: "A".into(),
                rmse_train: train.rmse(),
                rmse_validation: held_out(validation.rmse()),
                rmse_train_raw: train.rmse(),
                rmse_validation_raw: held_out(validation.rmse()),
                mae_train: train.absolute / train.count,
                mae_validation: held_out(validation.absolute / validation.count),
                relative_train: (train.squared / train.signal).sqrt(),
                relative_validation: held_out((validation.squared / validation.signal).sqrt()),
                noise_rms: None,
                lack_of_fit: None,
            }
        })
        .collect()
}

#[derive(Default)]
struct Errors {
    count: f64,
    squared: f64,
    absolute: f64,
    signal: f64,
}

impl Errors {
    fn of(joint: &JointFit, recordings: &[Steady], split: Split) -> Self {
        let mut errors = Self::default();
        for recording in recordings.iter().filter(|r| r.split == split) {
            for (segment, part) in recording.segments.iter().zip(&recording.parts) {
                if segment.joint != joint.index {
                    continue;
                }
                for (predicted, recorded) in predict(joint, part).iter().zip(&part.current) {
                    let error = predicted - recorded;
                    errors.count += 1.0;
                    errors.squared += error * error;
                    errors.absolute += error.abs();
                    errors.signal += recorded * recorded;
                }
            }
        }
        errors
    }

    fn rmse(&self) -> f64 {
        (self.squared / self.count).sqrt()
    }
}

/// The steady parts of every recording, beside what the constants predict.
pub(super) fn predictions(joints: &[JointFit], recordings: &[Steady]) -> Vec<Predicted> {
    let of_recording = |recording: &Steady| {
        let mut predicted = Predicted {
            recording: recording.name.clone(),
            split: recording.split,
            t: Vec::new(),
            columns: vec![Vec::new(); 2 * joints.len()],
        };
        for (segment, part) in recording.segments.iter().zip(&recording.parts) {
            predicted.t.extend(&recording.time[segment.samples.clone()]);
            let absent = vec![f64::NAN; part.current.len()];
            for (column, joint) in joints.iter().enumerate() {
                let [recorded, found] = match joint.index == segment.joint {
                    true => [part.current.clone(), predict(joint, part)],
                    false => [absent.clone(), absent.clone()],
                };
                predicted.columns[2 * column].extend(recorded);
                predicted.columns[2 * column + 1].extend(found);
            }
        }
        predicted
    };
    recordings.iter().map(of_recording).collect()
}
