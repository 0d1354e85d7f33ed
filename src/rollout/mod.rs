//! Forward simulation of the models of a result beside held-out recordings.
//!
//! From each of many starts along a recording, the motion under the recorded torques is integrated in open loop,
//!
//! ```text
//! e(T) = q_model(t + T) − q(t + T),    q_model(t), q̇_model(t) those of the recording, T up to 2 s
//! ```
//!
//! by the model before and after, and by the final model under its own torques with the noise of the signal, from a start
//! with the errors of the estimated motion: what the noise alone would make of a model that is right. What lags behind a
//! motor and bristles begin where they come to along the recorded motion before the start.

pub mod candidate;
pub mod course;
pub mod error;
mod noise;
pub mod spread;

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::effect::{Effect, Lasts};
use crate::chain::forward::{self, Accuracy, Forward, NotForward};
use crate::diagnose::fit::held_out;
use crate::estimate::bandwidth;
use crate::outcome::rollout::{
    ErrorCurve, Example, ExampleJoint, HeldOut, Horizon, Integrator, JointErrors, RolledRecording,
    Rollout, Spread,
};
use crate::outcome::skeleton::Skeleton;
use crate::outcome::{Outcome, Part};
use crate::problem::solution::Control;
use crate::problem_file::ProblemFile;
use crate::recording::split::Split;
use crate::rollout::candidate::{Candidate, Candidates};
use crate::rollout::course::{Course, Track, predicted};
use crate::rollout::error::RolloutError;
use crate::rollout::noise::{ChannelNoise, draw, stream};
use crate::rollout::spread::spread;
use crate::setup;
use crate::stats::range::within;
use crate::stats::robust::median;
use rayon::prelude::*;

/// Times after a start at which errors are told, s.
pub const HORIZONS: [f64; 5] = [0.1, 0.25, 0.5, 1.0, 2.0];

/// From one start to the next, s, where the recordings are long enough.
const EVERY: f64 = 0.5;

/// Windows of a recording: at least so many, from starts that are closer, as far as it has rows, and at most.
const WINDOWS: [f64; 2] = [40.0, 400.0];

/// Windows that are simulated again with every step halved.
const CHECKED: usize = 12;

/// Instants of the curves of errors.
const CURVE_POINTS: usize = 24;

/// Samples of an example that a result holds.
const EXAMPLE_POINTS: usize = 160;

/// An integration error of more than this share of the error of the model is said.
const MATTERS: f64 = 0.1;

/// Rollouts with the windows that tables are written of.
#[derive(Debug)]
pub struct RolloutRun {
    pub rollout: Rollout,
    pub examples: Vec<Window>,
}

/// A window, sample by sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Window {
    pub kind: &'static str,
    pub recording: String,
    /// s in the recording.
    pub t: Vec<f64>,
    pub joints: Vec<WindowJoint>,
}

/// Positions of one joint in a window.
#[derive(Debug, Clone, PartialEq)]
pub struct WindowJoint {
    pub joint: String,
    pub unit: &'static str,
    pub recorded: Vec<f64>,
    /// Not a number without such a model, and where it is lost.
    pub before: Vec<f64>,
    pub after: Vec<f64>,
}

/// What is rolled out.
#[derive(Debug, Clone, Copy)]
pub struct Task<'a> {
    pub problem: &'a ProblemFile,
    pub outcome: &'a Outcome,
    /// The result, as given, and overrides of its problem.
    pub source: &'a str,
    pub set: &'a [String],
    pub seed: u64,
}

