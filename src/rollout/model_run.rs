//! A model along a recording: motion and torques of its motors, and its internal states.

use crate::chain::dataset::Prepared;
use crate::chain::evaluate::Evaluator;
use crate::chain::forward::{Accuracy, Driven, Forward, NotForward, State, Told};
use crate::robot::tree::JointKind;
use crate::rollout::candidate::Candidate;
use crate::stats::range::within;
use nalgebra::DMatrix;
use std::borrow::Cow;

/// Largest distance from the recording, rad or m by kind of joint, at which a model is not lost.
pub const DIVERGED: [f64; 2] = [std::f64::consts::PI, 1.0];

/// A recording with the torques that drive a model.
#[derive(Debug)]
pub struct ModelRun<'a> {
    candidate: &'a Candidate,
    recording: &'a Prepared,
    /// Motors of the model, `[order][motor][row]`, of those that move in the order of [`Forward::motors`].
    motion: [Vec<Vec<f64>>; 2],
    acceleration: Vec<Vec<f64>>,
    /// All motors in the first row: where those stand that do not move.
    held: Vec<f64>,
    /// Torques of the motors, or what their controllers aim at, `[motor][row]`, N·m (N).
    torque: Vec<Vec<f64>>,
    is_controlled: bool,
    /// States at the starts of windows, what lags and remembers among them.
    states: Vec<State>,
    starts: Vec<usize>,
}

/// A joint among those that move.
#[derive(Debug, Clone, Copy)]
pub struct MovingJoint {
    /// Its place among them.
    pub index: usize,
    /// How many there are.
    pub count: usize,
}

/// A window as a model goes through it.
#[derive(Debug, Clone, Default)]
pub struct Track {
    /// Errors of the positions of the joints, `[row][joint]` one after the other, from the start on; those behind the end are of
    /// a model that is lost.
    pub errors: Vec<f64>,
}

impl<'a> ModelRun<'a> {
    /// The run of a model along a recording whose windows begin at rows `starts`, under `signal` by channel.
    pub fn new(
        candidate: &'a Candidate,
        recording: &'a Prepared,
        signal: &[Vec<f64>],
        starts: &[usize],
        accuracy: Accuracy,
    ) -> Result<Self, NotForward> {
        let Candidate { model, values } = candidate;
        let mut forward = Forward::new(model, values, recording.loaded, accuracy)?;
        let experiment = &recording.experiment;
        let n = model.joints().len();
        let coupling = model.coupling(values);
        let transfer = match model.reference() {
            Some(reference) if *reference != coupling => coupling
                .try_inverse()
                .map_or_else(|| DMatrix::identity(n, n), |inverse| inverse * reference),
            _ => DMatrix::identity(n, n),
        };
        let recorded = &experiment.motion;
        let moved = |series: &[Vec<f64>], motor: usize| -> Vec<f64> {
            let of = |row: usize| (0..n).map(|j| transfer[(motor, j)] * series[j][row]).sum();
            match transfer
                .row(motor)
                .iter()
                .enumerate()
                .all(|(j, x)| *x == f64::from(u8::from(j == motor)))
            {
                true => series[motor].clone(),
                false => (0..experiment.rows()).map(of).collect(),
            }
        };
        let motors = forward.motors().to_vec();
        let all = |series: &[Vec<f64>]| motors.iter().map(|&j| moved(series, j)).collect();
        let motion: [Vec<Vec<f64>>; 2] = [all(&recorded.position), all(&recorded.velocity)];
        let is_controlled = forward.is_controlled();
        let commands = recording.commands().map(|commands| commands.from_sample(0));
        let of_row = |series: Option<&[f64]>, row: usize| {
            series.and_then(|s| s.get(row).copied()).unwrap_or(0.0)
        };
        // A signal is recorded later than it acts, a command acts later than it is recorded.
        let ahead = if is_controlled { -1.0 } else { 1.0 };
        let acting = motors.iter().enumerate().map(|(k, &j)| {
            let aim = |(row, s): (usize, &f64)| {
                let told = Told {
                    position: motion[0][k][row] + s,
                    velocity: of_row(commands.map(|c| c.velocity(j)), row),
                    feed_forward: of_row(commands.map(|c| c.feed_forward(j)), row),
                };
                forward.aim(k, told)
            };
            let series = match is_controlled {
                true => Cow::Owned(signal[j].iter().enumerate().map(aim).collect()),
                false => Cow::Borrowed(&signal[j]),
            };
            let rows = ahead * forward.delay(k) * experiment.rate_hz;
            match rows == 0.0 {
                true => series.into_owned(),
                false => shifted(&series, rows, experiment.periods.is_some()),
            }
        });
        let mut torque: Vec<Vec<f64>> = acting.collect();
        if !is_controlled {
            for row in 0..torque.first().map_or(0, Vec::len) {
                let torques = forward.motor_torques(&Self::at(&torque, row));
                let pairs = torque.iter_mut().zip(torques);
                pairs.for_each(|(series, torque)| series[row] = torque);
            }
        }
        let held: Vec<f64> = (0..n).map(|j| moved(&recorded.position, j)[0]).collect();
        forward.hold(&held);
        let mut run = Self {
            candidate,
            recording,
            motion,
            acceleration: all(&recorded.acceleration),
            held,
            torque,
            is_controlled,
            states: Vec::new(),
            starts: starts.to_vec(),
        };
        run.states = run.follow(&mut forward);
        Ok(run)
    }

