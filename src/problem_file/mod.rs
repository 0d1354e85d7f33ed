//! The problem file: TOML in, plain typed structs out, one struct per table.
//!
//! This layer knows the keys, their types and their ranges. What needs the robot (the number of
//! joints, the names of parameters) is checked later, by the layer that has it; every value that
//! can still turn out wrong is therefore a [`Located`] value, which knows its line and key. A program states a
//! problem without a file, by a [`builder`].

pub mod builder;
pub mod choices;
mod columns;
mod context;
pub mod controller;
pub mod design;
pub mod diagnose;
pub mod drive;
pub mod error;
pub mod fit;
pub mod law;
pub mod located;
pub mod recordings;
pub mod robot;
pub mod simulate;

mod document;
pub mod key;
mod overrides;
mod reader;
pub mod reference;
pub mod schema;
mod values;

#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use crate::fault::Place;
use crate::problem_file::context::Context;

pub use controller::ControllerTable;
pub use design::DesignTable;
pub use diagnose::DiagnoseTable;
pub use drive::DriveTable;
pub use error::{ProblemFileError, ProblemFileErrorKind};
pub use fit::FitTable;
pub use law::LawTable;
pub use located::{FilePath, Located, Named, PerJoint};
pub use recordings::RecordingsTable;
pub use robot::RobotTable;
pub use simulate::SimulateTable;

use document::{Node, NodeValue};
use error::KeyFault;
use key::{Form, Key, Length, REQUIRED};
use reader::Reader;

/// Keys of the top level of a problem file.
#[rustfmt::skip]
pub const KEYS: &[Key] = &[
    Key { name: "name", form: Form::Text, unit: "", default: "the file's name without extension", example: "\"arm6\"", meaning: "Name of the problem and of its results folder: letters, digits, spaces, \"-\", \"_\" and \".\"" },
    Key { name: "robot", form: Form::Table(robot::KEYS), unit: "", default: REQUIRED, example: "", meaning: "The kinematics, what is known of it, and what is to be estimated" },
    Key { name: "drive", form: Form::Table(drive::KEYS), unit: "", default: "a rigid body without losses", example: "", meaning: "The motors, what is known of them, and the physics between motor and joint; lists have one value per joint and belong to the motor with that joint's index" },
    Key { name: "recordings", form: Form::Table(recordings::KEYS), unit: "", default: "nothing is read", example: "", meaning: "The files, what they hold, and how positions give velocities and accelerations" },
    Key { name: "controller", form: Form::Table(controller::KEYS), unit: "", default: "the keys' own defaults", example: "", meaning: "The position controllers, where recordings.signal is \"position_command\": torque = kp·(command − position) + kd·(velocity_command − velocity) + feed_forward" },
    Key { name: "law", form: Form::List(&Form::Table(law::KEYS), Length::Any), unit: "", default: "none", example: "", meaning: "Effects of one's own" },
    Key { name: "laws", form: Form::List(&Form::File, Length::Distinct), unit: "", default: "none", example: "[\"laws/dahl.toml\"]", meaning: "Files with tables [[law]], or folders of such files" },
    Key { name: "fit", form: Form::Table(fit::KEYS), unit: "", default: "the keys' own defaults", example: "", meaning: "The estimator, what is known before the data, and fits to compare with" },
    Key { name: "design", form: Form::Table(design::KEYS), unit: "", default: "the keys' own defaults", example: "", meaning: "The motions among which an excitation is sought, what makes one good, and its limits" },
    Key { name: "simulate", form: Form::Table(simulate::KEYS), unit: "", default: "the keys' own defaults", example: "", meaning: "The trajectory, how it is recorded, and the truth behind it" },
    Key { name: "diagnose", form: Form::Table(diagnose::KEYS), unit: "", default: "the keys' own defaults", example: "", meaning: "The physics to look for, and how sure a finding has to be" },
];

/// A problem file as read, after overrides.
#[derive(Debug, Clone)]
pub struct ProblemFile {
    /// The file itself.
    pub path: PathBuf,
    /// Name of the problem and of its results folder. Default: the file's name without extension.
    pub name: Located<String>,
    /// The kinematics, what is known of it, and what is to be estimated.
    pub robot: RobotTable,
    /// Default: an empty table, a rigid body without losses.
    pub drive: DriveTable,
    /// Absent where nothing is read, as for `design` and `simulate`; see [`Self::recordings`].
    pub recordings: Option<RecordingsTable>,
    /// The position controllers; absent where there are none, or nothing is said of them.
    pub controller: Option<Located<ControllerTable>>,
    /// Laws of one's own, those of other files first.
    pub laws: Vec<LawTable>,
    /// The estimator, priors and fits to compare with. Default: the keys' own defaults.
    pub fit: FitTable,
    /// Motions among which an excitation is sought, and their limits. Default: the keys' own defaults.
    pub design: DesignTable,
    /// The trajectory, how it is recorded, and the truth behind it. Default: the keys' own defaults.
    pub simulate: SimulateTable,
    /// The physics to look for, and how sure a finding has to be. Default: the keys' own defaults.
    pub diagnose: DiagnoseTable,
    /// The file as read, after overrides, for the record in `result.json`. A number that JSON
    /// cannot hold, such as an infinite bound, is a text there.
    pub json: serde_json::Value,
}

impl ProblemFile {
    /// Reads and validates a problem file.
    ///
    /// `overrides` are `key=value` texts that replace keys of the file (`fit.estimator=wls`);
    /// `effect_ids` are the identifiers that lists of effects may hold.
    ///
    /// # Errors
    /// The first fault found, with file, line, column and key: the file cannot be read, is not
    /// TOML, has an unknown, missing or conflicting key, or a value out of its type or range.
    pub fn read(
        path: &Path,
        overrides: &[String],
        effect_ids: &[&str],
    ) -> Result<Self, ProblemFileError> {
        let text = document::read_text(path)?;
        Self::parse(path, &text, overrides, effect_ids)
    }