/// Rolls the models of a result out; `watch` hears of every step.
///
/// # Errors
/// A result without a model; files that cannot be read; a model without forward dynamics; recordings that are too short; an
/// interrupt.
pub fn run(
    task: Task<'_>,
    control: &Control<'_>,
    watch: &dyn Fn(&str),
) -> Result<RolloutRun, RolloutError> {
    let problem = task.problem;
    let robot = setup::robot::open(problem)?;
    let candidates = Candidates::of(task.outcome, problem, &robot)?;
    watch("reading and differentiating the recordings");
    let mut declared = setup::model::build(problem, &robot)?;
    let prior = setup::prior::build(problem, &robot, &mut declared)?;
    let data = bandwidth::prepared(problem, &robot, &declared, &prior, control)?;
    let (data, held_out) = held_out_part(data, &task.outcome.part);
    watch("simulating forward");
    let rolled = data
        .recordings
        .iter()
        .enumerate()
        .map(|(number, recording)| Rolled::of(&candidates, (number, recording), task.seed, control))
        .collect::<Result<Vec<_>, _>>()?;
    let rolled: Vec<Rolled<'_>> = rolled.into_iter().flatten().collect();
    if rolled.is_empty() {
        let seconds = HORIZONS[0];
        return Err(RolloutError::NoWindow { seconds });
    }
    Summary {
        task,
        candidates: &candidates,
        held_out,
        rolled: &rolled,
    }
    .run()
}

/// The recordings of the windows.
fn held_out_part(data: Dataset, part: &Part) -> (Dataset, HeldOut) {
    let of = |data: &Dataset, split: Split| Dataset {
        recordings: data.of(split).cloned().collect(),
    };
    if data.of(Split::Validation).next().is_some() {
        return (of(&data, Split::Validation), HeldOut::Validation);
    }
    match part {
        Part::Diagnose(_) => {
            let (blocks, _) = held_out::with_held_out(data);
            (of(&blocks, Split::Validation), HeldOut::Blocks)
        }
        _ => (data, HeldOut::Train),
    }
}

/// Starts of windows of a recording, and from one to the next, s.
struct Starts {
    rows: Vec<usize>,
    every: f64,
    /// Rows of the longest window from each.
    lengths: Vec<usize>,
}

impl Starts {
    /// Windows without rows that do not count, of which the shortest fits.
    fn of(recording: &Prepared, margin: usize) -> Self {
        let experiment = &recording.experiment;
        let (count, rate) = (experiment.rows(), experiment.rate_hz);
        let counts = |row: &usize| experiment.mask.as_ref().is_none_or(|mask| mask[*row]);
        // Rows from each on that count in one go.
        let mut run = vec![0_usize; count + 1];
        for row in (0..count).rev() {
            run[row] = if counts(&row) { run[row + 1] + 1 } else { 0 };
        }
        let rows_of = |seconds: f64| (seconds * rate).round().max(1.0) as usize;
        let (shortest, longest) = (rows_of(HORIZONS[0]), rows_of(HORIZONS[HORIZONS.len() - 1]));
        let fits: f64 = run.iter().filter(|r| **r > shortest + margin).count() as f64;
        let wanted = within(fits / (EVERY * rate), WINDOWS);
        let every = (fits / wanted).round().max(1.0) as usize;
        let starts: Vec<usize> = (margin..count)
            .step_by(every)
            .filter(|row| run[*row] > shortest + margin)
            .collect();
        Self {
            lengths: starts
                .iter()
                .map(|&row| longest.min(run[row] - 1 - margin))
                .collect(),
            rows: starts,
            every: every as f64 / rate,
        }
    }
}

/// The windows of one recording.
struct Rolled<'a> {
    recording: &'a Prepared,
    starts: Starts,
    course: Course<'a>,
    before: Option<Vec<Track>>,
    after: Vec<Track>,
    noise: Vec<Track>,
    /// Windows that were simulated with every step halved.
    halved: Vec<(usize, Track)>,
    /// Whether the recording itself shows the noise of its signal.
    measured: bool,
    has_start_errors: bool,
}

