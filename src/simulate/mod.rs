//! Recordings from a model: motion, signal along it, sensors with noise and quantisation.
//!
//! The motion is a trajectory itself (`mode = "inverse"`) or what a controlled robot makes of it
//! (`mode = "closed_loop"`); the signal is in both cases what the [chain](crate::chain) gives along the
//! true motion, so that a fit of the same problem file can recover the [truth](truth::Truth).

mod aperiodic;
mod closed_loop;
mod concealed;
pub mod error;
mod motion;
pub mod path;
mod path_file;
pub mod plant;
mod random_aperiodic;
mod random_frame;
mod random_path;
mod recording;
pub mod sensors;
pub mod task;
pub mod truth;
mod write;

pub use crate::simulate::recording::SimulatedRecording;

#[cfg(test)]
mod tests;

use crate::chain::effect::Memory;
use crate::fault::Place;
use crate::outcome::parameter::Parameter;
use crate::outcome::simulation::{RealisedNoise, RecordedPosition};
use crate::problem::solution::Control;
use crate::problem_file::choices::SimulationMode;
use crate::problem_file::simulate::Trajectory;
use crate::problem_file::{Located, ProblemFile};
use crate::recording::table::LEAST_ROWS;
use crate::robot::random::generator;
use crate::setup::{limits, robot};
use crate::simulate::closed_loop::{Loop, Schedule};
use crate::simulate::error::{SimulateError, SimulateErrorKind};
use crate::simulate::path::{Instants, Motion, Path};
use crate::simulate::random_aperiodic::Kind;
use crate::simulate::random_frame::{Frame, Shape};
use crate::simulate::random_path::{RecordingConditions, torques};
use crate::simulate::sensors::{NoisyTable, Sensors, Table, joints_of};
use crate::simulate::task::{DrawnMotion, Plan, SimulateTask};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

pub use crate::simulate::write::write_csv;

/// Steps of laws with memory between two samples: their errors fall below a tenth of a percent of the
/// law's torque.
const FINER: usize = 8;

/// What a simulation gives.
#[derive(Debug, Clone)]
pub struct Simulated {
    /// In the order of the problem file: without load, with it, for validation.
    pub recordings: Vec<SimulatedRecording>,
    /// One pass of each trajectory that was commanded, of the joints, as `simulate.trajectory` reads it.
    pub trajectories: Vec<SimulatedRecording>,
    /// Noise of each channel over all recordings.
    pub realised_noise: Vec<RealisedNoise>,
    /// Where the recordings have the positions of joints with a channel.
    pub positions: Vec<RecordedPosition>,
    /// Every value behind the recordings.
    pub truth: Vec<Parameter>,
    /// Anything a reader should know, one sentence each.
    pub notes: Vec<String>,
}

/// Simulates the recordings of a problem file: those listed under `[recordings]`, or else `train.csv` and
/// `validation.csv`. The same problem and seed give the same bits.
///
/// # Errors
/// Faults of the problem file and of the files it names; a truth that is not complete; as [`SimulateTask::run`].
pub fn run(
    problem: &ProblemFile,
    seed: u64,
    control: &Control<'_>,
) -> Result<Simulated, SimulateError> {
    let robot = robot::open(problem)?;
    let task = SimulateTask {
        robot: &robot,
        truth: &truth::build(problem, &robot)?,
        recordings: problem.recordings.as_ref(),
        settings: &problem.simulate,
        drawn: DrawnMotion {
            limits: limits::of_joints(problem, &robot)?,
            harmonics: problem.design.harmonics.value.most(),
            period: problem.design.period.value,
        },
        place: Place::file(&problem.path),
        seed,
    };
    task.run(control)
}

impl SimulateTask<'_> {
    /// Makes the recordings.
    ///
    /// # Errors
    /// A motion that the limits or the dynamics do not allow; files that cannot be written; an interrupt.
    pub fn run(&self, control: &Control<'_>) -> Result<Simulated, SimulateError> {
        let truth = self.truth;
        let recorder = Recorder {
            sensors: Sensors::new(self)?,
            rate: self.rate()?,
            task: self,
        };
        let planned = self.planned()?;
        let count = control.counting(planned.len());
        let made: Vec<Made> = planned
            .par_iter()
            .enumerate()
            .map(|(number, plan)| {
                let made = recorder.make(number, plan, control);
                count.one();
                made
            })
            .collect::<Result<_, _>>()?;
        let mut notes = truth.notes.clone();
        if made.iter().any(|m| !m.repeats) {
            notes.push(
                "the trajectory does not lead back to its start: each recording is one pass".into(),
            );
        }
        notes.extend(self.unwritten());
        let realised_noise = realised(&recorder.sensors, &made);
        let (recordings, trajectories) = made
            .into_iter()
            .map(|m| (m.recording, m.trajectory))
            .unzip();
        Ok(Simulated {
            recordings,
            trajectories,
            realised_noise,
            positions: recorder.sensors.positions(&truth.recorded),
            truth: truth.parameters.clone(),
            notes,
        })
    }
}

