//! Mechanisms of a problem file, and the motion of their joints without a motor.

use crate::chain::model::Model;
use crate::fault::Place;
use crate::mechanism::condition::{Anchor, Condition};
use crate::mechanism::error::MechanismError;
use crate::mechanism::h4::H4;
use crate::mechanism::loops::Mechanism;
use crate::problem_file::choices::ClosedJoint;
use crate::problem_file::recordings::SensorTable;
use crate::problem_file::robot::{ClosedTable, H4_KEYS, RobotTable};
use crate::problem_file::{Located, Named, RecordingsTable};
use crate::recording::columns::read_further;
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::experiment::{Bandwidth, Experiment, Motion};
use crate::recording::preprocess::prepare;
use crate::recording::samples::Recording;
use crate::recording::settings::Preparation;
use crate::robot::tree::Tree;
use crate::setup::error::{Mismatch, SetupError};
use crate::setup::recordings::preparation;
use crate::setup::robot::unknown;
use nalgebra::Vector3;

/// The H4 of the table `[robot.h4]`.
///
/// # Errors
/// A length that is missing, unknown or none.
pub fn h4(table: &Located<toml::Value>) -> Result<Mechanism, SetupError> {
    let entries = table.value.as_table();
    let lengths: Vec<&str> = H4_KEYS.iter().map(|key| key.name).collect();
    let known = |key: &str| lengths.contains(&key);
    let mut keys = entries.into_iter().flatten().map(|(key, _)| key);
    if let Some(key) = keys.find(|key| !known(key)) {
        let text = format!(
            "`{key}` is no length of an H4; its lengths are {}",
            lengths.join(", ")
        );
        return Err(faulty(&table.place, text));
    }
    let length = |key: &str| {
        let value = entries.and_then(|entries| entries.get(key));
        let number = value.and_then(|v| v.as_float().or(v.as_integer().map(|whole| whole as f64)));
        number.ok_or_else(|| faulty(&table.place, format!("`{key}` wants a number of metres")))
    };
    let robot = H4 {
        lever: length("lever")?,
        rod: length("rod")?,
        half_bar: length("half_bar")?,
        half_width: length("half_width")?,
        radius: length("radius")?,
    };
    robot.mechanism().map_err(|error| at(&table.place, &error))
}

fn faulty(place: &Place, what: String) -> SetupError {
    SetupError::mismatch(place, Mismatch::Mechanism { what })
}

fn at(place: &Place, error: &MechanismError) -> SetupError {
    faulty(place, error.to_string())
}

/// The loops that a problem file closes in the tree of a robot file; `None` where it closes none.
///
/// # Errors
/// Unknown joints and frames; closed joints that do not hold the passive ones, or that cannot be closed near the
/// positions given.
pub fn of_tree(
    table: &RobotTable,
    tree: &Tree,
    names: &[String],
) -> Result<Option<Mechanism>, SetupError> {
    let Some(first) = table.closed.first() else {
        return match table.passive.first() {
            None => Ok(None),
            Some(joint) => Err(faulty(
                &joint.value.place,
                "joints without a motor need closed joints that hold them: list them as [[robot.closed]]"
                    .to_string(),
            )),
        };
    };
    let limits = tree.joints().iter().map(|joint| &joint.limits);
    let mut home: Vec<f64> = limits
        .map(|limits| match (limits.lower, limits.upper) {
            (Some(lower), Some(upper)) => 0.5 * (lower + upper),
            _ => 0.0,
        })
        .collect();
    let mut passive = Vec::with_capacity(table.passive.len());
    for joint in &table.passive {
        let Some(k) = tree.joint_index(&joint.name) else {
            return Err(unknown(&joint.value.place, &joint.name, names));
        };
        home[k] = joint.value.value;
        passive.push(k);
    }
    let conditions = table.closed.iter().map(|closed| condition(closed, tree));
    let conditions = conditions.collect::<Result<Vec<_>, _>>()?;
    Mechanism::new(tree.clone(), &passive, conditions, home)
        .map(Some)
        .map_err(|error| at(&first.frames.place, &error))
}

fn condition(closed: &ClosedTable, tree: &Tree) -> Result<Condition, SetupError> {
    let axis = Vector3::from(closed.axis.value);
    if axis.norm() == 0.0 {
        return Err(faulty(
            &closed.axis.place,
            "an axis has a direction".to_string(),
        ));
    }
    let mut ends = Vec::with_capacity(2);
    let mut axes = Vec::with_capacity(2);
    for name in &closed.frames.value {
        let Some((link, frame)) = tree.frame(name) else {
            let links = tree.joints().iter().map(|j| j.link.clone());
            let known = links.chain(tree.frames().iter().map(|f| f.name.clone()));
            let kind = Mismatch::UnknownFrame {
                found: name.clone(),
                known: known.collect(),
            };
            return Err(SetupError::mismatch(&closed.frames.place, kind));
        };
        ends.push(Anchor {
            link,
            point: frame.translation.vector,
        });
        axes.push(frame.rotation * axis.normalize());
    }
    let ends = [ends[0], ends[1]];
    Ok(match (closed.joint.value, &closed.length) {
        (ClosedJoint::Rod, Some(length)) => Condition::Rod {
            ends,
            length: length.value,
        },
        (ClosedJoint::Hinge, _) => Condition::Hinge {
            ends,
            axes: [axes[0], axes[1]],
        },
        _ => Condition::Ball { ends },
    })
}

