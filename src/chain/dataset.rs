//! Datasets: recordings with motor motion at joint scale, signal, weights of rows, the way back
//! to every recorded sample.

use crate::chain::controller::Commands;
use crate::chain::evaluate::{EarlierMotion, KnownBodies, Segment};
use crate::recording::experiment::{Experiment, Motion};
use crate::recording::split::Split;
use crate::recording::successive_periods::successive_periods;
use crate::robot::batch::Trajectory;
use std::sync::Arc;

/// A filtered signal holds nothing above its cut-off: rows closer than this many to a period of the
/// cut-off only repeat each other. Eight leave the fastest term within 1 % of its peak.
const ROWS_PER_CUTOFF_PERIOD: f64 = 8.0;

/// A recording ready for estimates. The experiment is in motor coordinates at joint scale.
#[derive(Debug, Clone)]
pub struct Prepared {
    /// Name of the recording as the problem has it.
    pub name: String,
    /// Whether it is fitted or held out.
    pub split: Split,
    /// The load, if the model has one, hangs on the robot.
    pub loaded: bool,
    /// Motion, signal and noise at even rows.
    pub experiment: Arc<Experiment>,
    /// Every `stride`-th row of the experiment is used.
    pub stride: usize,
    /// °C, `[joint][row of the experiment]`; none where empty.
    temperature: Vec<Vec<f64>>,
    /// Known forces on the links along their joints, `[joint][row of the experiment]`; none where empty.
    forces: Vec<Vec<f64>>,
    /// What controllers are told beside the position, in rows of the experiment.
    commands: Option<Commands>,
    /// What the bodies do in rows of the experiment, where it is known.
    bodies: Option<KnownBodies>,
    /// Whether a channel's joint stands still, `[channel][row of the experiment]`, where any does.
    standing: Option<Arc<Vec<Vec<bool>>>>,
    rows: Option<Rows>,
}

#[derive(Debug, Clone)]
struct Rows {
    t: Vec<f64>,
    temperature: Vec<Vec<f64>>,
    forces: Vec<Vec<f64>>,
    commands: Option<Commands>,
    bodies: Option<KnownBodies>,
    motion: [Vec<Vec<f64>>; 3],
    signal: Vec<Vec<f64>>,
}

impl Prepared {
    /// Every row that says something of its own is used.
    pub fn new(name: String, split: Split, loaded: bool, experiment: Experiment) -> Self {
        let stride = stride(&experiment);
        Self::with_all_rows(name, split, loaded, experiment).thinned(stride)
    }

    /// Every row is used.
    pub fn with_all_rows(name: String, split: Split, loaded: bool, experiment: Experiment) -> Self {
        Self {
            name,
            split,
            loaded,
            temperature: experiment.temperatures(),
            experiment: Arc::new(experiment),
            stride: 1,
            forces: Vec::new(),
            commands: None,
            bodies: None,
            standing: None,
            rows: None,
        }
    }

    /// The same recording, of which every n-th used row is used.
    pub fn thinned(&self, n: usize) -> Self {
        let stride = self.stride * n;
        let experiment = &self.experiment;
        let every = |series: &[Vec<f64>]| thinned(series, stride);
        let rows = (stride > 1).then(|| Rows {
            t: experiment.t.iter().step_by(stride).copied().collect(),
            temperature: every(&self.temperature),
            forces: every(&self.forces),
            commands: self.commands.as_ref().map(|all| all.thinned(stride)),
            bodies: self.bodies.as_ref().map(|b| b.thinned(stride)),
            motion: [
                every(&experiment.motion.position),
                every(&experiment.motion.velocity),
                every(&experiment.motion.acceleration),
            ],
            signal: every(&experiment.signal),
        });
        Self {
            name: self.name.clone(),
            split: self.split,
            loaded: self.loaded,
            experiment: Arc::clone(experiment),
            stride,
            temperature: self.temperature.clone(),
            forces: self.forces.clone(),
            commands: self.commands.clone(),
            bodies: self.bodies.clone(),
            standing: self.standing.clone(),
            rows,
        }
    }

    /// With known forces (N·m or N) of the surroundings on the links along their joints, in rows of the
    /// experiment.
    pub fn with_forces(mut self, forces: &[(usize, Vec<f64>)]) -> Self {
        if forces.is_empty() {
            return self;
        }
        let joints = self.experiment.motion.position.len();
        self.forces = vec![vec![0.0; self.experiment.rows()]; joints];
        for (joint, series) in forces {
            self.forces[*joint].clone_from(series);
        }
        if let Some(rows) = &mut self.rows {
            rows.forces = thinned(&self.forces, self.stride);
        }
        self
    }

