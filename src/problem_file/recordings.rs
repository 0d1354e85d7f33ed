//! `[recordings]`: the files, what they hold, and how positions give velocities and accelerations.

use std::ops::Deref;

use crate::problem_file::choices::{DifferentiationMethod, PositionSide, Signal};
use crate::problem_file::context::Context;
use crate::problem_file::document::{Node, NodeValue};
use crate::problem_file::error::{KeyFault, NumberFault, ProblemFileError, ValueFault};
use crate::problem_file::key::{Form, Key, Length, REQUIRED, Range, words};
use crate::problem_file::located::{FilePath, Located, Named, check_length};
use crate::problem_file::reader::Reader;
use crate::problem_file::values;
use crate::recording::column_map::{Column, ColumnsAt, Factors};
use crate::recording::reading::Reading;
use crate::recording::units::{self, Quantity};

/// Keys of `[recordings]`.
#[rustfmt::skip]
pub(crate) const KEYS: &[Key] = &[
    Key { name: "train", form: RECORDINGS, unit: "", default: "required, unless there are loaded ones", example: "[\"train.csv\"]", meaning: "Recordings that are fitted" },
    Key { name: "validation", form: RECORDINGS, unit: "", default: "[]", example: "[\"validation.csv\"]", meaning: "Recordings that are held out; without them held-out figures are null" },
    Key { name: "loaded", form: RECORDINGS, unit: "", default: "[]", example: "[\"with_load.csv\"]", meaning: "Recordings that are fitted with the load on; the others are then without it. Needs robot.payload; where none is listed, every recording carries the load" },
    Key { name: "simulated", form: RECORDINGS, unit: "", default: "[]", example: "[\"sim.csv\"]", meaning: "Recordings of a simulator of the robot, of the same or other motions, with time stamps: it is identified first, and what differs from the robot is reported" },
    Key { name: "signal", form: Form::Words(words::<Signal>), unit: "", default: "\"current\"", example: "\"torque\"", meaning: "What the recordings hold: motor currents, motor torques at the joint side or at the motor side, torques of sensors behind the gears, the force and moment under the base, torques and those, or what a position controller is told, from whose error and gains the torque follows" },
    Key { name: "position_side", form: Form::Words(words::<PositionSide>), unit: "", default: "\"joint\"", example: "\"motor\"", meaning: "Where the encoder sits: on the motor in joint units, on the motor in its own turns, or behind the gear" },
    Key { name: "rate", form: Form::Number(Range::Positive), unit: "Hz", default: "from the time stamps", example: "200.0", meaning: "Samples per second" },
    Key { name: "period", form: Form::Number(Range::Positive), unit: "s", default: "found in the motion, where it repeats", example: "12.0", meaning: "The motion repeats after this time; recordings are averaged over their periods" },
    Key { name: "columns", form: Form::Table(COLUMNS_KEYS), unit: "", default: "the usual names", example: "", meaning: "Names of columns, in which {joint} stands for the joint's name and {n} for its number from 1, or tables with column and unit" },
    Key { name: "differentiation", form: Form::Table(DIFFERENTIATION_KEYS), unit: "", default: "the keys' own defaults", example: "", meaning: "How positions give velocities and accelerations" },
    Key { name: "platform", form: Form::Table(PLATFORM_KEYS), unit: "", default: "it reads in the base frame", example: "", meaning: "The sensor of a base wrench" },
    Key { name: "sensors", form: Form::NamedTables(SENSOR_KEYS), unit: "", default: "their motion follows from the motors", example: "", meaning: "What is measured at a joint without a motor: one of these" },
    Key { name: "positions", form: Form::Named(&Form::File), unit: "", default: "positions are in the recordings", example: "{ \"train.csv\" = \"camera.csv\" }", meaning: "Files with the positions of a sensor of its own, by recording, with time stamps of the same clock" },
    Key { name: "max_rows", form: Form::Count(1), unit: "", default: "ten million", example: "500000", meaning: "Rows of a file beyond which it is refused" },
];

/// Keys of an entry of `[recordings.sensors]`.
#[rustfmt::skip]
pub(crate) const SENSOR_KEYS: &[Key] = &[
    Key { name: "position", form: Form::Text, unit: "rad (m)", default: "one of position, acceleration and force is required", example: "\"encoder3\"", meaning: "Column of a position, differentiated twice" },
    Key { name: "acceleration", form: Form::Text, unit: "rad/s² (m/s²)", default: "one of position, acceleration and force is required", example: "\"acc3\"", meaning: "Column of an acceleration" },
    Key { name: "force", form: Form::Text, unit: "N·m (N)", default: "one of position, acceleration and force is required", example: "\"force3\"", meaning: "Column of what the surroundings exert on the joint's link along the joint" },
];

