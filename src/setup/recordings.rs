//! The recordings of a problem file: read, made ready, and brought to motor coordinates at joint scale.

use crate::chain::dataset::{Dataset, Prepared};
use crate::fault::Place;
use crate::problem_file::choices::Signal;
use crate::problem_file::recordings::{ColumnsTable, RecordingFiles};
use crate::problem_file::{FilePath, Located, RecordingsTable};
use crate::recording::clock::evened;
use crate::recording::clock_drift::steadied;
use crate::recording::column_map::{Column, ColumnMap};
use crate::recording::columns::{RecordedJoint, read_within};
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::join::separate_encoder::{EncoderFiles, read_with_separate_encoder};
use crate::recording::join::{Source, read_joined};
use crate::recording::lost_signal::marked;
use crate::recording::preprocess::prepare;
use crate::recording::samples::Recording;
use crate::recording::settings::{InCommon, Preparation};
use crate::recording::split::Split;
use crate::recording::upsampling::thinned;
use crate::setup::error::SetupError;
use crate::setup::motor_side::{take_commands, to_motors};
use crate::setup::passive_joint_sensors;
use crate::setup::preparation::preparation;
use crate::setup::recording_file::{NamedRecording, ReadRecording, RecordedRobot};
use crate::setup::robot::Robot;
use crate::setup::shared_rows::shared_rows;

/// Reads every recording that a table lists.
///
/// Errors: those of the files; rows that are given twice.
pub fn read_all<'a>(
    table: &'a RecordingsTable,
    robot: &Robot,
) -> Result<Vec<ReadRecording<'a>>, SetupError> {
    let read = |named: NamedRecording<'a>| -> Result<ReadRecording<'a>, SetupError> {
        let recording = read_one(table, robot, named.path)?;
        Ok(ReadRecording { named, recording })
    };
    let read = list(table).into_iter().map(read);
    let read = read.collect::<Result<Vec<_>, _>>()?;
    match shared_rows(table, &read).into_iter().next() {
        Some(shared) => Err(shared.into()),
        None => Ok(read),
    }
}

/// Makes recordings of a robot ready, those that do not repeat with what their smoothers have in common.
pub fn prepare_all(
    recorded: RecordedRobot<'_>,
    read: Vec<ReadRecording<'_>>,
    in_common: InCommon,
) -> Result<Dataset, SetupError> {
    let mut settings = preparation(recorded.table);
    settings.differentiation.in_common = in_common;
    let mut dataset = Dataset::default();
    for ReadRecording { named, recording } in read {
        let ready = prepared(recording, &named, &settings, recorded)?;
        dataset.recordings.push(ready);
    }
    Ok(dataset)
}

/// Makes one recording ready, in motor coordinates at joint scale.
pub fn prepare_one(
    recording: Recording,
    named: &NamedRecording<'_>,
    recorded: RecordedRobot<'_>,
) -> Result<Prepared, SetupError> {
    prepared(recording, named, &preparation(recorded.table), recorded)
}

fn prepared(
    recording: Recording,
    named: &NamedRecording<'_>,
    settings: &Preparation,
    recorded: RecordedRobot<'_>,
) -> Result<Prepared, SetupError> {
    let RecordedRobot {
        table,
        robot,
        model,
    } = recorded;
    let commanded = recording.commanded;
    let kept = robot.mechanism.is_some().then(|| recording.clone());
    let prepared = prepare(recording, settings);
    let mut experiment = prepared.map_err(|e| at_request(table, named.path, e))?;
    let commands = take_commands(&mut experiment, commanded, recorded)?;
    let mut experiment = to_motors(experiment, recorded)?;
    let mut forces = Vec::new();
    if let (Some(mechanism), Some(recording)) = (&robot.mechanism, kept) {
        let bandwidth = experiment.bandwidth.clone();
        let sensed =
            passive_joint_sensors::sensed(&recording, table, model, &bandwidth, &experiment)?;
        passive_joint_sensors::complete(&mut experiment, mechanism, &sensed)?;
        forces = sensed.forces;
    }
    let (name, split) = (named.path.written.clone(), named.split);
    let prepared = Prepared::new(name, split, named.loaded, experiment);
    Ok(prepared.with_forces(&forces).with_commands(commands))
}

/// The recordings in the order of the problem file; one that is listed twice counts once. A load, where the
/// model has one, hangs on the robot in those that are listed as loaded, and in all if none is.
pub fn list(table: &RecordingsTable) -> Vec<NamedRecording<'_>> {
    let listed = |path: &FilePath| {
        let mut loaded = table.loaded.iter();
        loaded.any(|l| l.value.resolved == path.resolved)
    };
    let loaded = |path: &FilePath| table.loaded.is_empty() || listed(path);
    let mut named: Vec<NamedRecording<'_>> = Vec::new();
    let groups: [(&Vec<Located<RecordingFiles>>, Split); 3] = [
        (&table.train, Split::Train),
        (&table.loaded, Split::Train),
        (&table.validation, Split::Validation),
    ];
    for (paths, split) in groups {
        for path in paths {
            let known = named
                .iter()
                .any(|n| n.path.resolved == path.resolved && n.split == split);
            let held_out = table
                .validation
                .iter()
                .any(|v| v.value.resolved == path.resolved);
            // A recording with the load on may be held out: then it is not trained on.
            let skipped = split == Split::Train
                && held_out
                && table
                    .train
                    .iter()
                    .all(|t| t.value.resolved != path.resolved);
            if !known && !skipped {
                named.push(NamedRecording {
                    path: &path.value,
                    split,
                    loaded: loaded(path),
                });
            }
        }
    }
    named
}