impl<'a> Rolled<'a> {
    /// `None` where no window fits.
    fn of(
        candidates: &'a Candidates,
        (number, recording): (usize, &'a Prepared),
        seed: u64,
        control: &Control<'_>,
    ) -> Result<Option<Self>, RolloutError> {
        let after = &candidates.after;
        let before = candidates.before.as_ref().map(|(_, before)| before);
        let margin = margin([Some(after), before], recording)?;
        let starts = Starts::of(recording, margin);
        if starts.rows.is_empty() {
            return Ok(None);
        }
        let accuracy = Accuracy::default();
        let experiment = &recording.experiment;
        let of = |candidate: &'a Candidate, signal: &[Vec<f64>]| {
            Course::new((candidate, recording), signal, &starts.rows, accuracy)
        };
        let roll =
            |course: &Course<'a>, errors: &[[Vec<f64>; 2]]| -> Result<Vec<Track>, RolloutError> {
                let windows = 0..starts.rows.len();
                windows
                    .into_par_iter()
                    .map(|k| {
                        if control.is_interrupted() {
                            return Err(RolloutError::Interrupted);
                        }
                        let window = (k, starts.lengths[k]);
                        Ok(course.roll(window, accuracy, errors.get(k))?)
                    })
                    .collect()
            };
        let course = of(after, &experiment.signal)?;
        let rolled_after = roll(&course, &[])?;
        let rolled_before = match before {
            Some(before) => Some(roll(&of(before, &experiment.signal)?, &[])?),
            None => None,
        };
        let own = predicted(after, recording);
        let channels = after.model.joints().len();
        let mut rng = stream(seed, number, 0);
        let mut measured = true;
        let mut noisy = own.clone();
        for (channel, series) in noisy.iter_mut().enumerate().take(channels) {
            if after.model.joints()[channel].locked {
                continue;
            }
            let pairs = own[channel].iter().zip(&experiment.signal[channel]);
            let residual: Vec<f64> = pairs.map(|(own, recorded)| own - recorded).collect();
            let noise = ChannelNoise::of(recording, channel, &residual);
            measured &= noise.measured;
            let drawn = noise.draw(series.len(), &mut rng);
            series.iter_mut().zip(drawn).for_each(|(s, n)| *s += n);
        }
        let mut rng = stream(seed, number, 1);
        let errors: Vec<[Vec<f64>; 2]> = match &experiment.motion_error {
            Some(error) => starts
                .rows
                .iter()
                .map(|_| {
                    [
                        draw(&error.position, &mut rng),
                        draw(&error.velocity, &mut rng),
                    ]
                })
                .collect(),
            None => Vec::new(),
        };
        let noise = roll(&of(after, &noisy)?, &errors)?;
        let step = starts.rows.len().div_ceil(CHECKED);
        let halved = (0..starts.rows.len())
            .step_by(step)
            .map(|k| {
                Ok((
                    k,
                    course.roll((k, starts.lengths[k]), accuracy.halved(), None)?,
                ))
            })
            .collect::<Result<_, NotForward>>()?;
        Ok(Some(Self {
            recording,
            course,
            before: rolled_before,
            after: rolled_after,
            noise,
            halved,
            measured,
            has_start_errors: experiment.motion_error.is_some(),
            starts,
        }))
    }
}

/// Rows by which the torques of a window are recorded beyond its ends.
fn margin(candidates: [Option<&Candidate>; 2], recording: &Prepared) -> Result<usize, NotForward> {
    let mut rows = 0.0_f64;
    for candidate in candidates.into_iter().flatten() {
        let Candidate { model, values } = candidate;
        let forward = Forward::new(model, values, recording.loaded, Accuracy::default())?;
        for motor in 0..forward.motors().len() {
            rows = rows.max(forward.delay(motor).abs() * recording.experiment.rate_hz);
        }
    }
    Ok(rows.ceil() as usize)
}

/// What the windows of all recordings say.
struct Summary<'a> {
    task: Task<'a>,
    candidates: &'a Candidates,
    held_out: HeldOut,
    rolled: &'a [Rolled<'a>],
}