/// Keys of `[recordings.platform]`.
#[rustfmt::skip]
pub(crate) const PLATFORM_KEYS: &[Key] = &[
    Key { name: "translation", form: Form::List(&Form::Number(Range::Finite), Length::Exactly(3)), unit: "m", default: "[0.0, 0.0, 0.0]", example: "[0.0, 0.0, -0.1]", meaning: "Origin of the sensor's frame in the base frame" },
    Key { name: "rotation", form: Form::List(&Form::Number(Range::Finite), Length::Exactly(3)), unit: "rad", default: "[0.0, 0.0, 0.0]", example: "[0.0, 0.0, 1.5708]", meaning: "Roll, pitch and yaw of the sensor's axes in the base frame" },
    Key { name: "accuracy", form: Form::Number(Range::Positive), unit: "", default: "none", example: "0.01", meaning: "Standard deviation of a sample as share of its channel's root mean square: weights of ordinary least squares" },
    Key { name: "tare", form: Form::Boolean, unit: "", default: "false", example: "true", meaning: "What the platform reads without the robot is not known: six more unknowns" },
];

/// Keys of `[recordings.columns]`.
#[rustfmt::skip]
pub(crate) const COLUMNS_KEYS: &[Key] = &[
    Key { name: "time", form: Form::Either(&[Form::Text, Form::Table(TIME_KEYS)]), unit: "s", default: "\"t\" or \"time\"", example: "\"t\"", meaning: "Time stamps" },
    Key { name: "position", form: Form::Either(&[Form::Text, Form::Table(POSITION_KEYS)]), unit: "rad (m)", default: "the usual names", example: "\"q{n}\"", meaning: "Positions, or the motor's turns where position_side is \"motor\"" },
    Key { name: "velocity", form: Form::Either(&[Form::Text, Form::Table(VELOCITY_KEYS)]), unit: "rad/s (m/s)", default: "the usual names, if there", example: "\"dq{n}\"", meaning: "Velocities of the joints, by sensors or by the controller" },
    Key { name: "acceleration", form: Form::Either(&[Form::Text, Form::Table(ACCELERATION_KEYS)]), unit: "rad/s² (m/s²)", default: "the usual names, if there", example: "\"ddq{n}\"", meaning: "Accelerations of the joints" },
    Key { name: "current", form: Form::Either(&[Form::Text, Form::Table(CURRENT_KEYS)]), unit: "A", default: "the usual names", example: "\"i{n}\"", meaning: "Motor currents" },
    Key { name: "torque", form: Form::Either(&[Form::Text, Form::Table(TORQUE_KEYS)]), unit: "N·m (N)", default: "the usual names", example: "\"tau{n}\"", meaning: "Torques, on the side of the gear that recordings.signal says" },
    Key { name: "command", form: Form::Either(&[Form::Text, Form::Table(POSITION_KEYS)]), unit: "rad (m)", default: "the usual names", example: "\"q_cmd_{n}\"", meaning: "Commanded positions, for the signal \"position_command\"" },
    Key { name: "velocity_command", form: Form::Either(&[Form::Text, Form::Table(VELOCITY_KEYS)]), unit: "rad/s (m/s)", default: "the usual names, if there; otherwise the controller damps the speed itself", example: "\"dq_cmd_{n}\"", meaning: "Commanded speeds" },
    Key { name: "feed_forward", form: Form::Either(&[Form::Text, Form::Table(TORQUE_KEYS)]), unit: "N·m (N)", default: "the usual names, if there", example: "\"tau_ff_{n}\"", meaning: "Torques at the joint side that the controller adds" },
    Key { name: "wrench", form: Form::List(&Form::Text, Length::Exactly(6)), unit: "N, N·m", default: "fx, fy, fz, mx, my and mz", example: "[\"fx\", \"fy\", \"fz\", \"mx\", \"my\", \"mz\"]", meaning: "Forces along x, y, z, then moments" },
    Key { name: "temperature", form: Form::Either(&[Form::Text, Form::Table(BARE_KEYS)]), unit: "°C", default: "the usual names, if there", example: "\"temp{n}\"", meaning: "Temperatures of the drives" },
    Key { name: "mask", form: Form::Either(&[Form::Text, Form::Table(BARE_KEYS)]), unit: "", default: "every sample counts", example: "\"valid\"", meaning: "Samples with 0 are left out" },
];