    /// With what controllers are told beside the position, in rows of the experiment.
    pub fn with_commands(mut self, commands: Option<Commands>) -> Self {
        if let Some(rows) = &mut self.rows {
            rows.commands = commands.as_ref().map(|all| all.thinned(self.stride));
        }
        self.commands = commands;
        self
    }

    /// What controllers are told beside the position, in rows of the experiment.
    pub fn commands(&self) -> Option<&Commands> {
        self.commands.as_ref()
    }

    /// With what the bodies do in rows of the experiment, which no evaluation along it changes.
    pub fn with_bodies(mut self, bodies: KnownBodies) -> Self {
        if let Some(rows) = &mut self.rows {
            rows.bodies = Some(bodies.thinned(self.stride));
        }
        self.bodies = Some(bodies);
        self
    }

    /// The same recording, in which channels count for nothing at used rows at which their joint stands still,
    /// `[channel][row]`.
    pub fn with_standstill(mut self, standing: &[Vec<bool>]) -> Self {
        let rows = 0..self.experiment.rows();
        let of = |standing: &Vec<bool>| {
            rows.clone()
                .map(|row| standing[row / self.stride])
                .collect()
        };
        self.standing = Some(Arc::new(standing.iter().map(of).collect()));
        self
    }

    /// The same recording in a part of the data, of which only some used rows count, by their numbers.
    pub fn part(&self, split: Split, wanted: impl Fn(usize) -> bool) -> Self {
        let mut part = self.clone();
        part.split = split;
        let counted = |row: usize| {
            let valid = self.experiment.mask.as_ref().is_none_or(|mask| mask[row]);
            valid && wanted(row / self.stride)
        };
        let mask = (0..self.experiment.rows()).map(counted).collect();
        Arc::make_mut(&mut part.experiment).mask = Some(mask);
        part
    }

    /// The same positions and accelerations with all speeds the other way; what bodies do is not known of it.
    pub fn with_speeds_turned(&self) -> Self {
        self.with_speeds(|speeds| speeds.iter_mut().flatten().for_each(|v| *v = -*v))
    }

    /// The same with a joint's speed that is off by so much, rad/s (m/s); what bodies do is not known of it.
    pub fn with_speed_off_by(&self, joint: usize, by: f64) -> Self {
        self.with_speeds(|speeds| speeds[joint].iter_mut().for_each(|v| *v += by))
    }

    fn with_speeds(&self, change: impl Fn(&mut [Vec<f64>])) -> Self {
        let mut changed = self.clone();
        change(&mut Arc::make_mut(&mut changed.experiment).motion.velocity);
        changed.bodies = None;
        if let Some(rows) = &mut changed.rows {
            change(&mut rows.motion[1]);
            rows.bodies = None;
        }
        changed
    }

    /// The same signal beside the motion as it was `delay` before, s; what bodies do is not known of it.
    pub fn late_by(&self, delay: f64) -> Self {
        if delay == 0.0 || self.experiment.rows() < 2 {
            return self.clone();
        }
        let (t, motion) = EarlierMotion::of(self.whole()).at(delay);
        let mut late = self.clone();
        let experiment = Arc::make_mut(&mut late.experiment);
        experiment.t = t;
        let [position, velocity, acceleration] = motion;
        experiment.motion = Motion {
            position,
            velocity,
            acceleration,
        };
        late.bodies = None;
        late.thinned(1)
    }

    /// Number of rows used.
    pub fn rows(&self) -> usize {
        self.experiment.rows().div_ceil(self.stride)
    }

    /// Time of a used row, s.
    pub fn time(&self, row: usize) -> f64 {
        self.experiment.t[row * self.stride]
    }

    /// Whether a used row counts.
    pub fn counts(&self, row: usize) -> bool {
        let mask = self.experiment.mask.as_ref();
        mask.is_none_or(|mask| mask[row * self.stride])
    }

    /// The used rows that count.
    pub fn counting(&self) -> impl Iterator<Item = usize> {
        (0..self.rows()).filter(|&row| self.counts(row))
    }

    /// Whether the joint of a channel stands still at a row of the experiment, so that the channel says nothing there.
    pub fn stands(&self, channel: usize, row_of_experiment: usize) -> bool {
        let standing = self.standing.as_ref();
        standing.is_some_and(|standing| standing[channel][row_of_experiment])
    }

    /// The same at the row that is nearest to a time, s.
    pub fn stands_at(&self, channel: usize, time: f64) -> bool {
        if self.standing.is_none() {
            return false;
        }
        let half = 0.5 / self.experiment.rate_hz;
        let row = self.experiment.t.partition_point(|t| t + half < time);
        row < self.experiment.rows() && self.stands(channel, row)
    }

    /// Whether a used row counts for a channel.
    pub fn counts_for(&self, channel: usize, row: usize) -> bool {
        self.counts(row) && !self.stands(channel, row * self.stride)
    }