/// What sensors at joints without a motor give, by joint, in rows of an experiment of the same recording.
#[derive(Debug, Clone, Default)]
pub struct Sensed {
    /// rad/s² (m/s²).
    pub accelerations: Vec<(usize, Vec<f64>)>,
    /// N·m (N), of the surroundings on the links.
    pub forces: Vec<(usize, Vec<f64>)>,
}

/// Reads the sensors at the joints without a motor and filters them like the motors' motion.
///
/// # Errors
/// An unknown joint or one with a motor; columns that are missing; recordings that are too short.
pub fn sensed(
    recording: &Recording,
    table: &RecordingsTable,
    (model, bandwidth): (&Model, &[Bandwidth]),
    experiment: &Experiment,
) -> Result<Sensed, SetupError> {
    let mut sensed = Sensed::default();
    for sensor in &table.sensors {
        let joint = passive_joint(sensor, model)?;
        let (column, list) = match &sensor.value.value {
            SensorTable::Force(column) => (column, &mut sensed.forces),
            SensorTable::Position(column) | SensorTable::Acceleration(column) => {
                (column, &mut sensed.accelerations)
            }
        };
        let mut series = read_further(
            &recording.file,
            std::slice::from_ref(column),
            &table.reading,
        )?;
        if let Some(held) = &recording.held {
            for series in &mut series {
                *series = held.rows.iter().map(|&row| series[row]).collect();
            }
        }
        let measured = matches!(sensor.value.value, SensorTable::Acceleration(_));
        let alone = Recording {
            acceleration: measured.then(|| series.clone()),
            signal: series.clone(),
            position: series,
            velocity: None,
            temperature: None,
            ..recording.clone()
        };
        let mut settings: Preparation = preparation(table);
        settings.differentiation.parallel_hz = None;
        if experiment.periods.is_none() {
            let widest = bandwidth.iter().map(|b| b.cutoff_hz).fold(0.0, f64::max);
            settings.differentiation.cutoff_hz = Some(widest);
        }
        let filtered = prepare(alone, &settings)?;
        // Both grids are those of the recording, with edges of their own.
        let skip = ((experiment.t[0] - filtered.t[0]) * experiment.rate_hz).round() as usize;
        let rows = skip..skip + experiment.rows();
        let series = match &sensor.value.value {
            SensorTable::Force(_) => &filtered.signal[0],
            _ => &filtered.motion.acceleration[0],
        };
        match series.get(rows) {
            Some(rows) => list.push((joint, rows.to_vec())),
            None => {
                let what = format!("the rows of {column} are not those of the motors");
                return Err(faulty(&sensor.value.place, what));
            }
        }
    }
    Ok(sensed)
}

fn passive_joint(sensor: &Named<SensorTable>, model: &Model) -> Result<usize, SetupError> {
    let passive = model.mechanism().map_or(&[][..], |m| m.passive());
    let joints = model.tree().joints();
    let found = passive.iter().find(|&&k| joints[k].name == sensor.name);
    found.copied().ok_or_else(|| {
        let names: Vec<String> = passive.iter().map(|&k| joints[k].name.clone()).collect();
        let what = format!(
            "sensors are at joints without a motor, and `{}` is none; they are: {}",
            sensor.name,
            names.join(", ")
        );
        faulty(&sensor.value.place, what)
    })
}

/// Gives the joints without a motor the motion that the loops ask for; sensors replace accelerations. What
/// the periods say of noise is dropped: it is of the motors alone.
///
/// # Errors
/// A row at which the loops stay open or are not held.
pub fn complete(
    experiment: &mut Experiment,
    mechanism: &Mechanism,
    sensed: &Sensed,
) -> Result<(), RecordingError> {
    let rows = experiment.rows();
    let Motion {
        position,
        velocity,
        acceleration,
    } = &mut experiment.motion;
    mechanism
        .complete_motion([position, velocity, acceleration], 0..rows)
        .map_err(|open| RecordingError {
            place: Place::file(&experiment.file)
                .key(format!("t = {:.4} s", experiment.t[open.sample])),
            kind: RecordingErrorKind::NoMotion {
                reason: open.error.to_string(),
            },
        })?;
    for (joint, series) in &sensed.accelerations {
        experiment.motion.acceleration[*joint].clone_from(series);
    }
    experiment.noise = None;
    Ok(())
}
