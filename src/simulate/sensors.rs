//! What the sensors write down: positions on the side where the encoder sits, signals with noise, under
//! the column names that a fit of the same problem file reads.
//!
//! ```text
//! position_side = "joint"   q_rec = V m + offset         step 2π / counts (1 / counts of a metre)
//! position_side = "motor"   q_rec = ratio · m
//! position_side = "link"    q_rec = V m + offset
//! signal = "motor_torque"   τ_rec = τ / ratio
//! signal = "position_command"  q_cmd = q + s, of the true q; the noise is the encoder's, and added to q_rec
//! noise_correlation = ρ     x_k = ρ x_{k−1} + √(1 − ρ²) e_k  added to the signal, e_k independent and normal
//! ```

use crate::chain::model::Model;
use crate::outcome::simulation::RecordedPosition;
use crate::problem_file::choices::{PositionSide, Signal};
use crate::problem_file::recordings::ColumnsTable;
use crate::problem_file::{Located, PerJoint};
use crate::recording::column_map::{Column, ColumnsAt};
use crate::robot::tree::JointKind;
use crate::setup::error::{Mismatch, SetupError};
use crate::simulate::error::SimulateError;
use crate::simulate::path::Motion;
use crate::simulate::task::SimulateTask;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

/// Columns of numbers with their names.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    /// Names of the columns.
    pub header: Vec<String>,
    /// `[column][row]`.
    pub data: Vec<Vec<f64>>,
}

/// Temperature in recordings of a model that does not heat up, °C.
const ROOM_TEMPERATURE: f64 = 25.0;

/// Names of the components of a wrench.
const WRENCH: [&str; 6] = ["fx", "fy", "fz", "mx", "my", "mz"];

/// A table as sensors record it, and the noise in it by channel.
pub struct NoisyTable {
    /// With noise.
    pub table: Table,
    /// `[channel][row]`.
    pub noise: Vec<Vec<f64>>,
}

/// A joint that is recorded: its index in the tree, its name and its number from 1 in the problem's order.
#[derive(Debug, Clone)]
struct Recorded {
    index: usize,
    name: String,
    number: usize,
}

/// A channel of the signal.
#[derive(Debug, Clone)]
pub struct Channel {
    /// The column that has the noise.
    pub column: String,
    /// The column of the command that makes a signal which is an error of the position.
    command: Option<Column>,
    /// Of the numbers in the file.
    pub unit: String,
    /// Index in the model.
    pub index: usize,
    scale: f64,
    noise: f64,
    /// What the numbers in the file are multiplied by to be in SI units.
    factor: f64,
}

/// The sensors of a robot.
#[derive(Debug, Clone)]
pub struct Sensors {
    /// What is measured beside the motion, in the order of the file.
    pub channels: Vec<Channel>,
    joints: Vec<Recorded>,
    side: PositionSide,
    /// Recorded units per joint unit, in the order of the tree.
    ratio: Vec<f64>,
    /// Least step of an encoder, in recorded units, in the order of the tree.
    step: Option<Vec<f64>>,
    columns: Option<ColumnsTable>,
    /// Correlation of the noise of neighbouring samples.
    correlation: f64,
}

impl Sensors {
    /// # Errors
    /// A side or signal of the motor without `drive.ratio`; lists of the wrong length.
    pub fn new(task: &SimulateTask<'_>) -> Result<Self, SimulateError> {
        let (robot, table) = (task.robot, task.recordings);
        let side = table.map_or(PositionSide::Joint, |t| t.position_side.value);
        let n = robot.tree.len();
        let needs = |place| SetupError::mismatch(place, Mismatch::NeedsRatio);
        if let (Some(table), None) = (table, &robot.ratio) {
            if side == PositionSide::Motor {
                return Err(needs(&table.position_side.place).into());
            }
            if table.signal.value == Signal::MotorTorque {
                return Err(needs(&table.signal.place).into());
            }
        }
        let numbered = robot.position.iter().zip(&robot.order).zip(1..);
        let joints: Vec<Recorded> = numbered
            .filter(|((index, _), _)| robot.locked[**index].is_none())
            .map(|((&index, name), number)| Recorded {
                index,
                name: name.clone(),
                number,
            })
            .collect();
        let step = robot.per_joint(&task.settings.encoder_counts)?;
        let of_turn = |k: usize, counts: &f64| match robot.tree.joints()[k].kind {
            JointKind::Revolute => TAU / counts,
            JointKind::Prismatic => 1.0 / counts,
        };
        if let Some(table) = table {
            require_names(&table.columns, &joints)?;
        }
        let mut sensors = Self {
            channels: Vec::new(),
            joints,
            side,
            ratio: robot.ratio.clone().unwrap_or_else(|| vec![1.0; n]),
            step: step.map(|all| all.iter().enumerate().map(|(k, c)| of_turn(k, c)).collect()),
            columns: table.map(|t| t.columns.clone()),
            correlation: task.settings.noise_correlation.value,
        };
        sensors.channels = sensors.signal_channels(task)?;
        Ok(sensors)
    }