    /// The used rows that count for a channel.
    pub fn counting_for(&self, channel: usize) -> impl Iterator<Item = usize> {
        (0..self.rows()).filter(move |&row| self.counts_for(channel, row))
    }

    /// A series over the used rows at those that count for a channel.
    pub fn counted_for(&self, channel: usize, series: &[f64]) -> Vec<f64> {
        self.counting_for(channel).map(|row| series[row]).collect()
    }

    /// Whether forces of the surroundings on the links are measured.
    pub fn has_forces(&self) -> bool {
        !self.forces.is_empty()
    }

    /// Motion and load of the used rows.
    pub fn segment(&self) -> Segment<'_> {
        match &self.rows {
            None => self.whole(),
            Some(Rows {
                t,
                temperature,
                forces,
                commands,
                bodies,
                motion: [q, dq, ddq],
                ..
            }) => Segment {
                motors: Trajectory { q, dq, ddq },
                forces,
                commands: commands.as_ref().map(|all| all.from_sample(0)),
                bodies: bodies.as_ref(),
                time: t,
                temperature,
                cyclic: false,
                loaded: self.loaded,
            },
        }
    }

    /// Motion and load of all rows of the experiment.
    pub fn whole(&self) -> Segment<'_> {
        let motion = &self.experiment.motion;
        Segment {
            motors: Trajectory {
                q: &motion.position,
                dq: &motion.velocity,
                ddq: &motion.acceleration,
            },
            forces: &self.forces,
            commands: self.commands.as_ref().map(|all| all.from_sample(0)),
            bodies: self.bodies.as_ref(),
            time: &self.experiment.t,
            temperature: &self.temperature,
            cyclic: self.experiment.periods.is_some(),
            loaded: self.loaded,
        }
    }

    /// Signal of a channel at the used rows.
    pub fn signal(&self, channel: usize) -> &[f64] {
        match &self.rows {
            None => &self.experiment.signal[channel],
            Some(rows) => &rows.signal[channel],
        }
    }
}

fn thinned(series: &[Vec<f64>], stride: usize) -> Vec<Vec<f64>> {
    let thin = |s: &Vec<f64>| s.iter().step_by(stride).copied().collect();
    series.iter().map(thin).collect()
}

/// Rows of a recording whose signal and model are both filtered are alike; where nothing is filtered every sample has
/// noise of its own, and every one is used.
fn stride(experiment: &Experiment) -> usize {
    match (&experiment.parallel, &experiment.periods) {
        (Some(filter), None) => {
            let needed = ROWS_PER_CUTOFF_PERIOD * filter.cutoff_hz();
            ((experiment.rate_hz / needed) as usize).max(1)
        }
        _ => 1,
    }
}

/// All recordings of a fit.
#[derive(Debug, Clone, Default)]
pub struct Dataset {
    /// In the order of the problem.
    pub recordings: Vec<Prepared>,
}

impl Dataset {
    /// The recordings that are fitted, or those that are held out.
    pub fn of(&self, split: Split) -> impl Iterator<Item = &Prepared> {
        self.recordings.iter().filter(move |r| r.split == split)
    }

    /// The greatest speed of every joint in the training recordings, at joint scale.
    pub fn fastest(&self) -> Vec<f64> {
        let joints = self.recordings.first();
        let joints = joints.map_or(0, |r| r.segment().motors.dq.len());
        let of = |joint: usize| {
            let speeds = self
                .of(Split::Train)
                .flat_map(|r| &r.segment().motors.dq[joint]);
            speeds.fold(0.0, |fastest: f64, v| fastest.max(v.abs()))
        };
        (0..joints).map(of).collect()
    }

    /// The recordings with their periods one after another. The noise of samples as they were recorded is each row's own,
    /// so that every row is used; a filter leaves neighbours alike.
    pub fn in_successive_periods(&self) -> Self {
        let of = |recording: &Prepared| match successive_periods(&recording.experiment) {
            Some(experiment) => {
                let prepare = match experiment.parallel {
                    Some(_) => Prepared::new,
                    None => Prepared::with_all_rows,
                };
                let name = recording.name.clone();
                let rows = experiment.rows();
                let commands = recording.commands().map(|all| all.repeated(rows));
                prepare(name, recording.split, recording.loaded, experiment).with_commands(commands)
            }
            None => recording.clone(),
        };
        Self {
            recordings: self.recordings.iter().map(of).collect(),
        }
    }

    /// Loads with which the training recordings were made: without, with, or both.
    pub fn loads(&self) -> Vec<bool> {
        let made = |loaded: bool| self.of(Split::Train).any(|r| r.loaded == loaded);
        [false, true].into_iter().filter(|&l| made(l)).collect()
    }
}
