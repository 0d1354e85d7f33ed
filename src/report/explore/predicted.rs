//! Recordings of a fit or a diagnosis: signals, what models give, and what is left over time, over the motion and over frequency.

use crate::outcome::Outcome;
use crate::outcome::machine::MachineJoint;
use crate::outcome::predictions::{Predictions, Quantity, RecordingPredictions};
use crate::outcome::skeleton::Skeleton;
use crate::recording::split::Split;
use crate::report::explore::encoded::{Quantised, floats};
use crate::report::explore::law;
use crate::report::explore::parts::{
    Channel, Cloud, Density, Line, RECORDINGS, Spectra, Take, Variable,
};
use crate::report::explore::posture::Postures;
use crate::report::explore::spectrum::{Spectrum, rate_hz};
use crate::report::explore::thinned::{Thinning, every_nth};
use crate::robot::tree::JointKind;

/// Points of all lines of a page together: at four thirds of two bytes each about 1.2 MB.
const POINTS: usize = 450_000;

/// Points of a line at least, whatever the number of lines: two for every third pixel of a wide screen.
const LEAST_POINTS: usize = 1200;

/// Points of a cloud: more would only cover each other.
const CLOUD: usize = 700;

/// Every recording, those that were held out first.
pub(super) fn takes(outcome: &Outcome, predictions: &Predictions) -> Vec<Take> {
    let mut recordings: Vec<&RecordingPredictions> = predictions.recordings.iter().collect();
    recordings.sort_by_key(|recording| recording.split == Split::Train);
    recordings.truncate(RECORDINGS);
    let lines = recordings.len() * (predictions.columns.len() + 2 * joints(predictions).len());
    let points = (POINTS / lines.max(1)).max(LEAST_POINTS);
    recordings
        .into_iter()
        .filter(|recording| !recording.t.is_empty())
        .map(|recording| {
            let view = View {
                outcome,
                predictions,
                recording,
                thinning: Thinning::new(recording.t.len(), points),
            };
            view.take()
        })
        .collect()
}

/// Joints in the order of the table.
fn joints(predictions: &Predictions) -> Vec<&str> {
    let columns = predictions.columns.iter();
    columns
        .filter(|column| column.quantity == Quantity::Recorded)
        .map(|column| column.joint.as_str())
        .collect()
}

/// A recording within its table.
struct View<'a> {
    outcome: &'a Outcome,
    predictions: &'a Predictions,
    recording: &'a RecordingPredictions,
    thinning: Thinning,
}

/// A model's prediction, and what a page calls it.
struct Model<'a> {
    role: &'static str,
    y: &'a [f64],
    /// Recorded minus predicted.
    lacks: Vec<f64>,
}

impl<'a> View<'a> {
    fn take(&self) -> Take {
        let t = &self.recording.t;
        let start = t[0];
        let kind = match self.recording.split {
            Split::Train => "training",
            Split::Validation => "held out",
        };
        let names = joints(self.predictions);
        Take {
            name: self.recording.recording.clone(),
            kind: kind.to_string(),
            start,
            t: floats(self.thinning.times(t).into_iter().map(|t| t - start)),
            channels: names
                .iter()
                .filter_map(|joint| self.channel(joint))
                .collect(),
            postures: self.postures(),
        }
    }