    fn signal_channels(&self, task: &SimulateTask<'_>) -> Result<Vec<Channel>, SimulateError> {
        use crate::chain::model::Signal as Kind;
        let model = &task.truth.recorded;
        let at_motor = task
            .recordings
            .is_some_and(|t| t.signal.value == Signal::MotorTorque);
        let noise = Noise::read(task)?;
        let columns = self.columns.as_ref();
        let column = match model.signal() {
            Kind::Current => given(columns.and_then(|c| c.current.as_ref()), "i{n}"),
            Kind::PositionCommand => given(columns.and_then(|c| c.position.as_ref()), "q{n}"),
            _ => given(columns.and_then(|c| c.torque.as_ref()), "tau{n}"),
        };
        let command = given(columns.and_then(|c| c.command.as_ref()), "q_cmd{n}");
        let is_command = model.signal() == Kind::PositionCommand;
        let all = model.channels();
        let mut channels = Vec::new();
        for joint in &self.joints {
            let Some(channel) = all.iter().position(|c| c.joint == Some(joint.index)) else {
                continue;
            };
            channels.push(Channel {
                column: label(&column, joint),
                command: is_command.then(|| command.clone()),
                factor: column.factor(joint.number),
                unit: all[channel].unit.to_string(),
                index: channel,
                scale: if at_motor {
                    1.0 / self.ratio[joint.index]
                } else {
                    1.0
                },
                noise: noise.joints[joint.index],
            });
        }
        let wrench = columns.and_then(|c| c.wrench.as_ref()).map(|w| &w.value);
        let of_base = all.iter().enumerate().filter(|(_, c)| c.joint.is_none());
        for (component, (index, channel)) in of_base.enumerate() {
            channels.push(Channel {
                command: None,
                column: wrench.map_or(WRENCH[component].to_string(), |w| w[component].clone()),
                unit: channel.unit.to_string(),
                index,
                scale: 1.0,
                factor: 1.0,
                noise: noise.wrench[component],
            });
        }
        Ok(channels)
    }

    /// Where recordings have the positions of the joints that have a channel.
    pub fn positions(&self, model: &Model) -> Vec<RecordedPosition> {
        let columns = self.columns.as_ref();
        let position = given(columns.and_then(|c| c.position.as_ref()), "q{n}");
        let of_channel = |channel: &Channel| {
            let index = model.channels()[channel.index].joint?;
            let joint = self.joints.iter().find(|joint| joint.index == index)?;
            let unit = match self.side {
                PositionSide::Motor => JointKind::Revolute,
                PositionSide::Joint | PositionSide::Link => model.tree().joints()[index].kind,
            };
            Some(RecordedPosition {
                joint: joint.name.clone(),
                channel: channel.column.clone(),
                column: label(&position, joint),
                unit: unit.position_unit().to_string(),
                factor: position.factor(joint.number),
            })
        };
        self.channels.iter().filter_map(of_channel).collect()
    }