/// The joints whose channels a recording holds: those that are not locked.
pub fn recorded_joints(robot: &Robot) -> Vec<RecordedJoint> {
    let all = RecordedJoint::all(&robot.order);
    let mut moving: Vec<(usize, RecordedJoint)> = robot.position.iter().copied().zip(all).collect();
    moving.sort_by_key(|(k, _)| *k);
    moving.retain(|(k, _)| robot.locked[*k].is_none());
    moving.into_iter().map(|(_, joint)| joint).collect()
}

/// Reads one recording, joints that move in the order of the tree.
pub fn read_one(
    table: &RecordingsTable,
    robot: &Robot,
    path: &RecordingFiles,
) -> Result<Recording, SetupError> {
    let (kind, reading) = (table.signal.value, &table.reading);
    let joints = recorded_joints(robot);
    let mut maps = Vec::with_capacity(path.files.len());
    for file in &path.files {
        let columns = file.columns.as_ref().unwrap_or(&table.columns);
        columns.check_one_per_joint(&robot.order)?;
        maps.push(column_map(columns));
    }
    let separate = table.positions.iter().find(|p| p.name == path.written);
    let sources: Vec<Source<'_>> = (path.files.iter().zip(&maps))
        .map(|(file, map)| Source {
            path: &file.path.resolved,
            map,
        })
        .collect();
    let recording = match (separate, &sources[..]) {
        (Some(positions), [Source { map, .. }, ..]) => {
            let files = EncoderFiles {
                signal: &path.resolved,
                positions: &positions.value.value.resolved,
            };
            read_with_separate_encoder(files, map, &joints, kind, reading)
        }
        (None, [Source { path, map }]) => read_within(path, map, &joints, kind, reading),
        _ => read_joined(&sources, &joints, kind, reading),
    };
    let rate = table.rate.as_ref().map(|rate| rate.value);
    let recording = recording.map(|recording| match kind {
        Signal::PositionCommand => recording.with_position_errors(),
        _ => recording,
    });
    let recording = recording.and_then(|recording| thinned(recording, rate));
    let recording = recording.map(evened).map(steadied);
    let recording = recording.map(|recording| marked(recording, kind));
    recording.map_err(|e| at_request(table, path, e))
}

/// A fault of what the problem file asks for, at its place there; other faults stay where they are.
fn at_request(
    table: &RecordingsTable,
    path: &RecordingFiles,
    mut error: RecordingError,
) -> SetupError {
    if error.kind.concerns_request() {
        let own = path.files.iter().find_map(|file| file.columns.as_ref());
        let columns = own.unwrap_or(&table.columns);
        error.place = place_of_request(table, columns, error.place.key.as_deref());
        if let RecordingErrorKind::InvalidSetting { requirement, .. } = &mut error.kind {
            requirement.push_str(&format!(" for {}", path.written));
        }
    }
    SetupError::from(error)
}

/// The place of a setting by the name that recordings give it; the whole table of columns if none fits.
fn place_of_request(table: &RecordingsTable, columns: &ColumnsTable, key: Option<&str>) -> Place {
    let settings = &table.differentiation;
    let texts = [
        ("time", &columns.time),
        ("position", &columns.position),
        ("velocity", &columns.velocity),
        ("acceleration", &columns.acceleration),
        ("current", &columns.current),
        ("torque", &columns.torque),
        ("command", &columns.command),
        ("velocity_command", &columns.velocity_command),
        ("feed_forward", &columns.feed_forward),
        ("temperature", &columns.temperature),
        ("mask", &columns.mask),
    ];
    let numbers = [
        ("rate", &table.rate),
        ("period", &table.period),
        ("cutoff_hz", &settings.cutoff_hz),
        ("parallel_hz", &settings.parallel_hz),
    ];
    let texts = texts.map(|(name, entry)| (name, entry.as_ref().map(|e| &e.place)));
    let numbers = numbers.map(|(name, entry)| (name, entry.as_ref().map(|e| &e.place)));
    let mut places = texts.into_iter().chain(numbers);
    match places.find(|(name, place)| Some(*name) == key && place.is_some()) {
        Some((_, Some(place))) => place.clone(),
        _ => Place::file(&table.signal.place.file).key("recordings.columns"),
    }
}

fn column_map(columns: &ColumnsTable) -> ColumnMap {
    let given = |entry: &Option<Located<Column>>| entry.as_ref().map(|e| e.value.clone());
    ColumnMap {
        time: given(&columns.time),
        position: given(&columns.position),
        velocity: given(&columns.velocity),
        acceleration: given(&columns.acceleration),
        current: given(&columns.current),
        torque: given(&columns.torque),
        command: given(&columns.command),
        velocity_command: given(&columns.velocity_command),
        feed_forward: given(&columns.feed_forward),
        wrench: columns.wrench.as_ref().map(|e| e.value.clone()),
        temperature: given(&columns.temperature),
        mask: given(&columns.mask),
    }
}
