//! `[recordings]`: the files, what they hold, and how positions give velocities and accelerations.

use std::ops::Deref;

use crate::problem_file::choices::{DifferentiationMethod, PositionSide, Signal};
pub(crate) use crate::problem_file::columns::COLUMNS_KEYS;
pub use crate::problem_file::columns::ColumnsTable;
use crate::problem_file::context::Context;
use crate::problem_file::document::{Node, NodeValue};
use crate::problem_file::error::{KeyFault, NumberFault, ProblemFileError};
use crate::problem_file::key::{Form, Key, Length, REQUIRED, Range, words};
use crate::problem_file::located::{FilePath, Located, Named};
use crate::problem_file::reader::Reader;
use crate::problem_file::values;
use crate::recording::reading::Reading;

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
    Key { name: "period", form: Form::Number(Range::Positive), unit: "s", default: "found in the motion, where it repeats", example: "12.0", meaning: "The motion repeats after this time; recordings are averaged over periods of a whole number of samples, and take their noise from others" },
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
    /// What columns are called, and their units. Default: the usual names.
    pub columns: ColumnsTable,
    /// How positions give velocities and accelerations.
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
    /// Where it is.
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
    pub fn of_simulator(&self) -> Option<Self> {
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