    /// Records a motion of the motors.
    ///
    /// `signals` are those of the channels along the motion; `noise` gives the generator of each channel.
    pub fn record(
        &self,
        model: &Model,
        rate: f64,
        motion: &Motion,
        signals: Vec<Vec<f64>>,
        noise: impl Fn(usize) -> ChaCha8Rng,
    ) -> NoisyTable {
        let rows = motion[0].first().map_or(0, Vec::len);
        let columns = self.columns.as_ref();
        let mut table = Table::default();
        let named = |of: fn(&ColumnsTable) -> &Option<Located<Column>>| {
            columns.and_then(|c| of(c).as_ref())
        };
        let time = given(named(|c| &c.time), "t");
        let unit = time.factor(1);
        let times = (0..rows).map(|k| k as f64 / rate / unit);
        table.push(time.label("", 1).unwrap_or_default(), times.collect());
        let position = given(named(|c| &c.position), "q{n}");
        let errors = |(number, channel): (usize, &Channel)| {
            let mut errors = normal(noise(number), channel.noise, rows);
            correlate(&mut errors, self.correlation);
            errors
        };
        let added: Vec<Vec<f64>> = self.channels.iter().enumerate().map(errors).collect();
        let positions = self.position(model, &motion[0], &added);
        self.push_motion(&mut table, &position, positions);
        let rates = [named(|c| &c.velocity), named(|c| &c.acceleration)];
        for (asked, series) in rates.into_iter().zip(&motion[1..]) {
            if let Some(column) = asked {
                self.push_motion(&mut table, &column.value, self.on_side(model, series));
            }
        }
        let commands = self.commands(model, &motion[0], &signals);
        if let Some(command) = self.channels.iter().find_map(|c| c.command.as_ref()) {
            self.push_motion(&mut table, command, commands);
        } else {
            for ((channel, mut series), errors) in self.channels.iter().zip(signals).zip(&added) {
                let pairs = series.iter_mut().zip(errors);
                pairs.for_each(|(x, e)| *x = (channel.scale * *x + e) / channel.factor);
                table.push(channel.column.clone(), series);
            }
        }
        if let Some(column) = named(|c| &c.temperature) {
            let warm = vec![vec![ROOM_TEMPERATURE; rows]; model.tree().len()];
            self.push_motion(&mut table, &column.value, warm);
        }
        if let Some(column) = named(|c| &c.mask) {
            let name = column.value.label("", 1).unwrap_or_default();
            table.push(name, vec![1.0; rows]);
        }
        NoisyTable {
            table,
            noise: added,
        }
    }

    fn push_motion(&self, table: &mut Table, column: &Column, mut series: Vec<Vec<f64>>) {
        for joint in &self.joints {
            let mut numbers = std::mem::take(&mut series[joint.index]);
            let factor = column.factor(joint.number);
            if factor != 1.0 {
                numbers.iter_mut().for_each(|x| *x /= factor);
            }
            table.push(label(column, joint), numbers);
        }
    }

    /// Positions as the encoders give them, with noise where the signal is an error of the position.
    fn position(&self, model: &Model, motors: &[Vec<f64>], noise: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut out = self.exact_position(model, motors);
        for (channel, errors) in self.channels.iter().zip(noise) {
            if let (Some(_), Some(joint)) =
                (&channel.command, model.channels()[channel.index].joint)
            {
                let pairs = out[joint].iter_mut().zip(errors);
                pairs.for_each(|(x, e)| *x += e);
            }
        }
        if let Some(steps) = &self.step {
            for (series, step) in out.iter_mut().zip(steps) {
                series
                    .iter_mut()
                    .for_each(|x| *x = (*x / step).round() * step);
            }
        }
        out
    }

    /// Positions of the motors on the side of the encoders.
    fn exact_position(&self, model: &Model, motors: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut out = self.on_side(model, motors);
        if self.side != PositionSide::Motor {
            for (series, offset) in out.iter_mut().zip(model.offset().iter()) {
                series.iter_mut().for_each(|x| *x += offset);
            }
        }
        out
    }

    /// Commanded positions on the side of the encoders: `m + s` of the motors.
    fn commands(&self, model: &Model, motors: &[Vec<f64>], signals: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut commanded = motors.to_vec();
        for (channel, errors) in self.channels.iter().zip(signals) {
            if let Some(joint) = model.channels()[channel.index].joint {
                let pairs = commanded[joint].iter_mut().zip(errors);
                pairs.for_each(|(m, s)| *m += s);
            }
        }
        self.exact_position(model, &commanded)
    }

    /// Motions of the motors on the side of the encoders, without offset.
    fn on_side(&self, model: &Model, motors: &[Vec<f64>]) -> Vec<Vec<f64>> {
        match self.side {
            PositionSide::Motor => {
                let pairs = motors.iter().zip(&self.ratio);
                pairs
                    .map(|(series, ratio)| series.iter().map(|x| ratio * x).collect())
                    .collect()
            }
            PositionSide::Joint | PositionSide::Link => joints_of(model, motors),
        }
    }
}