/// Where the columns of a channel are.
const COLUMNS_AT: Form = Form::Either(&[
    Form::Text,
    Form::Count(1),
    Form::List(&Form::Text, Length::Some),
    Form::List(&Form::Count(1), Length::Some),
]);

/// Keys of a column of time stamps.
#[rustfmt::skip]
pub(crate) const TIME_KEYS: &[Key] = &[
    Key { name: "column", form: COLUMNS_AT, unit: "", default: REQUIRED, example: "1", meaning: "A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint" },
    Key { name: "unit", form: Form::Words(time_units), unit: "", default: "SI", example: "\"ms\"", meaning: "Unit of the stamps" },
];

/// Keys of a column of positions.
#[rustfmt::skip]
pub(crate) const POSITION_KEYS: &[Key] = &[
    Key { name: "column", form: COLUMNS_AT, unit: "", default: REQUIRED, example: "\"Winkel_{n}\"", meaning: "A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint" },
    Key { name: "unit", form: Form::Either(&[Form::Words(position_units), Form::List(&Form::Words(position_units), Length::Any)]), unit: "", default: "SI", example: "\"deg\"", meaning: "One for all joints, or one for each" },
    Key { name: "per_turn", form: Form::Number(Range::Positive), unit: "", default: "none", example: "65536", meaning: "Counts in a turn, for the unit \"count\"" },
];

/// Keys of a column of velocities.
#[rustfmt::skip]
pub(crate) const VELOCITY_KEYS: &[Key] = &[
    Key { name: "column", form: COLUMNS_AT, unit: "", default: REQUIRED, example: "[5, 6]", meaning: "A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint" },
    Key { name: "unit", form: Form::Either(&[Form::Words(velocity_units), Form::List(&Form::Words(velocity_units), Length::Any)]), unit: "", default: "SI", example: "\"rpm\"", meaning: "One for all joints, or one for each" },
];

/// Keys of a column of accelerations.
#[rustfmt::skip]
pub(crate) const ACCELERATION_KEYS: &[Key] = &[
    Key { name: "column", form: COLUMNS_AT, unit: "", default: REQUIRED, example: "\"acc_{n}\"", meaning: "A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint" },
    Key { name: "unit", form: Form::Either(&[Form::Words(acceleration_units), Form::List(&Form::Words(acceleration_units), Length::Any)]), unit: "", default: "SI", example: "\"deg/s^2\"", meaning: "One for all joints, or one for each" },
];

/// Keys of a column of currents.
#[rustfmt::skip]
pub(crate) const CURRENT_KEYS: &[Key] = &[
    Key { name: "column", form: COLUMNS_AT, unit: "", default: REQUIRED, example: "[\"left\", \"right\"]", meaning: "A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint" },
    Key { name: "unit", form: Form::Either(&[Form::Words(current_units), Form::List(&Form::Words(current_units), Length::Any)]), unit: "", default: "SI", example: "\"mA\"", meaning: "One for all joints, or one for each" },
];

/// Keys of a column of torques.
#[rustfmt::skip]
pub(crate) const TORQUE_KEYS: &[Key] = &[
    Key { name: "column", form: COLUMNS_AT, unit: "", default: REQUIRED, example: "\"M_{joint}\"", meaning: "A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint" },
    Key { name: "unit", form: Form::Either(&[Form::Words(torque_units), Form::List(&Form::Words(torque_units), Length::Any)]), unit: "", default: "SI", example: "\"mNm\"", meaning: "One for all joints, or one for each" },
];

/// Keys of a column without a unit.
#[rustfmt::skip]
pub(crate) const BARE_KEYS: &[Key] = &[
    Key { name: "column", form: COLUMNS_AT, unit: "", default: REQUIRED, example: "4", meaning: "A name, a number from 1, or a list of either, one for each joint" },
];

/// Keys of `[recordings.differentiation]`.
#[rustfmt::skip]
pub(crate) const DIFFERENTIATION_KEYS: &[Key] = &[
    Key { name: "method", form: Form::Words(words::<DifferentiationMethod>), unit: "", default: "\"fourier\" where the motion repeats, else \"smoother\"", example: "\"lowpass\"", meaning: "Fourier series of a periodic motion; a fixed-interval smoother; or a zero-phase Butterworth low-pass of fourth order" },
    Key { name: "cutoff_hz", form: Form::Number(Range::Positive), unit: "Hz", default: "chosen from the data", example: "10.0", meaning: "Cut-off frequency of the motion" },
    Key { name: "parallel_hz", form: Form::Number(Range::Positive), unit: "Hz", default: "none", example: "8.0", meaning: "Cut-off of a low-pass on the signal and on every column of the model alike" },
];

