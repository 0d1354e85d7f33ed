//! Summary of the forward simulations of all recordings.

use crate::chain::effect::{Effect, Lasts};
use crate::chain::forward;
use crate::chain::forward::Accuracy;
use crate::chain::model::Signal;
use crate::chain::words::{count, short};
use crate::outcome::Part;
use crate::outcome::rollout::{
    ErrorCurve, HeldOutRows, Horizon, Integrator, JointErrors, RolledRecording, Rollout, Spread,
};
use crate::outcome::skeleton::Skeleton;
use crate::rollout::candidate::Candidates;
use crate::rollout::error::RolloutError;
use crate::rollout::error_statistics::spread;
use crate::rollout::model_run::{MovingJoint, Track};
use crate::rollout::simulated_windows::{HORIZONS, Named, SimulatedWindows};
use crate::rollout::task::{RolloutRun, Task};
use crate::rollout::window::Window;
use crate::stats::robust::median;

/// Instants of the curves of errors.
pub(super) const CURVE_POINTS: usize = 24;

/// An integration error of more than this share of the error of the model is said.
pub(super) const MATTERS: f64 = 0.1;

/// What the windows of all recordings say.
pub(super) struct Summary<'a> {
    pub(super) task: Task<'a>,
    pub(super) candidates: &'a Candidates,
    pub(super) held_out: HeldOutRows,
    pub(super) rolled: &'a [SimulatedWindows<'a>],
}