    fn at(series: &[Vec<f64>], row: usize) -> Vec<f64> {
        series.iter().map(|s| s[row]).collect()
    }

    /// Loops close where they were recorded.
    fn close_near(&self, forward: &mut Forward<'_>, row: usize) {
        let recorded = &self.recording.experiment.motion.position;
        forward.close_near(|joint| recorded[joint][row]);
    }

    /// States at the starts: the motors as recorded, and what follows them from the beginning of the recording on, of a motion that
    /// repeats from a period before.
    fn follow(&self, forward: &mut Forward<'_>) -> Vec<State> {
        let recorded = |row: usize| [0, 1].map(|order: usize| Self::at(&self.motion[order], row));
        let [q, dq] = recorded(0);
        self.close_near(forward, 0);
        let mut state = forward.settled(&q, &dq);
        let remembers = forward.lags() > 0 || forward.has_memory();
        let experiment = &self.recording.experiment;
        let rows = experiment.rows();
        let last = self.starts.iter().copied().max().unwrap_or(0);
        let passes = 1 + usize::from(experiment.periods.is_some() && remembers);
        let mut states = Vec::new();
        for pass in 1..=passes {
            let end = if pass < passes { rows } else { last + 1 };
            for row in 0..end {
                let [q, dq] = recorded(row);
                state.position[..q.len()].copy_from_slice(&q);
                state.velocity[..q.len()].copy_from_slice(&dq);
                if pass == passes && self.starts.contains(&row) {
                    states.push(state.clone());
                }
                if !remembers || row + 1 == end && pass == passes {
                    continue;
                }
                let next = (row + 1) % rows;
                let of = |a: &Vec<f64>| 0.5 * (a[row] + a[next]);
                let mean: Vec<f64> = self.acceleration.iter().map(of).collect();
                let driven = Driven::Motion {
                    acceleration: &mean,
                };
                let duration = experiment.step_after(row);
                if forward.advance(&mut state, driven, duration).is_err() {
                    state = forward.settled(&q, &dq);
                }
            }
        }
        forward.begin();
        states
    }