/// A list of recordings, each a file or a table.
const RECORDINGS: Form = Form::List(
    &Form::Either(&[Form::File, Form::Table(RECORDING_KEYS)]),
    Length::Distinct,
);

/// Keys of a recording that is a table.
#[rustfmt::skip]
pub(crate) const RECORDING_KEYS: &[Key] = &[
    Key { name: "file", form: Form::File, unit: "", default: "none; this or files is required", example: "\"train.csv\"", meaning: "The file of the recording" },
    Key { name: "files", form: Form::List(&Form::Either(&[Form::File, Form::Table(FILE_KEYS)]), Length::Some), unit: "", default: "none; this or file is required", example: "[\"positions.csv\", \"currents.csv\"]", meaning: "Files that are joined by their time stamps, on the clock of the first" },
    Key { name: "columns", form: Form::Table(COLUMNS_KEYS), unit: "", default: "those of recordings.columns", example: "", meaning: "What its columns are called" },
];

/// Keys of one of several files of a recording.
#[rustfmt::skip]
pub(crate) const FILE_KEYS: &[Key] = &[
    Key { name: "file", form: Form::File, unit: "", default: REQUIRED, example: "\"currents.csv\"", meaning: "One of the files" },
    Key { name: "columns", form: Form::Table(COLUMNS_KEYS), unit: "", default: "those of the recording", example: "", meaning: "What its columns are called" },
];

/// The table `[recordings]`.
#[derive(Debug, Clone)]
pub struct RecordingsTable {
    /// Training recordings without `loaded`. Required unless there are `loaded` ones.
    pub train: Vec<Located<RecordingFiles>>,
    /// Default: none; held-out figures are then null.
    pub validation: Vec<Located<RecordingFiles>>,
    /// Training recordings with the load on; the others are then without it. Default: none, every
    /// recording carries the load.
    pub loaded: Vec<Located<RecordingFiles>>,
    /// Recordings of a simulator of the robot. Default: none.
    pub simulated: Vec<Located<RecordingFiles>>,
    /// Default: [`Signal::Current`].
    pub signal: Located<Signal>,
    /// Default: [`PositionSide::Joint`].
    pub position_side: Located<PositionSide>,
    /// Hz, positive. Default: from the time stamps.
    pub rate: Option<Located<f64>>,
    /// s, positive. Default: not periodic.
    pub period: Option<Located<f64>>,
    pub columns: ColumnsTable,
    pub differentiation: DifferentiationTable,
    /// The sensor of a base wrench. Default: it reads in the base frame.
    pub platform: Option<PlatformTable>,
    /// What is measured at joints without a motor, by joint. Default: nothing; their motion follows from the
    /// motors.
    pub sensors: Vec<Named<SensorTable>>,
    /// Files with the positions of a sensor of its own, by recording as it is written under `train`, `loaded` or
    /// `validation`; with time stamps of the same clock. Default: positions are in the recordings.
    pub positions: Vec<Named<FilePath>>,
    /// Bounds of what is read; `recordings.max_rows` is one of them. Default: [`Reading::default`].
    pub reading: Reading,
}

/// An entry of `train`, `validation` or `loaded`: a recording in a file, or in several that are joined by time.
#[derive(Debug, Clone)]
pub struct RecordingFiles {
    /// The first file, under the names of all.
    pub path: FilePath,
    /// At least one.
    pub files: Vec<RecordingFile>,
}

impl Deref for RecordingFiles {
    type Target = FilePath;

    fn deref(&self) -> &FilePath {
        &self.path
    }
}

/// A file of a recording.
#[derive(Debug, Clone)]
pub struct RecordingFile {
    pub path: FilePath,
    /// In the place of `[recordings.columns]`. Default: that table.
    pub columns: Option<ColumnsTable>,
}

impl RecordingFiles {
    /// A list of recordings, each once.
    fn list(node: &Node, context: &Context) -> Result<Vec<Located<Self>>, ProblemFileError> {
        let entry = |node: &Node| {
            Ok(Located {
                value: Self::from_node(node, context)?,
                place: node.place.clone(),
            })
        };
        let entries = values::items(node, "a list of files such as [\"train.csv\"]")?;
        let entries: Vec<Located<Self>> = entries.iter().map(entry).collect::<Result<_, _>>()?;
        let names: Vec<Located<String>> = entries
            .iter()
            .map(|entry| Located {
                value: entry.path.written.clone(),
                place: entry.place.clone(),
            })
            .collect();
        values::check_no_duplicates(names.iter())?;
        Ok(entries)
    }