impl Summary<'_> {
    pub(super) fn run(&self) -> Result<RolloutRun, RolloutError> {
        let joints = self.joints();
        let horizons = self.horizons(&joints);
        let examples = self.examples(&joints, &horizons)?;
        let rollout = Rollout {
            source: self.task.source.to_string(),
            set: self.task.set.to_vec(),
            source_verb: self.task.outcome.part.verb().to_string(),
            before: self.candidates.before.as_ref().map(|(kind, _)| *kind),
            held_out: self.held_out,
            summary: self.paragraph(&horizons),
            curves: self.curves(&joints, &horizons),
            recordings: self.recordings(),
            examples: examples.iter().map(Window::thinned).collect(),
            integrator: Integrator {
                name: "ROS2, M and h at the middle of each step".to_string(),
                step: Accuracy::default().step,
                checked: self.rolled.iter().map(|r| r.halved.len()).sum(),
            },
            notes: self.notes(&horizons),
            skeleton: self.task.outcome.machine().map(Skeleton::from),
            horizons,
        };
        Ok(RolloutRun { rollout, examples })
    }

    /// Names and units of the joints that move.
    pub(super) fn joints(&self) -> Vec<Named> {
        let all = self.candidates.after.model.joints().iter();
        all.filter(|joint| !joint.locked)
            .map(|joint| Named {
                name: joint.name.clone(),
                unit: joint.kind.position_unit(),
            })
            .collect()
    }

    /// Errors of a joint at a time after the start, of the windows that reach it.
    pub(super) fn errors<'t>(
        &'t self,
        tracks: impl Fn(&'t SimulatedWindows<'t>) -> &'t [Track],
        time: f64,
        joint: MovingJoint,
    ) -> Vec<f64> {
        let mut errors = Vec::new();
        for rolled in self.rolled {
            let row = rolled.row(time);
            let windows = rolled.starts.lengths.iter().zip(tracks(rolled));
            let reach = windows.filter(|(length, _)| **length >= row);
            errors.extend(reach.map(|(_, track)| track.error(row, joint)));
        }
        errors
    }

    pub(super) fn before<'t>(&'t self, time: f64, joint: MovingJoint) -> Option<Spread> {
        self.candidates.before.as_ref()?;
        let tracks = |r: &'t SimulatedWindows<'t>| r.before.as_deref().unwrap_or(&[]);
        Some(spread(&self.errors(tracks, time, joint)))
    }

    pub(super) fn horizons(&self, joints: &[Named]) -> Vec<Horizon> {
        let reached = HORIZONS.iter().filter(|time| {
            let reaches =
                |r: &SimulatedWindows<'_>| r.starts.lengths.iter().any(|l| *l >= r.row(**time));
            self.rolled.iter().any(reaches)
        });
        let at = |&horizon: &f64| {
            let count = joints.len();
            let of = |(index, named): (usize, &Named)| JointErrors {
                joint: named.name.clone(),
                unit: named.unit.to_string(),
                before: self.before(horizon, MovingJoint { index, count }),
                after: spread(&self.errors(|r| &r.after, horizon, MovingJoint { index, count })),
                noise: spread(&self.errors(|r| &r.noise, horizon, MovingJoint { index, count })),
                integration: self.integration(horizon, MovingJoint { index, count }),
            };
            Horizon {
                horizon,
                joints: joints.iter().enumerate().map(of).collect(),
            }
        };
        reached.map(at).collect()
    }

    /// RMS change of a position by half of the steps.
    pub(super) fn integration(&self, time: f64, joint: MovingJoint) -> f64 {
        let mut changes = Vec::new();
        for rolled in self.rolled {
            let row = rolled.row(time);
            let reach = |k: usize| rolled.starts.lengths[k] >= row;
            let halved = rolled.halved.iter().filter(|(k, _)| reach(*k));
            changes
                .extend(halved.map(|(k, track)| {
                    track.error(row, joint) - rolled.after[*k].error(row, joint)
                }));
        }
        spread(&changes).rms.unwrap_or(f64::NAN)
    }

    pub(super) fn curves(&self, joints: &[Named], horizons: &[Horizon]) -> Vec<ErrorCurve> {
        let longest = horizons.last().map_or(0.0, |h| h.horizon);
        let times = (0..=CURVE_POINTS).map(|k| longest * k as f64 / CURVE_POINTS as f64);
        let times: Vec<f64> = times.collect();
        let of = |(k, named): (usize, &Named)| {
            let joint = MovingJoint {
                index: k,
                count: joints.len(),
            };
            let along = |of: &dyn Fn(f64) -> Spread| times.iter().map(|t| of(*t)).collect();
            ErrorCurve {
                joint: named.name.clone(),
                unit: named.unit.to_string(),
                t: times.clone(),
                before: times
                    .iter()
                    .filter_map(|t| self.before(*t, joint))
                    .collect(),
                after: along(&|t| spread(&self.errors(|r| &r.after, t, joint))),
                noise: along(&|t| spread(&self.errors(|r| &r.noise, t, joint))),
            }
        };
        joints.iter().enumerate().map(of).collect()
    }

    pub(super) fn recordings(&self) -> Vec<RolledRecording> {
        let of = |rolled: &SimulatedWindows<'_>| RolledRecording {
            recording: rolled.recording.name.clone(),
            windows: rolled.starts.rows.len(),
            every: rolled.starts.every,
        };
        self.rolled.iter().map(of).collect()
    }

    /// The windows in the middle and at the end of all, by their largest error at the longest horizon in units of the joints' RMS.
    pub(super) fn examples(
        &self,
        joints: &[Named],
        horizons: &[Horizon],
    ) -> Result<Vec<Window>, RolloutError> {
        let Some(last) = horizons.last() else {
            return Ok(Vec::new());
        };
        let scale: Vec<f64> = last
            .joints
            .iter()
            .map(|joint| joint.after.rms.filter(|rms| *rms > 0.0).unwrap_or(1.0))
            .collect();
        let mut scored: Vec<(f64, usize, usize)> = Vec::new();
        for (r, rolled) in self.rolled.iter().enumerate() {
            let row = rolled.row(last.horizon);
            for (k, length) in rolled.starts.lengths.iter().enumerate() {
                if *length < row {
                    continue;
                }
                let sizes = (0..joints.len()).map(|j| {
                    let joint = MovingJoint {
                        index: j,
                        count: joints.len(),
                    };
                    let error = rolled.after[k].error(row, joint).abs() / scale[j];
                    if error.is_nan() { f64::INFINITY } else { error }
                });
                scored.push((sizes.fold(0.0, f64::max), r, k));
            }
        }
        scored.sort_by(|a, b| a.0.total_cmp(&b.0));
        let Some(worst) = scored.len().checked_sub(1) else {
            return Ok(Vec::new());
        };
        let chosen = [("median", worst / 2), ("worst", worst)];
        let of = |(kind, at): (&'static str, usize)| {
            let (_, r, k) = scored[at];
            self.rolled[r].window(kind, k, last.horizon, joints)
        };
        Ok(chosen.into_iter().map(of).collect::<Result<_, _>>()?)
    }

    /// In plain words, at half a second or what is nearest to it.
    pub(super) fn paragraph(&self, horizons: &[Horizon]) -> String {
        let middle = horizons.iter().rfind(|h| h.horizon <= 0.5);
        let Some(horizon) = middle else {
            return String::new();
        };
        let mut ratios = Vec::new();
        let mut of_noise = Vec::new();
        for joint in &horizon.joints {
            let after = joint.after.median.unwrap_or(f64::INFINITY);
            if let Some(before) = joint.before {
                ratios.push(after / before.median.unwrap_or(f64::INFINITY));
            }
            of_noise.push(after / joint.noise.median.unwrap_or(f64::INFINITY));
        }
        let middle = |values: &[f64]| median(values).filter(|x| x.is_finite());
        let windows = self
            .rolled
            .iter()
            .map(|r| r.starts.rows.len())
            .sum::<usize>();
        let mut text = format!(
            "Simulated forward under the recorded {} from {} in {}: after {} s the final model's error of position",
            match self.candidates.after.model.signal() {
                Signal::PositionCommand => "commands, with the controllers in the loop,",
                _ => "torques",
            },
            count(windows, "start"),
            self.held_out.words(),
            horizon.horizon
        );
        match (self.candidates.before.as_ref(), middle(&ratios)) {
            (Some((kind, _)), Some(ratio)) => {
                let words = kind.words();
                text.push_str(&format!(" is {} times that of {words}", short(ratio)));
            }
            (Some(_), None) => text.push_str(" cannot be told as a share of that before"),
            (None, _) => {}
        }
        if let Some(ratio) = middle(&of_noise) {
            let joint = if ratios.is_empty() { " is" } else { ", and" };
            text.push_str(&format!(
                "{joint} {} times what the noise alone would make of a model that is right",
                short(ratio)
            ));
        }
        text.push_str(" (medians over windows, median of the joints).");
        text
    }

    pub(super) fn notes(&self, horizons: &[Horizon]) -> Vec<String> {
        let mut notes = Vec::new();
        let lost = |of: &dyn Fn(&JointErrors) -> usize| {
            let all = horizons.iter().flat_map(|h| &h.joints);
            all.map(of).max().unwrap_or(0)
        };
        let (after, before) = (
            lost(&|j| j.after.lost),
            lost(&|j| j.before.map_or(0, |b| b.lost)),
        );
        for (lost, model) in [(before, "model before"), (after, "final model")] {
            if lost > 0 {
                notes.push(format!(
                    "The {model} is lost in {}: further than half a turn (1 m for sliding joints) from the recording, or \
                     without positive inertia; they count as larger than any error in medians and quartiles, and not at all \
                     in the RMS.",
                    count(lost, "window")
                ));
            }
        }
        if self.candidates.before.is_none() {
            notes.push(
                "The files do not give every parameter a value, so that there is no model before the fit to compare with."
                    .to_string(),
            );
        }
        if self.rolled.iter().any(|r| !r.measured) {
            notes.push(
                "The recordings do not show the noise of their signals, so that what the final model leaves of them counts as \
                 noise; misfit is part of it."
                    .to_string(),
            );
        }
        if self.rolled.iter().any(|r| !r.has_start_errors) {
            notes.push(
                "Nothing tells the errors of the estimated motion: starts under noise have none."
                    .to_string(),
            );
        }
        if let Part::Diagnose(diagnosis) = &self.task.outcome.part
            && diagnosis
                .findings
                .iter()
                .any(|finding| finding.has_no_name())
        {
            notes.push(
                "Smooth corrections without a name say nothing of other motions and are not in the final model here."
                    .to_string(),
            );
        }
        let joints = self.candidates.after.model.joints().iter();
        let mut acting: Vec<&Effect> = joints
            .flat_map(|joint| joint.effects.iter().map(|(effect, _)| *effect))
            .collect();
        acting.sort_by_key(|effect| effect.id);
        acting.dedup_by_key(|effect| effect.id);
        let listed = |is: &dyn Fn(&Effect) -> bool| {
            let found = acting.iter().filter(|effect| is(effect));
            let ids: Vec<&str> = found.map(|effect| effect.id).collect();
            (!ids.is_empty()).then(|| ids.join(", "))
        };
        let is_transient = |effect: &Effect| effect.needs.lasts == Lasts::OneRecording;
        if let Some(ids) = listed(&is_transient) {
            notes.push(format!(
                "{ids} belongs to the recording in which it was found and does not act here."
            ));
        }
        if let Some(ids) = listed(&|e| !is_transient(e) && !forward::acts(e)) {
            notes.push(format!(
                "{ids} depends on more than the motion of one joint and does not act here."
            ));
        }
        let coarse = horizons
            .iter()
            .flat_map(|h| h.joints.iter().map(move |j| (h, j)));
        let coarse =
            coarse.filter(|(_, j)| j.after.rms.is_some_and(|rms| j.integration > MATTERS * rms));
        if let Some((horizon, joint)) =
            coarse.max_by(|a, b| a.1.integration.total_cmp(&b.1.integration))
        {
            notes.push(format!(
                "Half of the steps change the position of {} after {} s by {:.2e} {}: motions there follow from torques less surely \
                 than the errors tell.",
                joint.joint, horizon.horizon, joint.integration, joint.unit
            ));
        }
        notes
    }
}