    /// As [`Self::read`], from the text of the file at `path`.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn parse(
        path: &Path,
        text: &str,
        overrides: &[String],
        effect_ids: &[&str],
    ) -> Result<Self, ProblemFileError> {
        let root = document::parse(path, text)?;
        Self::of_document(path, root, overrides, effect_ids)
    }

    /// The problem that a result keeps, [`Self::json`], of the file at `path`, with overrides.
    ///
    /// # Errors
    /// As [`Self::read`], without lines and columns.
    pub fn kept(
        path: &Path,
        json: &serde_json::Value,
        overrides: &[String],
        effect_ids: &[&str],
    ) -> Result<Self, ProblemFileError> {
        let root = Node::from_json(json, Place::file(path));
        Self::of_document(path, root, overrides, effect_ids)
    }

    fn of_document(
        path: &Path,
        mut root: Node,
        overrides: &[String],
        effect_ids: &[&str],
    ) -> Result<Self, ProblemFileError> {
        overrides::apply(&mut root, KEYS, overrides)?;
        law::gather(&mut root, path.parent().unwrap_or(Path::new("")))
            .and_then(|()| Self::from_root(path, &root, effect_ids))
            .map_err(|error| error.naming_table_among(KEYS))
    }

    fn from_root(path: &Path, root: &Node, effect_ids: &[&str]) -> Result<Self, ProblemFileError> {
        let laws = match &root.value {
            NodeValue::Table(table) => table.get("law"),
            _ => None,
        };
        let laws = laws.map_or(Ok(&[][..]), |node| {
            values::items(node, "a list of tables, each under its own header [[law]]")
        })?;
        let ids = law::ids_with(laws, effect_ids);
        let context = Context {
            folder: path.parent().unwrap_or(Path::new("")),
            effect_ids: &ids,
        };
        let laws = law::of_nodes(laws, effect_ids)?;
        let file = Self::from_node(path, root, &context)?.with_laws(laws);
        file.check_across_tables()?;
        Ok(file)
    }

    fn from_node(path: &Path, root: &Node, context: &Context) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(root, KEYS)?;
        let name = reader.or("name", default_name(path), values::folder_name)?;
        let recordings = match reader.node("recordings") {
            Some(node) => Some(RecordingsTable::from_node(node, context)?),
            None => None,
        };
        let controller = match reader.node("controller") {
            Some(node) => Some(Located {
                value: ControllerTable::from_node(node)?,
                place: node.place.clone(),
            }),
            None => None,
        };
        Ok(Self {
            path: path.to_path_buf(),
            name,
            robot: RobotTable::from_node(
                reader.required_node("robot", "state the robot with a table [robot]")?,
                context,
            )?,
            drive: DriveTable::from_node(&reader.table("drive"), context)?,
            recordings,
            controller,
            laws: Vec::new(),
            fit: FitTable::from_node(&reader.table("fit"), context)?,
            design: DesignTable::from_node(&reader.table("design"), context)?,
            simulate: SimulateTable::from_node(&reader.table("simulate"), context)?,
            diagnose: DiagnoseTable::from_node(&reader.table("diagnose"), context)?,
            json: root.to_json(),
        })
    }

    fn with_laws(mut self, laws: Vec<LawTable>) -> Self {
        self.laws = laws;
        self
    }

    /// The same problem with the recordings of the simulator in the place of the robot's; `None` without any.
    pub fn of_simulator(&self) -> Option<Self> {
        let recordings = self.recordings.as_ref()?.of_simulator()?;
        Some(Self {
            recordings: Some(recordings),
            ..self.clone()
        })
    }

    /// The table of recordings, for a verb that reads them.
    ///
    /// # Errors
    /// `missing-table`, where the file has no `[recordings]`.
    pub fn recordings(&self) -> Result<&RecordingsTable, ProblemFileError> {
        self.recordings.as_ref().ok_or_else(|| {
            ProblemFileError::new(
                &Place::file(&self.path).key("recordings"),
                KeyFault::Missing {
                    remedy: "state the recordings with a table [recordings]".into(),
                },
            )
        })
    }

    /// Recordings with a load ask for a load in the model, and controllers for what they are told.
    fn check_across_tables(&self) -> Result<(), ProblemFileError> {
        if let (Some(controller), Some(recordings)) = (&self.controller, &self.recordings)
            && recordings.signal.value != choices::Signal::PositionCommand
        {
            return Err(ProblemFileError::new(
                &controller.place,
                KeyFault::Conflict {
                    found: "gains of a controller, but recordings.signal is not \"position_command\"".into(),
                    remedy: "say signal = \"position_command\" under [recordings], or leave [controller] out".into(),
                },
            ));
        }
        let loaded = self.recordings.as_ref().and_then(|r| r.loaded.first());
        match (loaded, &self.robot.payload) {
            (Some(loaded), None) => Err(ProblemFileError::new(
                &loaded.place,
                KeyFault::Conflict {
                    found: "recordings with a load, but the robot has none".into(),
                    remedy: "add payload = \"last\" to [robot], or move the files to train".into(),
                },
            )),
            _ => Ok(()),
        }
    }
}

/// The file's name without extension; "problem" where that is not a name for a folder.
fn default_name(path: &Path) -> String {
    path.file_stem()
        .map(|stem| stem.to_string_lossy().into_owned())
        .filter(|name| values::is_folder_name(name))
        .unwrap_or_else(|| "problem".to_owned())
}
