//! The recordings of a problem file: read, made ready, and brought to motor coordinates at joint scale.
//!
//! ```text
//! position_side = "joint"   m = V⁻¹ (q_enc − offset)                  signal "motor_torque"   τ = ratio · τ_rec
//! position_side = "motor"   m = q_enc / ratio
//! position_side = "link"    m = V⁻¹ (q_enc − offset)
//! ```

use crate::chain::controller::Commands;
use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::model::Model;
use crate::fault::Place;
use crate::problem_file::choices::{PositionSide, Signal};
use crate::problem_file::recordings::{ColumnsTable, RecordingFiles};
use crate::problem_file::{FilePath, Located, ProblemFile, RecordingsTable};
use crate::recording::apart::read_apart;
use crate::recording::clock::evened;
use crate::recording::column_map::{Column, ColumnMap};
use crate::recording::columns::{RecordedJoint, read_within};
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::experiment::{Bandwidth, Experiment, Noise};
use crate::recording::held::thinned;
use crate::recording::join::{Source, read_joined};
use crate::recording::preprocess::prepare;
use crate::recording::samples::{Commanded, Recording};
use crate::recording::settings::Preparation;
use crate::recording::split::Split;
use crate::setup::error::{Mismatch, SetupError};
use crate::setup::preparation::preparation;
use crate::setup::read::{Named, Read};
use crate::setup::robot::Robot;
use crate::setup::sensed;
use crate::setup::shared_rows::shared_rows;
use nalgebra::{DMatrix, DVector};

/// Reads every recording of a problem file.
///
/// Errors: those of the files; rows that are given twice.
pub fn read_all<'a>(problem: &'a ProblemFile, robot: &Robot) -> Result<Vec<Read<'a>>, SetupError> {
    let table = problem.recordings()?;
    let read = |named: Named<'a>| -> Result<Read<'a>, SetupError> {
        let recording = read_one(table, robot, named.path)?;
        Ok(Read { named, recording })
    };
    let read = list(table).into_iter().map(read);
    let read = read.collect::<Result<Vec<_>, _>>()?;
    match shared_rows(table, &read).into_iter().next() {
        Some(shared) => Err(shared.into()),
        None => Ok(read),
    }
}

/// Makes every recording of a problem file ready, those that do not repeat with a bandwidth in common where one is given.
pub fn prepare_all(
    problem: &ProblemFile,
    robot: &Robot,
    model: &Model,
    read: Vec<Read<'_>>,
    common_hz: Option<f64>,
) -> Result<Dataset, SetupError> {
    let table = problem.recordings()?;
    let mut settings = preparation(table);
    settings.differentiation.common_hz = common_hz;
    let mut dataset = Dataset::default();
    for Read { named, recording } in read {
        let ready = prepared(recording, &named, &settings, (table, robot, model))?;
        dataset.recordings.push(ready);
    }
    Ok(dataset)
}

/// Reads and prepares every recording of a problem file.
pub fn open(problem: &ProblemFile, robot: &Robot, model: &Model) -> Result<Dataset, SetupError> {
    prepare_all(problem, robot, model, read_all(problem, robot)?, None)
}

/// Makes one recording ready, in motor coordinates at joint scale.
pub fn prepare_one(
    recording: Recording,
    named: &Named<'_>,
    (table, robot, model): (&RecordingsTable, &Robot, &Model),
) -> Result<Prepared, SetupError> {
    prepared(recording, named, &preparation(table), (table, robot, model))
}

fn prepared(
    recording: Recording,
    named: &Named<'_>,
    settings: &Preparation,
    (table, robot, model): (&RecordingsTable, &Robot, &Model),
) -> Result<Prepared, SetupError> {
    let commanded = recording.commanded;
    let kept = robot.mechanism.is_some().then(|| recording.clone());
    let experiment = prepare(recording, settings).map_err(|e| at_request(table, named.path, e))?;
    let (experiment, commands) = without_commands(experiment, commanded, (table, robot, model))?;
    let mut experiment = to_motors(experiment, (table, robot, model))?;
    let mut forces = Vec::new();
    if let (Some(mechanism), Some(recording)) = (&robot.mechanism, kept) {
        let bandwidth = experiment.bandwidth.clone();
        let sensed = sensed::sensed(&recording, table, (model, &bandwidth), &experiment)?;
        sensed::complete(&mut experiment, mechanism, &sensed)?;
        forces = sensed.forces;
    }
    let (name, split) = (named.path.written.clone(), named.split);
    let prepared = Prepared::new(name, split, named.loaded, experiment);
    Ok(prepared.with_forces(&forces).with_commands(commands))
}