impl Summary<'_> {
    fn run(&self) -> Result<RolloutRun, RolloutError> {
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
    fn joints(&self) -> Vec<Named> {
        let all = self.candidates.after.model.joints().iter();
        all.filter(|joint| !joint.locked)
            .map(|joint| Named {
                name: joint.name.clone(),
                unit: joint.kind.position_unit(),
            })
            .collect()
    }

    /// Errors of a joint at a time after the start, of the windows that reach it.
    fn errors<'t>(
        &'t self,
        tracks: impl Fn(&'t Rolled<'t>) -> &'t [Track],
        time: f64,
        joint: (usize, usize),
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

    fn before<'t>(&'t self, time: f64, joint: (usize, usize)) -> Option<Spread> {
        self.candidates.before.as_ref()?;
        let tracks = |r: &'t Rolled<'t>| r.before.as_deref().unwrap_or(&[]);
        Some(spread(&self.errors(tracks, time, joint)))
    }

    fn horizons(&self, joints: &[Named]) -> Vec<Horizon> {
        let reached = HORIZONS.iter().filter(|time| {
            let reaches = |r: &Rolled<'_>| r.starts.lengths.iter().any(|l| *l >= r.row(**time));
            self.rolled.iter().any(reaches)
        });
        let at = |&horizon: &f64| {
            let of = |(k, named): (usize, &Named)| JointErrors {
                joint: named.name.clone(),
                unit: named.unit.to_string(),
                before: self.before(horizon, (k, joints.len())),
                after: spread(&self.errors(|r| &r.after, horizon, (k, joints.len()))),
                noise: spread(&self.errors(|r| &r.noise, horizon, (k, joints.len()))),
                integration: self.integration(horizon, (k, joints.len())),
            };
            Horizon {
                horizon,
                joints: joints.iter().enumerate().map(of).collect(),
            }
        };
        reached.map(at).collect()
    }

    /// RMS change of a position by half of the steps.
    fn integration(&self, time: f64, joint: (usize, usize)) -> f64 {
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

    fn curves(&self, joints: &[Named], horizons: &[Horizon]) -> Vec<ErrorCurve> {
        let longest = horizons.last().map_or(0.0, |h| h.horizon);
        let times = (0..=CURVE_POINTS).map(|k| longest * k as f64 / CURVE_POINTS as f64);
        let times: Vec<f64> = times.collect();
        let of = |(k, named): (usize, &Named)| {
            let joint = (k, joints.len());
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

    fn recordings(&self) -> Vec<RolledRecording> {
        let of = |rolled: &Rolled<'_>| RolledRecording {
            recording: rolled.recording.name.clone(),
            windows: rolled.starts.rows.len(),
            every: rolled.starts.every,
        };
        self.rolled.iter().map(of).collect()
    }

    /// The windows in the middle and at the end of all, by their largest error at the longest horizon in units of the joints' RMS.
    fn examples(
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
                    let error = rolled.after[k].error(row, (j, joints.len())).abs() / scale[j];
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
            self.rolled[r].window(kind, (k, last.horizon), joints)
        };
        Ok(chosen.into_iter().map(of).collect::<Result<_, _>>()?)
    }

    /// In plain words, at half a second or what is nearest to it.
    fn paragraph(&self, horizons: &[Horizon]) -> String {
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
            "Simulated forward under the recorded torques from {windows} starts in {}: after {} s the final model's error of \
             position",
            self.held_out.words(),
            horizon.horizon
        );
        match (self.candidates.before.as_ref(), middle(&ratios)) {
            (Some((kind, _)), Some(ratio)) => {
                text.push_str(&format!(" is {ratio:.2} times that of {}", kind.words()))
            }
            (Some(_), None) => text.push_str(" cannot be told as a share of that before"),
            (None, _) => {}
        }
        if let Some(ratio) = middle(&of_noise) {
            let joint = if ratios.is_empty() { " is" } else { ", and" };
            text.push_str(&format!(
                "{joint} {ratio:.1} times what the noise alone would make of a model that is right"
            ));
        }
        text.push_str(" (medians over windows, median of the joints).");
        text
    }

    fn notes(&self, horizons: &[Horizon]) -> Vec<String> {
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
                    "The {model} is lost in {lost} windows: further than half a turn (1 m for sliding joints) from the recording, or \
                     without positive inertia; they count as larger than any error in medians and quartiles, and not at all \
                     in the RMS."
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
            && diagnosis.findings.iter().any(|f| f.effect == "unnamed")
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

/// A joint that moves.
struct Named {
    name: String,
    unit: &'static str,
}

impl Rolled<'_> {
    /// Rows after a start at a time.
    fn row(&self, time: f64) -> usize {
        (time * self.recording.experiment.rate_hz).round() as usize
    }

    fn window(
        &self,
        kind: &'static str,
        (k, horizon): (usize, f64),
        joints: &[Named],
    ) -> Result<Window, NotForward> {
        let (start, rows) = (self.course.starts()[k], self.row(horizon));
        let recorded = (start..=start + rows)
            .map(|row| self.course.recorded(row))
            .collect::<Result<Vec<_>, _>>()?;
        let of = |(j, named): (usize, &Named)| {
            let along = |track: Option<&Track>| -> Vec<f64> {
                let at = |row: usize| {
                    let error = track.map_or(f64::NAN, |t| t.error(row, (j, joints.len())));
                    recorded[row][j] + error
                };
                (0..=rows).map(at).collect()
            };
            WindowJoint {
                joint: named.name.clone(),
                unit: named.unit,
                recorded: recorded.iter().map(|q| q[j]).collect(),
                before: along(self.before.as_ref().map(|tracks| &tracks[k])),
                after: along(Some(&self.after[k])),
            }
        };
        Ok(Window {
            kind,
            recording: self.recording.name.clone(),
            t: self.recording.experiment.t[start..=start + rows].to_vec(),
            joints: joints.iter().enumerate().map(of).collect(),
        })
    }
}