    fn from_node(node: &Node, context: &Context) -> Result<Self, ProblemFileError> {
        let files = match &node.value {
            NodeValue::Table(_) => {
                let reader = Reader::open(node, RECORDING_KEYS)?;
                reader.at_most_one(&["file", "files"])?;
                match reader.node("files") {
                    Some(list) => {
                        let columns = reader.node("columns").map(ColumnsTable::from_node);
                        let columns = columns.transpose()?;
                        let files =
                            values::items(list, "a list of files such as [\"a.csv\", \"b.csv\"]")?;
                        let mut files = files
                            .iter()
                            .map(|node| RecordingFile::from_node(node, context))
                            .collect::<Result<Vec<_>, _>>()?;
                        for file in &mut files {
                            file.columns = file.columns.take().or_else(|| columns.clone());
                        }
                        if files.is_empty() {
                            return Err(values::wrong_type(list, "a list of at least one file"));
                        }
                        files
                    }
                    None => vec![RecordingFile::from_node(node, context)?],
                }
            }
            _ => vec![RecordingFile::from_node(node, context)?],
        };
        let written: Vec<&str> = files.iter().map(|f| f.path.written.as_str()).collect();
        let path = FilePath {
            written: written.join(" + "),
            resolved: files[0].path.resolved.clone(),
        };
        Ok(Self { path, files })
    }
}

impl RecordingFile {
    /// A path, or a table with the path and the columns.
    fn from_node(node: &Node, context: &Context) -> Result<Self, ProblemFileError> {
        if !matches!(node.value, NodeValue::Table(_)) {
            return Ok(Self {
                path: values::file_path(node, context)?,
                columns: None,
            });
        }
        let reader = Reader::open(node, FILE_KEYS)?;
        let remedy = "name the file: { file = \"train.csv\", columns = { ... } }";
        let path = reader.required("file", remedy, |n| values::file_path(n, context))?;
        let columns = reader.node("columns").map(ColumnsTable::from_node);
        Ok(Self {
            path: path.value,
            columns: columns.transpose()?,
        })
    }
}

/// An entry of `[recordings.sensors]`: the column of a sensor at a joint without a motor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SensorTable {
    /// rad (m), differentiated twice: its acceleration.
    Position(String),
    /// rad/s² (m/s²).
    Acceleration(String),
    /// N·m (N), that the surroundings exert on the joint's link along the joint.
    Force(String),
}

/// The table `[recordings.platform]`: the sensor of the force and moment under the base.
#[derive(Debug, Clone, PartialEq)]
pub struct PlatformTable {
    /// Origin of the sensor's frame in the base frame, m. Default: the origin.
    pub translation: [f64; 3],
    /// Roll, pitch and yaw of the sensor's axes in the base frame, rad. Default: the base frame's.
    pub rotation: [f64; 3],
    /// Standard deviation of a sample as share of its channel's root mean square, the weights of the
    /// ordinary estimator. Default: none.
    pub accuracy: Option<f64>,
    /// What the platform reads without the robot is not known: six more unknowns. Default: false.
    pub tare: bool,
}

/// The table `[recordings.columns]`: names of columns or channels, in which `{joint}` stands for
/// the joint's name and `{n}` for its number from 1, or tables `{ column = …, unit = … }`. Every key
/// is optional; an absent one leaves
/// the name to the reader of recordings.
#[derive(Debug, Clone)]
pub struct ColumnsTable {
    /// s.
    pub time: Option<Located<Column>>,
    /// rad (m), or the motor's turns in rad.
    pub position: Option<Located<Column>>,
    /// rad/s (m/s).
    pub velocity: Option<Located<Column>>,
    /// rad/s² (m/s²).
    pub acceleration: Option<Located<Column>>,
    /// A.
    pub current: Option<Located<Column>>,
    /// N·m (N).
    pub torque: Option<Located<Column>>,
    /// Commanded positions, rad (m).
    pub command: Option<Located<Column>>,
    /// Commanded speeds, rad/s (m/s).
    pub velocity_command: Option<Located<Column>>,
    /// Torques that are fed forward, N·m (N).
    pub feed_forward: Option<Located<Column>>,
    /// Forces along x, y, z in N, then moments in N·m.
    pub wrench: Option<Located<[String; 6]>>,
    /// °C.
    pub temperature: Option<Located<Column>>,
    /// Samples with 0 are left out.
    pub mask: Option<Located<Column>>,
}

/// The table `[recordings.differentiation]`.
#[derive(Debug, Clone)]
pub struct DifferentiationTable {
    /// Default: Fourier for periodic recordings, otherwise the smoother.
    pub method: Option<Located<DifferentiationMethod>>,
    /// Cut-off frequency, Hz, positive. Default: chosen from the data.
    pub cutoff_hz: Option<Located<f64>>,
    /// Cut-off of the low-pass on the signal and on every column of the model, Hz, positive.
    /// Default: none.
    pub parallel_hz: Option<Located<f64>>,
}