/// A recording with what belongs to it.
struct Made {
    recording: SimulatedRecording,
    trajectory: SimulatedRecording,
    repeats: bool,
}

/// Streams of random numbers of one recording: this many, the first one for the trajectory.
const STREAMS: u64 = 1 << 16;

/// Makes the recordings of a task, one by one.
struct Recorder<'a> {
    task: &'a SimulateTask<'a>,
    sensors: Sensors,
    /// Hz.
    rate: f64,
}

impl Recorder<'_> {
    /// The generator of one purpose of one recording.
    fn generator(&self, number: usize, purpose: u64) -> ChaCha8Rng {
        let mut rng = generator(self.task.seed);
        rng.set_stream(STREAMS * (number as u64 + 1) + purpose);
        rng
    }

    fn make(
        &self,
        number: usize,
        plan: &Plan,
        control: &Control<'_>,
    ) -> Result<Made, SimulateError> {
        let path = self.path(number, plan.loaded)?;
        let motion = self.motion(&path, plan.loaded, control)?;
        let model = &self.task.truth.recorded;
        let signals = self.signals(&path, &motion, plan.loaded)?;
        let streams = |channel: usize| self.generator(number, 1 + channel as u64);
        let NoisyTable { table, noise } = self
            .sensors
            .record(model, self.rate, &motion, signals, streams);
        Ok(Made {
            recording: SimulatedRecording {
                name: plan.name.clone(),
                table,
                noise,
            },
            trajectory: self.trajectory(&path, &plan.name),
            repeats: path.repeats(),
        })
    }

    /// Signals of the channels along a motion. Laws with memory are solved on a finer grid than the
    /// recording's where the motion between its samples is known.
    fn signals(
        &self,
        path: &Path,
        motion: &Motion,
        loaded: bool,
    ) -> Result<Vec<Vec<f64>>, SimulateError> {
        let model = &self.task.truth.recorded;
        let channels: Vec<usize> = self.sensors.channels.iter().map(|c| c.index).collect();
        let follows = self.task.settings.mode.value == SimulationMode::Inverse;
        let finer = match model.memory() {
            Memory::WholeMotion if follows => FINER,
            _ => 1,
        };
        let conditions = RecordingConditions {
            rate: finer as f64 * self.rate,
            cyclic: path.repeats(),
            loaded,
        };
        if finer == 1 {
            return Ok(torques(model, motion, conditions, &channels));
        }
        let count = finer * motion[0].first().map_or(0, Vec::len);
        let fine = self.closed(
            path.sample(Instants {
                start: 0.0,
                rate: conditions.rate,
                count,
            }),
            conditions.rate,
        )?;
        let signals = torques(model, &fine, conditions, &channels);
        let thin = |series: Vec<f64>| series.into_iter().step_by(finer).collect();
        Ok(signals.into_iter().map(thin).collect())
    }

    /// The path of the motors that is commanded.
    fn path(&self, number: usize, loaded: bool) -> Result<Path, SimulateError> {
        let (task, truth) = (self.task, self.task.truth);
        let shape = match &task.settings.trajectory.value {
            Trajectory::File(file) => {
                let joints = path_file::read(task.recordings, file, &truth.nominal)?;
                return Ok(random_path::to_motors(&joints, &truth.nominal));
            }
            Trajectory::Random => Shape::Fourier,
            Trajectory::Tones => self.free(Kind::Tones)?,
            Trajectory::Moves => self.free(Kind::Moves)?,
            Trajectory::Sweeps => self.free(Kind::Sweeps)?,
        };
        let stated = task.stated_period();
        let frame = Frame {
            plant: &truth.plant,
            nominal: &truth.nominal,
            limits: &task.drawn.limits,
            harmonics: task.drawn.harmonics,
            period: stated.map_or(task.drawn.period, |stated| stated.value),
            shape,
        };
        let place = &task.settings.trajectory.place;
        frame.draw(&mut self.generator(number, 0), loaded, place)
    }

    /// A motion that does not repeat, for as many of `design.period` as `simulate.periods` says.
    fn free(&self, kind: Kind) -> Result<Shape, SimulateError> {
        if let Some(period) = self.task.stated_period() {
            let recordings = period.value;
            let kind = SimulateErrorKind::PeriodOfFreeMotion { recordings };
            return Err(SimulateError::new(&period.place, kind));
        }
        let periods = self.task.settings.periods.value as f64;
        Ok(Shape::Aperiodic {
            kind,
            duration: periods * self.task.drawn.period,
        })
    }

    /// The motion of the motors at the samples of a recording.
    fn motion(
        &self,
        path: &Path,
        loaded: bool,
        control: &Control<'_>,
    ) -> Result<Motion, SimulateError> {
        let table = self.task.settings;
        let passes = |of: &Located<usize>| if path.repeats() { of.value as f64 } else { 1.0 };
        let samples = (passes(&table.periods) * path.duration() * self.rate).round() as usize;
        if samples < LEAST_ROWS {
            let least = LEAST_ROWS;
            let kind = SimulateErrorKind::TooShort { samples, least };
            return Err(SimulateError::new(&table.periods.place, kind));
        }
        if table.mode.value == SimulationMode::Inverse {
            return self.closed(
                path.sample(Instants {
                    start: 0.0,
                    rate: self.rate,
                    count: samples,
                }),
                self.rate,
            );
        }
        let warmup = match path.repeats() {
            true => table.warmup_periods.value as f64 * path.duration(),
            false => 0.0,
        };
        let closed = Loop {
            plant: &self.task.truth.plant,
            nominal: &self.task.truth.nominal,
            path,
            loaded,
            place: &table.mode.place,
        };
        let schedule = Schedule {
            rate: self.rate,
            samples,
            warmup,
        };
        self.closed(closed.run(schedule, control)?, self.rate)
    }

    /// A motion of the motors at `rate`, Hz, with that of the joints that have none.
    fn closed(&self, motion: Motion, rate: f64) -> Result<Motion, SimulateError> {
        let place = &self.task.settings.trajectory.place;
        path::with_loops(&self.task.truth.plant, motion).map_err(|open| {
            SimulateError::new(
                place,
                SimulateErrorKind::OpenLoops {
                    time: open.sample as f64 / rate,
                    reason: open.error.to_string(),
                },
            )
        })
    }

    /// One pass of the joints: t, q_<joint>, then dq_<joint>, then ddq_<joint>.
    fn trajectory(&self, path: &Path, recording: &str) -> SimulatedRecording {
        let model = &self.task.truth.nominal;
        let passive = model.mechanism().map_or(&[][..], |m| m.passive());
        let count = (path.duration() * self.rate).round().max(1.0) as usize;
        let rate = count as f64 / path.duration();
        let motion = path.sample(Instants {
            start: 0.0,
            rate,
            count,
        });
        let mut table = Table::default();
        table.push("t".into(), (0..count).map(|k| k as f64 / rate).collect());
        for (order, prefix) in ["q", "dq", "ddq"].into_iter().enumerate() {
            let joints = joints_of(model, &motion[order]);
            let of_motors = joints
                .into_iter()
                .enumerate()
                .filter(|(j, _)| !passive.contains(j));
            for (j, mut series) in of_motors {
                if order == 0 {
                    series.iter_mut().for_each(|x| *x += model.offset()[j]);
                }
                table.push(format!("{prefix}_{}", model.joints()[j].name), series);
            }
        }
        let stem = recording.trim_end_matches(".gz").trim_end_matches(".csv");
        SimulatedRecording {
            name: format!("{stem}.trajectory.csv"),
            table,
            noise: Vec::new(),
        }
    }
}

/// Root mean square of the noise of each channel over all recordings.
fn realised(sensors: &Sensors, made: &[Made]) -> Vec<RealisedNoise> {
    let channels = sensors.channels.iter().enumerate();
    channels
        .map(|(number, channel)| {
            let all = made.iter().flat_map(|m| &m.recording.noise[number]);
            let (count, squares) = all.fold((0.0, 0.0), |(n, s), x| (n + 1.0, s + x * x));
            RealisedNoise {
                channel: channel.column.clone(),
                unit: channel.unit.clone(),
                std_dev: f64::sqrt(squares / count),
            }
        })
        .collect()
}
