//! Why a result cannot be exported.

use crate::fault::{Description, Fault, Place, write_fault};
use crate::robot::error::RobotError;
use crate::setup::error::SetupError;
use std::fmt;
use std::path::Path;

/// A fault of an export.
#[derive(Debug)]
pub enum ExportError {
    /// The verb identifies no robot, or the result is of a version that did not keep it.
    NoRobot {
        /// Name of the problem.
        name: String,
        /// Verb of the result.
        verb: &'static str,
    },
    /// Joints of the robot close loops, which the format does not have.
    ClosedLoops {
        /// Name of the problem.
        name: String,
    },
    /// An effect that this version does not know.
    UnknownEffect {
        /// Name of the joint.
        joint: String,
        /// Identifier of the effect.
        effect: String,
    },
    /// The result lacks a parameter.
    Incomplete {
        /// Name of the joint.
        joint: String,
        /// Name of the parameter.
        parameter: String,
    },
    /// A law that a program cannot have.
    NotWritable {
        /// Name of the joint.
        joint: String,
        /// Identifier of the effect.
        effect: String,
        /// What it has that programs cannot have, in words.
        why: &'static str,
    },
    /// The laws of the problem that the result keeps.
    Laws(SetupError),
    /// The robot file in the result does not read.
    Description(Box<RobotError>),
    /// The document cannot be encoded.
    NotEncodable {
        /// Where in the document.
        place: Place,
        /// What the encoder says.
        reason: String,
    },
}

impl ExportError {
    pub(crate) fn not_encodable(file: &str, reason: impl fmt::Display) -> Self {
        Self::NotEncodable {
            place: Place::file(Path::new(file)),
            reason: reason.to_string(),
        }
    }

    /// Code, message and remedy; the place is the result's folder.
    pub fn describe(&self) -> Description {
        match self {
            Self::NoRobot { name, verb } => Description::new(
                "no-robot-in-result",
                format!("`{name}`, a result of `{verb}`, holds no identified robot"),
                "give the results folder of a fit of the robot's motion, or of `exid diagnose`; constants of motors from constant \
                 speed are no robot; of a result that an earlier version made, run the verb again",
            ),
            Self::ClosedLoops { name } => Description::new(
                "closed-loops-not-exported",
                format!(
                    "joints of the robot of `{name}` close loops, which programs of inverse dynamics and the plugin of drives do not \
                     have"
                ),
                "export to mjcf, which closes the loops, or to urdf or toml, which have the tree that they were cut to",
            ),
            Self::UnknownEffect { joint, effect } => Description::new(
                "unknown-effect",
                format!("{joint} has the effect `{effect}`, which this version does not know"),
                "run the verb of the result again with this version, or export with the version that made it",
            ),
            Self::Incomplete { joint, parameter } => Description::new(
                "incomplete-robot",
                format!("the result holds no value of {parameter} of {joint}"),
                "run the verb of the result again with this version (`exid repeat` on the results folder does)",
            ),
            Self::NotWritable { joint, effect, why } => Description::new(
                "law-not-exportable",
                format!(
                    "{joint} has the effect `{effect}`, which no program of this kind can have: {why}"
                ),
                "fit without it, or export --to toml, which has its parameters",
            ),
            Self::Description(error) => error.describe(),
            Self::Laws(error) => error.describe(),
            Self::NotEncodable { reason, .. } => Description::new(
                "not-encodable",
                format!("the model cannot be written: {reason}"),
                "report this as a defect of the program",
            ),
        }
    }
}

impl fmt::Display for ExportError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Description(error) => write_fault(f, error.as_ref()),
            Self::Laws(error) => write_fault(f, error),
            _ => {
                let Description {
                    message, remedy, ..
                } = self.describe();
                write!(f, "{message}; {remedy}")
            }
        }
    }
}

impl std::error::Error for ExportError {}

impl From<RobotError> for ExportError {
    fn from(error: RobotError) -> Self {
        Self::Description(Box::new(error))
    }
}