impl RecordingsTable {
    pub(super) fn from_node(node: &Node, context: &Context) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, KEYS)?;
        let files = |n: &Node| RecordingFiles::list(n, context);
        let table = Self {
            train: reader.list("train", files)?,
            validation: reader.list("validation", files)?,
            loaded: reader.list("loaded", files)?,
            simulated: reader.list("simulated", files)?,
            signal: reader.or("signal", Signal::Current, values::choice)?,
            position_side: reader.or("position_side", PositionSide::Joint, values::choice)?,
            rate: reader.optional("rate", values::positive)?,
            period: reader.optional("period", values::positive)?,
            columns: ColumnsTable::from_node(&reader.table("columns"))?,
            differentiation: DifferentiationTable::from_node(&reader.table("differentiation"))?,
            platform: reader
                .node("platform")
                .map(PlatformTable::from_node)
                .transpose()?,
            sensors: reader.named("sensors", SensorTable::from_node)?,
            positions: reader.named("positions", |n| values::file_path(n, context))?,
            reading: match reader.optional("max_rows", values::count)? {
                Some(rows) => Reading {
                    most_rows: rows.value,
                    ..Reading::default()
                },
                None => Reading::default(),
            },
        };
        if table.train.is_empty() && table.loaded.is_empty() {
            return Err(reader.missing("train", "list the training recordings"));
        }
        table.check_method()?;
        table.check_cutoffs()?;
        table.check_positions()?;
        table.check_simulated()?;
        Ok(table)
    }

    /// A recording is of the robot or of the simulator.
    fn check_simulated(&self) -> Result<(), ProblemFileError> {
        let of_robot = [&self.train, &self.loaded, &self.validation];
        let is_of_robot = |recording: &&Located<RecordingFiles>| {
            let mut all = of_robot.iter().flat_map(|group| group.iter());
            all.any(|own| own.value.resolved == recording.value.resolved)
        };
        match self.simulated.iter().find(is_of_robot) {
            None => Ok(()),
            Some(both) => Err(ProblemFileError::new(
                &both.place,
                KeyFault::Conflict {
                    found: format!(
                        "{} as a recording of the robot and of the simulator",
                        both.value.written
                    ),
                    remedy: "list it once: under simulated if a simulator made it".into(),
                },
            )),
        }
    }

    /// The same table for the simulator in the place of the robot; `None` without recordings of it. They have time stamps, by
    /// which the rate is theirs.
    pub(super) fn of_simulator(&self) -> Option<Self> {
        let has_any = !self.simulated.is_empty();
        has_any.then(|| Self {
            train: self.simulated.clone(),
            validation: Vec::new(),
            loaded: Vec::new(),
            simulated: Vec::new(),
            rate: None,
            ..self.clone()
        })
    }

    /// Positions belong to a recording.
    fn check_positions(&self) -> Result<(), ProblemFileError> {
        let groups = [&self.train, &self.loaded, &self.validation, &self.simulated];
        let listed = |name: &str| {
            groups
                .iter()
                .any(|g| g.iter().any(|p| p.files.len() == 1 && p.written == name))
        };
        match self.positions.iter().find(|p| !listed(&p.name)) {
            None => Ok(()),
            Some(stray) => Err(ProblemFileError::new(
                &stray.value.place,
                KeyFault::Conflict {
                    found: format!("positions of {}, which is no recording", stray.name),
                    remedy: "write the recording as it stands under train, loaded or validation, and positions of joined \
                             files among those"
                        .into(),
                },
            )),
        }
    }

    /// A Fourier series needs a period.
    fn check_method(&self) -> Result<(), ProblemFileError> {
        match &self.differentiation.method {
            Some(method)
                if method.value == DifferentiationMethod::Fourier && self.period.is_none() =>
            {
                Err(ProblemFileError::new(
                    &method.place,
                    KeyFault::Conflict {
                        found: "method \"fourier\" without a period".into(),
                        remedy: "state recordings.period, or use method = \"lowpass\"".into(),
                    },
                ))
            }
            _ => Ok(()),
        }
    }

    /// A cut-off lies below half the rate, where the rate is stated.
    fn check_cutoffs(&self) -> Result<(), ProblemFileError> {
        let Some(rate) = &self.rate else {
            return Ok(());
        };
        let table = &self.differentiation;
        for cutoff in [&table.cutoff_hz, &table.parallel_hz].into_iter().flatten() {
            if cutoff.value >= rate.value / 2.0 {
                return Err(ProblemFileError::new(
                    &cutoff.place,
                    NumberFault::CutoffAboveNyquist {
                        cutoff: cutoff.value,
                        rate: rate.value,
                    },
                ));
            }
        }
        Ok(())
    }
}