/// The recordings in the order of the problem file; one that is listed twice counts once. A load, where the
/// model has one, hangs on the robot in those that are listed as loaded, and in all if none is.
pub fn list(table: &RecordingsTable) -> Vec<Named<'_>> {
    let listed = |path: &FilePath| {
        let mut loaded = table.loaded.iter();
        loaded.any(|l| l.value.resolved == path.resolved)
    };
    let loaded = |path: &FilePath| table.loaded.is_empty() || listed(path);
    let mut named: Vec<Named<'_>> = Vec::new();
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
                named.push(Named {
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
    let apart = table.positions.iter().find(|p| p.name == path.written);
    let sources: Vec<Source<'_>> = (path.files.iter().zip(&maps))
        .map(|(file, map)| Source {
            path: &file.path.resolved,
            map,
        })
        .collect();
    let recording = match (apart, &sources[..]) {
        (Some(positions), [Source { map, .. }, ..]) => {
            let files = (
                path.resolved.as_path(),
                positions.value.value.resolved.as_path(),
            );
            read_apart(files, map, &joints, (kind, reading))
        }
        (None, [Source { path, map }]) => read_within(path, map, &joints, (kind, reading)),
        _ => read_joined(&sources, &joints, (kind, reading)),
    };
    let rate = table.rate.as_ref().map(|rate| rate.value);
    let recording = recording.map(|recording| match kind {
        Signal::PositionCommand => recording.with_position_errors(),
        _ => recording,
    });
    let recording = recording.and_then(|recording| thinned(recording, rate));
    let recording = recording.map(evened);
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

/// Factors from recorded positions and signals to joint scale.
struct Scale {
    position: Vec<f64>,
    signal: Vec<f64>,
}

fn scale(table: &RecordingsTable, ratio: Option<Vec<f64>>, n: usize) -> Result<Scale, SetupError> {
    let needs = |place| SetupError::mismatch(place, Mismatch::NeedsRatio);
    let motor = table.position_side.value == PositionSide::Motor;
    let torque = table.signal.value == Signal::MotorTorque;
    if ratio.is_none() && motor {
        return Err(needs(&table.position_side.place));
    }
    if ratio.is_none() && torque {
        return Err(needs(&table.signal.place));
    }
    let ratio = ratio.unwrap_or_else(|| vec![1.0; n]);
    let one = vec![1.0; n];
    Ok(Scale {
        position: if motor {
            ratio.iter().map(|r| 1.0 / r).collect()
        } else {
            one.clone()
        },
        signal: match (torque, table.signal.value) {
            (true, _) => ratio,
            (false, Signal::PositionCommand) if motor => ratio.iter().map(|r| 1.0 / r).collect(),
            _ => one,
        },
    })
}

/// Takes what controllers are told beside the position out of the signal of an experiment of the moving joints, for all
/// motors at joint scale.
fn without_commands(
    mut experiment: Experiment,
    commanded: Commanded,
    (table, robot, model): (&RecordingsTable, &Robot, &Model),
) -> Result<(Experiment, Option<Commands>), SetupError> {
    if table.signal.value != Signal::PositionCommand || commanded == Commanded::default() {
        return Ok((experiment, None));
    }
    let n = robot.tree.len();
    let moving: Vec<usize> = (0..n).filter(|&k| robot.locked[k].is_none()).collect();
    let rows = experiment.rows();
    let mut series = experiment.signal.split_off(moving.len()).into_iter();
    experiment.raw.signal.truncate(moving.len());
    experiment.white_noise.truncate(moving.len());
    if let Some(noise) = &mut experiment.noise {
        let covariance = &noise.signal_covariance;
        noise.signal_covariance = covariance.view((0, 0), (moving.len(), moving.len())).into();
        noise.autocovariance.truncate(moving.len());
    }
    let mut of_motors = |there: bool| {
        let mut all = vec![vec![0.0; rows]; if there { n } else { 0 }];
        if there {
            for (&k, series) in moving.iter().zip(&mut series) {
                all[k] = series;
            }
        }
        all
    };
    let mut commands = Commands {
        velocity: of_motors(commanded.velocity),
        feed_forward: of_motors(commanded.feed_forward),
    };
    let scale = scale(table, robot.ratio.clone(), n)?;
    for (series, factor) in commands.velocity.iter_mut().zip(&scale.position) {
        multiply(series, *factor);
    }
    if commanded.velocity
        && table.position_side.value != PositionSide::Motor
        && let Some(inverse) = to_motors_of(model)
    {
        mix(&mut commands.velocity, &inverse);
    }
    Ok((experiment, Some(commands)))
}

/// Brings an experiment of the moving joints to all motors at joint scale; locked ones stand at zero.
fn to_motors(
    mut experiment: Experiment,
    (table, robot, model): (&RecordingsTable, &Robot, &Model),
) -> Result<Experiment, SetupError> {
    let n = robot.tree.len();
    let scale = scale(table, robot.ratio.clone(), n)?;
    let moving: Vec<usize> = (0..n).filter(|&k| robot.locked[k].is_none()).collect();
    spread(&mut experiment, &moving, n);
    for k in 0..n {
        let motion = &mut experiment.motion;
        for series in [
            &mut motion.position,
            &mut motion.velocity,
            &mut motion.acceleration,
        ] {
            multiply(&mut series[k], scale.position[k]);
        }
        if table.signal.value != Signal::BaseWrench {
            multiply(&mut experiment.signal[k], scale.signal[k]);
            multiply(&mut experiment.raw.signal[k], scale.signal[k]);
            if let Some(Some(noise)) = experiment.white_noise.get_mut(k) {
                *noise *= scale.signal[k].abs();
            }
        }
    }
    for k in 0..n {
        let size = scale.position[k].abs();
        if let Some(error) = &mut experiment.motion_error {
            for deviations in [
                &mut error.position,
                &mut error.velocity,
                &mut error.acceleration,
            ] {
                deviations[k] *= size;
            }
        }
        if let Some(noise) = &mut experiment.noise {
            noise.recorded_position_sd[k] *= size;
            if table.signal.value != Signal::BaseWrench {
                scale_channel(noise, k, scale.signal[k]);
            }
        }
    }
    if table.position_side.value != PositionSide::Motor {
        from_joints(&mut experiment, model);
        if table.signal.value == Signal::PositionCommand
            && let Some(inverse) = to_motors_of(model)
        {
            mix(&mut experiment.signal, &inverse);
            mix(&mut experiment.raw.signal, &inverse);
            experiment
                .white_noise
                .iter_mut()
                .for_each(|noise| *noise = None);
            if let Some(noise) = &mut experiment.noise {
                noise.signal_covariance = &inverse * &noise.signal_covariance * inverse.transpose();
            }
        }
    }
    Ok(experiment)
}

/// V⁻¹, where it is not the identity; joints that are locked stand still.
fn to_motors_of(model: &Model) -> Option<DMatrix<f64>> {
    let coupling = model.coupling(&model.values());
    let n = coupling.nrows();
    let inverse = coupling.try_inverse()?;
    (inverse != DMatrix::identity(n, n)).then_some(inverse)
}

/// Series of motors from those of joints.
fn mix(series: &mut [Vec<f64>], inverse: &DMatrix<f64>) {
    for row in 0..series.first().map_or(0, Vec::len) {
        let joints = DVector::from_iterator(series.len(), series.iter().map(|s| s[row]));
        let motors = inverse * joints;
        for (series, motor) in series.iter_mut().zip(motors.iter()) {
            series[row] = *motor;
        }
    }
}

fn multiply(series: &mut [f64], factor: f64) {
    if factor != 1.0 {
        series.iter_mut().for_each(|x| *x *= factor);
    }
}

fn scale_channel(noise: &mut Noise, channel: usize, factor: f64) {
    for k in 0..noise.signal_covariance.nrows() {
        noise.signal_covariance[(channel, k)] *= factor;
        noise.signal_covariance[(k, channel)] *= factor;
    }
    multiply(&mut noise.autocovariance[channel], factor * factor);
}

/// Puts the series of the moving joints at their places among all joints, zeros at the others.
fn spread(experiment: &mut Experiment, moving: &[usize], n: usize) {
    if moving.len() == n {
        return;
    }
    let rows = experiment.rows();
    let samples = experiment.raw.t.len();
    let place = |series: &mut Vec<Vec<f64>>, length: usize| {
        let extra = series.split_off(series.len().min(moving.len()));
        let mut all = vec![vec![0.0; length]; n];
        for (from, &k) in std::mem::take(series).into_iter().zip(moving) {
            all[k] = from;
        }
        all.extend(extra);
        *series = all;
    };
    let torques = experiment.signal.len() != 6 || moving.len() == 6;
    place(&mut experiment.motion.position, rows);
    place(&mut experiment.motion.velocity, rows);
    place(&mut experiment.motion.acceleration, rows);
    if torques {
        place(&mut experiment.signal, rows);
        place(&mut experiment.raw.signal, samples);
        spread_white_noise(&mut experiment.white_noise, moving, n);
    }
    let mut bandwidth: Vec<Bandwidth> = Vec::with_capacity(n);
    for k in 0..n {
        let at = moving.iter().position(|&m| m == k).unwrap_or(0);
        bandwidth.push(experiment.bandwidth[at]);
    }
    experiment.bandwidth = bandwidth;
    let all = |deviations: &mut Vec<f64>| {
        let mut all = vec![0.0; n];
        for (from, &k) in deviations.iter().zip(moving) {
            all[k] = *from;
        }
        *deviations = all;
    };
    if let Some(error) = &mut experiment.motion_error {
        for deviations in [
            &mut error.position,
            &mut error.velocity,
            &mut error.acceleration,
        ] {
            all(deviations);
        }
    }
    if let Some(noise) = &mut experiment.noise {
        all(&mut noise.recorded_position_sd);
        if torques {
            spread_covariance(noise, moving, n);
        }
    }
}

fn spread_white_noise(white: &mut Vec<Option<f64>>, moving: &[usize], n: usize) {
    if white.is_empty() {
        return;
    }
    let extra = white.split_off(white.len().min(moving.len()));
    let mut all = vec![None; n];
    for (from, &k) in std::mem::take(white).into_iter().zip(moving) {
        all[k] = from;
    }
    all.extend(extra);
    *white = all;
}

fn spread_covariance(noise: &mut Noise, moving: &[usize], n: usize) {
    let old = &noise.signal_covariance;
    let extra = old.nrows() - moving.len();
    let places: Vec<usize> = moving.iter().copied().chain(n..n + extra).collect();
    let mut all = DMatrix::zeros(n + extra, n + extra);
    for (i, &to_i) in places.iter().enumerate() {
        for (j, &to_j) in places.iter().enumerate() {
            all[(to_i, to_j)] = old[(i, j)];
        }
    }
    let mut autocovariance = vec![Vec::new(); n + extra];
    for (from, &to) in std::mem::take(&mut noise.autocovariance)
        .into_iter()
        .zip(&places)
    {
        autocovariance[to] = from;
    }
    noise.signal_covariance = all;
    noise.autocovariance = autocovariance;
}

/// `m = V⁻¹ (q − offset)` for positions of the joints.
fn from_joints(experiment: &mut Experiment, model: &Model) {
    let n = model.tree().len();
    let coupling = model.coupling(&model.values());
    let identity = DMatrix::<f64>::identity(n, n);
    if coupling == identity && model.offset().iter().all(|o| *o == 0.0) {
        return;
    }
    // The model refuses a coupling that cannot be inverted.
    let inverse = coupling.try_inverse().unwrap_or(identity);
    let motion = &mut experiment.motion;
    let shift = model.offset().clone();
    let none = DVector::zeros(n);
    let series = [
        &mut motion.position,
        &mut motion.velocity,
        &mut motion.acceleration,
    ];
    for (series, shift) in series.into_iter().zip([&shift, &none, &none]) {
        for row in 0..series.first().map_or(0, Vec::len) {
            // The motor of a locked joint stands at zero; its offset is where the joint is held.
            let joints = DVector::from_fn(n, |j, _| match model.joints()[j].locked {
                true => 0.0,
                false => series[j][row] - shift[j],
            });
            let motors = &inverse * joints;
            for j in 0..n {
                series[j][row] = match model.joints()[j].locked {
                    true => 0.0,
                    false => motors[j],
                };
            }
        }
    }
}