impl Window {
    /// Some of the samples, for the picture.
    fn thinned(&self) -> Example {
        let every = self.t.len().div_ceil(EXAMPLE_POINTS);
        let thin = |x: &[f64]| x.iter().step_by(every).copied().collect();
        let start = self.t.first().copied().unwrap_or(0.0);
        Example {
            kind: self.kind.to_string(),
            recording: self.recording.clone(),
            start,
            t: self.t.iter().step_by(every).map(|t| t - start).collect(),
            joints: self
                .joints
                .iter()
                .map(|joint| ExampleJoint {
                    joint: joint.joint.clone(),
                    unit: joint.unit.to_string(),
                    recorded: thin(&joint.recorded),
                    before: thin(&joint.before),
                    after: thin(&joint.after),
                })
                .collect(),
        }
    }
}

/// The table of the examples: which window, time, and recorded position, before and after of every joint.
pub fn table(examples: &[Window]) -> String {
    let mut text = String::from("recording,window,t");
    for joint in examples.first().map_or(&[][..], |w| &w.joints) {
        for quantity in ["recorded", "before", "after"] {
            text.push_str(&format!(",{}_{quantity}", joint.joint));
        }
    }
    text.push('\n');
    let number = |x: f64| {
        if x.is_finite() {
            format!("{x:.9}")
        } else {
            String::new()
        }
    };
    for window in examples {
        for (row, t) in window.t.iter().enumerate() {
            let name = window.recording.replace('"', "\"\"");
            text.push_str(&format!("\"{name}\",{},{t:.6}", window.kind));
            for joint in &window.joints {
                for series in [&joint.recorded, &joint.before, &joint.after] {
                    text.push_str(&format!(",{}", number(series[row])));
                }
            }
            text.push('\n');
        }
    }
    text
}