impl PlatformTable {
    fn from_node(node: &Node) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, PLATFORM_KEYS)?;
        let accuracy = reader.optional("accuracy", values::positive)?;
        Ok(Self {
            translation: reader.or("translation", [0.0; 3], values::vector3)?.value,
            rotation: reader.or("rotation", [0.0; 3], values::vector3)?.value,
            accuracy: accuracy.map(|share| share.value),
            tare: reader.or("tare", false, values::boolean)?.value,
        })
    }
}

impl SensorTable {
    fn from_node(node: &Node) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, SENSOR_KEYS)?;
        reader.at_most_one(&["position", "acceleration", "force"])?;
        if let Some(column) = reader.optional("acceleration", values::text)? {
            return Ok(Self::Acceleration(column.value));
        }
        if let Some(column) = reader.optional("force", values::text)? {
            return Ok(Self::Force(column.value));
        }
        let remedy = "name the sensor's column as position, acceleration or force";
        let column = reader.required("position", remedy, values::text)?;
        Ok(Self::Position(column.value))
    }
}

impl ColumnsTable {
    /// Checks that lists of columns and of units have an entry for each joint.
    ///
    /// # Errors
    /// `wrong-length`, where one has not.
    pub fn check_one_per_joint(&self, joints: &[String]) -> Result<(), ProblemFileError> {
        let given = [
            &self.position,
            &self.velocity,
            &self.acceleration,
            &self.current,
            &self.torque,
            &self.command,
            &self.velocity_command,
            &self.feed_forward,
            &self.temperature,
        ];
        for entry in given.into_iter().flatten() {
            let columns = match &entry.at {
                ColumnsAt::Pattern(_) => None,
                ColumnsAt::Names(names) => Some(names.len()),
                ColumnsAt::Numbers(numbers) => Some(numbers.len()),
            };
            let units = match &entry.factors {
                Factors::Same(_) => None,
                Factors::PerJoint(factors) => Some(factors.len()),
            };
            for found in columns.into_iter().chain(units) {
                check_length(found, joints, "", &entry.place)?;
            }
        }
        Ok(())
    }

    fn from_node(node: &Node) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, COLUMNS_KEYS)?;
        Ok(Self {
            time: reader.optional("time", |n| column(n, TIME_KEYS, Some(Quantity::Time)))?,
            position: reader.optional("position", |n| {
                column(n, POSITION_KEYS, Some(Quantity::Position))
            })?,
            velocity: reader.optional("velocity", |n| {
                column(n, VELOCITY_KEYS, Some(Quantity::Velocity))
            })?,
            acceleration: reader.optional("acceleration", |n| {
                column(n, ACCELERATION_KEYS, Some(Quantity::Acceleration))
            })?,
            current: reader.optional("current", |n| {
                column(n, CURRENT_KEYS, Some(Quantity::Current))
            })?,
            torque: reader
                .optional("torque", |n| column(n, TORQUE_KEYS, Some(Quantity::Torque)))?,
            command: reader.optional("command", |n| {
                column(n, POSITION_KEYS, Some(Quantity::Position))
            })?,
            velocity_command: reader.optional("velocity_command", |n| {
                column(n, VELOCITY_KEYS, Some(Quantity::Velocity))
            })?,
            feed_forward: reader.optional("feed_forward", |n| {
                column(n, TORQUE_KEYS, Some(Quantity::Torque))
            })?,
            wrench: reader.optional("wrench", |n| {
                values::array(
                    n,
                    "six names, of forces x, y, z and moments x, y, z",
                    values::text,
                )
            })?,
            temperature: reader.optional("temperature", |n| column(n, BARE_KEYS, None))?,
            mask: reader.optional("mask", |n| column(n, BARE_KEYS, None))?,
        })
    }
}