    /// Goes through the window that begins at a start, over so many rows, from a state with errors of position and velocity.
    pub fn roll(
        &self,
        window: usize,
        rows: usize,
        accuracy: Accuracy,
        errors: Option<&[Vec<f64>; 2]>,
    ) -> Result<Track, NotForward> {
        let Candidate { model, values } = self.candidate;
        let mut forward = Forward::new(model, values, self.recording.loaded, accuracy)?;
        forward.hold(&self.held);
        let start = self.starts[window];
        self.close_near(&mut forward, start);
        let mut state = self.states[window].clone();
        if let Some([position, velocity]) = errors {
            let motors = forward.motors().to_vec();
            for (k, &j) in motors.iter().enumerate() {
                state.position[k] += position.get(j).copied().unwrap_or(0.0);
                state.velocity[k] += velocity.get(j).copied().unwrap_or(0.0);
            }
        }
        let motors = forward.motors().len();
        let limits: Vec<f64> = forward
            .motors()
            .iter()
            .map(|&j| DIVERGED[usize::from(model.joints()[j].kind == JointKind::Prismatic)])
            .collect();
        let mut track = Track {
            errors: Vec::with_capacity((rows + 1) * motors),
        };
        let (mut from, mut to) = (vec![0.0; motors], Self::at(&self.torque, start));
        for row in start..=start + rows {
            let kept = track.errors.len();
            for k in 0..motors {
                let error: f64 = (0..motors)
                    .map(|m| {
                        forward.coupling_entry(k, m) * (state.position[m] - self.motion[0][m][row])
                    })
                    .sum();
                track.errors.push(error);
            }
            let is_near = |(e, limit): (&f64, &f64)| e.abs() <= *limit;
            if !track.errors[kept..].iter().zip(&limits).all(is_near) {
                track.errors.truncate(kept);
                break;
            }
            if row == start + rows {
                break;
            }
            std::mem::swap(&mut from, &mut to);
            for (to, series) in to.iter_mut().zip(&self.torque) {
                *to = series[row + 1];
            }
            let (from, to) = (&from[..], &to[..]);
            let driven = match self.is_controlled {
                true => Driven::Command { from, to },
                false => Driven::Torque { from, to },
            };
            // A mass matrix that is not positive, or a mechanism that tears, is as lost as a robot that flies away.
            let duration = self.recording.experiment.step_after(row);
            if forward.advance(&mut state, driven, duration).is_err() {
                break;
            }
        }
        Ok(track)
    }

    /// Recorded position of every joint that moves in a row, `V m + offset`.
    pub fn recorded(&self, row: usize) -> Result<Vec<f64>, NotForward> {
        let Candidate { model, values } = self.candidate;
        let mut forward = Forward::new(model, values, self.recording.loaded, Accuracy::default())?;
        forward.hold(&self.held);
        let mut out = vec![0.0; forward.motors().len()];
        forward.joint_positions(&Self::at(&self.motion[0], row), &mut out);
        Ok(out)
    }

    /// Rows at which windows begin.
    pub fn starts(&self) -> &[usize] {
        &self.starts
    }
}

impl Track {
    /// The error of a joint so many rows after the start; not a number where the model is lost.
    pub fn error(&self, row: usize, joint: MovingJoint) -> f64 {
        self.errors
            .get(row * joint.count + joint.index)
            .copied()
            .unwrap_or(f64::NAN)
    }
}

/// A series so many rows later, by the cubic through four neighbours; beyond its ends the last value, or the next period.
fn shifted(series: &[f64], rows: f64, cyclic: bool) -> Vec<f64> {
    let count = series.len() as f64;
    let at = |k: f64| -> f64 {
        let k = if cyclic {
            k.rem_euclid(count)
        } else {
            within(k, [0.0, count - 1.0])
        };
        series[(k as usize).min(series.len() - 1)]
    };
    let value = |k: usize| {
        let position = k as f64 + rows;
        let (whole, s) = (position.floor(), position - position.floor());
        let [a, b, c, d] = [-1.0, 0.0, 1.0, 2.0].map(|step| at(whole + step));
        // Lagrange's cubic.
        -s * (s - 1.0) * (s - 2.0) / 6.0 * a + (s + 1.0) * (s - 1.0) * (s - 2.0) / 2.0 * b
            - (s + 1.0) * s * (s - 2.0) / 2.0 * c
            + (s + 1.0) * s * (s - 1.0) / 6.0 * d
    };
    (0..series.len()).map(value).collect()
}

/// Signals of the chain of a model along a recording, `[channel][row]`.
pub fn predicted(candidate: &Candidate, recording: &Prepared) -> Vec<Vec<f64>> {
    let Candidate { model, values } = candidate;
    let mut evaluator = Evaluator::along(model, values, &[], recording.experiment.rows());
    let block = evaluator.evaluate_whole(recording.whole());
    let channels = 0..model.channels().len();
    channels.map(|c| block.value(c).to_vec()).collect()
}
