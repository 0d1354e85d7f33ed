//! Sensors of joints without a motor, and the motion of these joints that the loops determine.

use crate::chain::model::Model;
use crate::fault::Place;
use crate::mechanism::loops::Mechanism;
use crate::problem_file::recordings::SensorTable;
use crate::problem_file::{Named, RecordingsTable};
use crate::recording::columns::read_further;
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::experiment::{Bandwidth, Experiment, Motion};
use crate::recording::preprocess::prepare;
use crate::recording::samples::Recording;
use crate::recording::settings::Preparation;
use crate::setup::error::{SetupError, faulty};
use crate::setup::preparation::preparation;

/// Reads the sensors at the joints without a motor and filters them like the motors' motion.
///
/// # Errors
/// An unknown joint or one with a motor; columns that are missing; recordings that are too short.
pub fn sensed(
    recording: &Recording,
    table: &RecordingsTable,
    model: &Model,
    bandwidth: &[Bandwidth],
    experiment: &Experiment,
) -> Result<SensorReadings, SetupError> {
    let mut sensed = SensorReadings::default();
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

pub(super) fn passive_joint(
    sensor: &Named<SensorTable>,
    model: &Model,
) -> Result<usize, SetupError> {
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
    sensed: &SensorReadings,
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

/// What sensors at joints without a motor give, by joint, in rows of an experiment of the same recording.
#[derive(Debug, Clone, Default)]
pub struct SensorReadings {
    /// rad/s² (m/s²).
    pub accelerations: Vec<(usize, Vec<f64>)>,
    /// N·m (N), of the surroundings on the links.
    pub forces: Vec<(usize, Vec<f64>)>,
}