/// `V m`.
pub(super) fn joints_of(model: &Model, motors: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let coupling = model.coupling(&model.values());
    let rows = motors.first().map_or(0, Vec::len);
    (0..motors.len())
        .map(|i| {
            let mut out = vec![0.0; rows];
            for (j, series) in motors.iter().enumerate() {
                let weight = coupling[(i, j)];
                if weight != 0.0 {
                    let pairs = out.iter_mut().zip(series);
                    pairs.for_each(|(to, x)| *to += weight * x);
                }
            }
            out
        })
        .collect()
}

impl Table {
    pub(super) fn push(&mut self, name: String, column: Vec<f64>) {
        self.header.push(name);
        self.data.push(column);
    }
}

/// Standard deviations of the channels, joints in the order of the tree.
struct Noise {
    joints: Vec<f64>,
    wrench: [f64; 6],
}

impl Noise {
    /// One number holds for every channel; a list has one per joint, or one per component of a wrench, or
    /// both where both are recorded.
    fn read(task: &SimulateTask<'_>) -> Result<Self, SimulateError> {
        use crate::chain::model::Signal as Kind;
        let (robot, model) = (task.robot, &task.truth.recorded);
        let n = robot.tree.len();
        let mut noise = Self {
            joints: vec![0.0; n],
            wrench: [0.0; 6],
        };
        let Some(given) = &task.settings.noise else {
            return Ok(noise);
        };
        if let PerJoint::All(value) = given.value {
            noise.joints.fill(value);
            noise.wrench.fill(value);
            return Ok(noise);
        }
        let components = WRENCH.iter().map(|name| (*name).to_string());
        let names: Vec<String> = match model.signal() {
            Kind::BaseWrench => components.collect(),
            Kind::Both => robot.order.iter().cloned().chain(components).collect(),
            _ => robot.order.clone(),
        };
        let values = given.expand(&names)?;
        if model.signal() != Kind::BaseWrench {
            noise.joints = robot.to_tree(&values[..robot.order.len()]);
        }
        let rest = values[values.len() - 6.min(values.len())..].iter();
        if matches!(model.signal(), Kind::BaseWrench | Kind::Both) {
            noise
                .wrench
                .iter_mut()
                .zip(rest)
                .for_each(|(to, x)| *to = *x);
        }
        Ok(noise)
    }
}

/// The columns that the problem file names, or the usual ones.
fn given(given: Option<&Located<Column>>, usual: &str) -> Column {
    given.map_or_else(|| Column::from(usual), |column| column.value.clone())
}

/// The name of a joint's column; [`Sensors::new`] has refused columns without one.
fn label(column: &Column, joint: &Recorded) -> String {
    column.label(&joint.name, joint.number).unwrap_or_default()
}

/// Columns that a file is to be written with have names, one for each joint.
fn require_names(columns: &ColumnsTable, joints: &[Recorded]) -> Result<(), SetupError> {
    let channels = [
        &columns.time,
        &columns.position,
        &columns.velocity,
        &columns.acceleration,
        &columns.current,
        &columns.torque,
        &columns.command,
        &columns.temperature,
        &columns.mask,
    ];
    let most = joints.iter().map(|joint| joint.number).max().unwrap_or(0);
    let is_nameless = |column: &&Located<Column>| match &column.value.at {
        ColumnsAt::Pattern(_) => false,
        ColumnsAt::Names(names) => names.len() > 1 && names.len() < most,
        ColumnsAt::Numbers(_) => true,
    };
    match channels.into_iter().flatten().find(is_nameless) {
        None => Ok(()),
        Some(column) => Err(SetupError::mismatch(
            &column.place,
            Mismatch::NotYet {
                what: "writing a file whose columns have no names".to_string(),
                instead: "name the columns of every joint: { column = \"q{n}\" }".to_string(),
            },
        )),
    }
}

fn normal(mut rng: ChaCha8Rng, std_dev: f64, count: usize) -> Vec<f64> {
    let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
    (0..count).map(|_| std_dev * draw()).collect()
}

/// Turns white noise into stationary noise of the same deviation, x_k = ρ x_{k−1} + √(1 − ρ²) e_k.
fn correlate(noise: &mut [f64], correlation: f64) {
    let fresh = (1.0 - correlation * correlation).sqrt();
    for k in 1..noise.len() {
        noise[k] = correlation * noise[k - 1] + fresh * noise[k];
    }
}