    fn column(&self, joint: &str, quantity: Quantity) -> Option<&'a [f64]> {
        let column = self.predictions.column(joint, quantity)?;
        Some(&self.recording.values[column])
    }

    fn models(&self, joint: &str) -> Vec<Model<'a>> {
        let recorded = self.column(joint, Quantity::Recorded).unwrap_or_default();
        let roles = [
            ("declared", Quantity::Baseline),
            ("predicted", Quantity::Predicted),
            ("final", Quantity::Final),
        ];
        roles
            .into_iter()
            .filter_map(|(role, quantity)| {
                let y = self.column(joint, quantity)?;
                let lacks = recorded.iter().zip(y).map(|(r, p)| r - p).collect();
                Some(Model { role, y, lacks })
            })
            .collect()
    }

    /// `None` of a joint without samples, such as one that rests.
    fn channel(&self, joint: &str) -> Option<Channel> {
        let recorded = self.column(joint, Quantity::Recorded)?;
        recorded.iter().find(|value| value.is_finite())?;
        let unit = self.unit(joint);
        let models = self.models(joint);
        let line = |panel, role, unit: &str, y: &[f64]| Line {
            panel,
            role,
            unit: unit.to_string(),
            y: Quantised::of(&self.thinning.line(y)),
            levels: Vec::new(),
        };
        let mut lines = vec![line("signal", "recorded", &unit, recorded)];
        lines.extend(models.iter().map(|m| line("signal", m.role, &unit, m.y)));
        lines.extend(models.iter().map(|m| {
            let residual: Vec<f64> = m.lacks.iter().map(|lack| -lack).collect();
            line("residual", m.role, &unit, &residual)
        }));
        let position = self.position_unit(joint);
        for (panel, quantity, unit) in [
            ("position", Quantity::Position, position.to_string()),
            ("speed", Quantity::Velocity, format!("{position}/s")),
        ] {
            let motion = self.column(joint, quantity);
            lines.extend(motion.map(|y| line(panel, "recorded", &unit, y)));
        }
        Some(Channel {
            name: joint.to_string(),
            cloud: self.cloud(joint, &models, &unit),
            spectrum: self.spectrum(recorded, &models, &unit),
            lines,
        })
    }

    fn unit(&self, joint: &str) -> String {
        let own = self
            .outcome
            .estimate
            .joints
            .iter()
            .find(|f| f.joint == joint);
        own.map(|figures| figures.unit.clone()).unwrap_or_default()
    }

    fn position_unit(&self, joint: &str) -> &'static str {
        self.machine_joint(joint)
            .map_or("rad", |joint| JointKind::from(joint.motion).position_unit())
    }

    fn machine_joint(&self, name: &str) -> Option<&'a MachineJoint> {
        let machine = self.outcome.machine()?;
        machine.joints.iter().find(|joint| joint.name == name)
    }

    /// What is left at single samples, over speed, position and the signal itself.
    fn cloud(&self, joint: &str, models: &[Model], unit: &str) -> Option<Cloud> {
        let last = models.last()?;
        let rows: Vec<usize> = every_nth(self.recording.t.len(), CLOUD).collect();
        let at = |y: &[f64]| Quantised::of(&rows.iter().map(|&row| y[row]).collect::<Vec<f64>>());
        let position = self.position_unit(joint);
        let mut over = Vec::new();
        for (name, quantity, unit) in [
            ("speed", Quantity::Velocity, format!("{position}/s")),
            ("position", Quantity::Position, position.to_string()),
        ] {
            let values = self.column(joint, quantity).map(&at);
            over.extend(values.map(|values| Variable { name, unit, values }));
        }
        over.push(Variable {
            name: "load",
            unit: unit.to_string(),
            values: at(last.y),
        });
        let mut of: Vec<Variable> = models
            .iter()
            .map(|model| Variable {
                name: model.role,
                unit: unit.to_string(),
                values: at(&model.lacks),
            })
            .collect();
        if let [declared, last] = models {
            let added: Vec<f64> = last.y.iter().zip(declared.y).map(|(a, b)| a - b).collect();
            of.push(Variable {
                name: "added",
                unit: unit.to_string(),
                values: at(&added),
            });
        }
        let law = self.column(joint, Quantity::Velocity).and_then(|speed| {
            let speeds: Vec<f64> = rows.iter().map(|&row| speed[row]).collect();
            law::over_speed(self.machine_joint(joint)?, &speeds)
        });
        of.extend(law.map(|torque| Variable {
            name: "friction",
            unit: unit.to_string(),
            values: Quantised::of(&torque),
        }));
        Some(Cloud {
            over,
            of,
            unit: unit.to_string(),
        })
    }

    fn spectrum(&self, recorded: &[f64], models: &[Model], unit: &str) -> Option<Spectra> {
        let t = &self.recording.t;
        let spectrum = Spectrum::new(rate_hz(t)?, t.len());
        let mut lines = vec![("recorded", spectrum.density(recorded))];
        lines.extend(models.iter().map(|m| (m.role, spectrum.density(&m.lacks))));
        let lines = lines.into_iter().filter(|(_, density)| !density.is_empty());
        let lines: Vec<Density> = lines
            .map(|(role, density)| Density {
                role,
                y: floats(density.into_iter()),
            })
            .collect();
        (!lines.is_empty()).then(|| Spectra {
            f: floats(spectrum.frequencies().into_iter()),
            unit: format!("{unit}/√Hz"),
            lines,
        })
    }

    /// Joint positions q = V m + offset from those of the motors, which the table has.
    fn postures(&self) -> Option<Postures> {
        let machine = self.outcome.machine()?;
        let skeleton = Skeleton::from(machine);
        let motor = |j: usize| self.column(&machine.joints[j].name, Quantity::Position);
        let series = |j: usize| -> Option<Vec<f64>> {
            let offset = machine.joints[j].offset;
            let own = motor(j)?;
            let Some(coupling) = &machine.coupling else {
                return Some(own.iter().map(|m| m + offset).collect());
            };
            let mut q = vec![offset; own.len()];
            for (i, factor) in coupling[j].iter().enumerate().filter(|(_, f)| **f != 0.0) {
                let moves = match motor(i) {
                    Some(moves) => moves,
                    // A joint that stands still has no column.
                    None if machine.joints[i].locked.is_some() => continue,
                    None => return None,
                };
                for (q, m) in q.iter_mut().zip(moves) {
                    *q += factor * m;
                }
            }
            Some(q)
        };
        let all: Vec<(&str, Option<Vec<f64>>)> = (0..machine.joints.len())
            .map(|j| (machine.joints[j].name.as_str(), series(j)))
            .collect();
        Postures::new(&skeleton, &self.recording.t, |name| {
            let (_, series) = all.iter().find(|(joint, _)| *joint == name)?;
            series.as_deref()
        })
    }
}