/// A channel by the pattern of its columns, or by a table with columns and unit.
fn column(
    node: &Node,
    keys: &[Key],
    quantity: Option<Quantity>,
) -> Result<Column, ProblemFileError> {
    if let NodeValue::Text(_) = node.value {
        return Ok(Column::from(values::text(node)?.as_str()));
    }
    if let (None, NodeValue::Table(table)) = (quantity, &node.value)
        && let Some(unit) = table.get("unit")
    {
        return Err(ProblemFileError::new(
            &unit.place,
            KeyFault::Conflict {
                found: "a unit of what has none".into(),
                remedy: "leave the unit out".into(),
            },
        ));
    }
    let reader = Reader::open(node, keys)?;
    let remedy = "name the column, or give its number from 1";
    let at = reader.required("column", remedy, columns_at)?.value;
    let per_turn = reader.optional("per_turn", values::positive)?;
    let unit = reader.node("unit");
    let Some(quantity) = quantity else {
        return Ok(Column {
            at,
            factors: Factors::SI,
        });
    };
    let listed = match unit.map(|node| &node.value) {
        Some(NodeValue::List(units)) => units.iter().collect(),
        _ => Vec::from_iter(unit),
    };
    let is_count =
        |node: &&Node| matches!(&node.value, NodeValue::Text(unit) if unit == units::COUNT);
    if let (Some(size), false) = (&per_turn, listed.iter().any(is_count)) {
        return Err(ProblemFileError::new(
            &size.place,
            KeyFault::Conflict {
                found: "per_turn without the unit \"count\"".into(),
                remedy: "say unit = \"count\", or leave per_turn out".into(),
            },
        ));
    }
    let factor = |node: &Node| factor(node, quantity, per_turn.as_ref());
    let factors = match unit {
        None => Factors::SI,
        Some(node) => match &node.value {
            NodeValue::List(_) if quantity == Quantity::Time => {
                return Err(values::wrong_type(node, "one unit"));
            }
            NodeValue::List(units) => {
                Factors::PerJoint(units.iter().map(factor).collect::<Result<_, _>>()?)
            }
            _ => Factors::Same(factor(node)?),
        },
    };
    Ok(Column { at, factors })
}

fn time_units() -> Vec<&'static str> {
    units::names(Quantity::Time)
}

fn position_units() -> Vec<&'static str> {
    units::names(Quantity::Position)
}

fn velocity_units() -> Vec<&'static str> {
    units::names(Quantity::Velocity)
}

fn acceleration_units() -> Vec<&'static str> {
    units::names(Quantity::Acceleration)
}

fn current_units() -> Vec<&'static str> {
    units::names(Quantity::Current)
}

fn torque_units() -> Vec<&'static str> {
    units::names(Quantity::Torque)
}

/// A pattern, a number, or a list of either, one for each joint.
fn columns_at(node: &Node) -> Result<ColumnsAt, ProblemFileError> {
    let is_text = |node: &Node| matches!(node.value, NodeValue::Text(_));
    match &node.value {
        NodeValue::Text(_) => Ok(ColumnsAt::Pattern(values::text(node)?)),
        NodeValue::List(items) if items.is_empty() => Err(values::wrong_type(
            node,
            "a name, a number, or a list of either",
        )),
        NodeValue::List(items) if items.iter().all(is_text) => {
            let names = items.iter().map(values::text);
            Ok(ColumnsAt::Names(names.collect::<Result<_, _>>()?))
        }
        NodeValue::List(items) => {
            let numbers = items.iter().map(values::count);
            Ok(ColumnsAt::Numbers(numbers.collect::<Result<_, _>>()?))
        }
        _ => Ok(ColumnsAt::Numbers(vec![values::count(node)?])),
    }
}

/// What turns a unit into SI.
fn factor(
    node: &Node,
    quantity: Quantity,
    per_turn: Option<&Located<f64>>,
) -> Result<f64, ProblemFileError> {
    let unit = values::text(node)?;
    match (
        per_turn,
        unit == units::COUNT && quantity == Quantity::Position,
    ) {
        (Some(per_turn), true) => Ok(units::of_counts(per_turn.value)),
        (None, true) => Err(ProblemFileError::new(
            &node.place,
            KeyFault::Conflict {
                found: "the unit \"count\" without its size".into(),
                remedy: "say how many counts make a turn: per_turn = 65536".into(),
            },
        )),
        (_, false) => units::factor(quantity, &unit).ok_or_else(|| {
            let known = units::names(quantity).into_iter().map(String::from);
            ProblemFileError::new(
                &node.place,
                ValueFault::UnknownWord {
                    noun: "unit",
                    code: "unknown-unit",
                    found: unit.clone(),
                    known: known.collect(),
                },
            )
        }),
    }
}

impl DifferentiationTable {
    fn from_node(node: &Node) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, DIFFERENTIATION_KEYS)?;
        Ok(Self {
            method: reader.optional("method", values::choice)?,
            cutoff_hz: reader.optional("cutoff_hz", values::positive)?,
            parallel_hz: reader.optional("parallel_hz", values::positive)?,
        })
    }
}
