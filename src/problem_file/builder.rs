//! A problem stated in Rust instead of TOML: the same keys, defaults and checks, and no file but those that it names.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::fault::Place;
use crate::problem_file::choices::{Choice, Estimator, Inertials, Signal};
use crate::problem_file::document::{Node, NodeValue, Table};
use crate::problem_file::{KEYS, ProblemFile, ProblemFileError, overrides};

/// What stands in the places of errors where a problem file would be named.
const STATED_IN_RUST: &str = "<problem>";

/// The keys of a problem file, one call each.
///
/// A method for every key that most problems have, and [`Self::set`] for all others; a key that is set again has the last
/// value. Units are those of the problem file's reference: SI at the joint.
///
/// ```
/// use exid::chain::effect::ids;
/// use exid::fault::Fault;
/// use exid::problem_file::builder::ProblemBuilder;
/// use exid::problem_file::choices::Signal;
///
/// let arm = ProblemBuilder::in_folder("folder/of/files")
///     .urdf("arm.urdf")
///     .train("slow.csv")
///     .signal(Signal::Torque)
///     .rotor_inertia([0.6, 0.5])
///     .set("recordings.differentiation.method", "smoother");
/// let problem = arm.clone().build(&ids()).unwrap();
/// assert_eq!(problem.recordings().unwrap().signal.value, Signal::Torque);
///
/// let misspelt = arm.set("recordings.perod", 8.0).build(&ids()).unwrap_err();
/// assert_eq!(misspelt.describe().code, "unknown-key");
/// ```
#[derive(Debug, Clone)]
pub struct ProblemBuilder {
    path: PathBuf,
    settings: Vec<Setting>,
}

/// A key of the problem file, `recordings.period`, and its value.
#[derive(Debug, Clone)]
struct Setting {
    key: String,
    value: Value,
}

impl ProblemBuilder {
    /// Nothing yet; relative paths of files start from `folder`.
    pub fn in_folder(folder: impl AsRef<Path>) -> Self {
        Self {
            path: folder.as_ref().join(STATED_IN_RUST),
            settings: Vec::new(),
        }
    }

    /// Any key by its path, `recordings.period` or `drive.values."a1.coulomb_friction.w"`, with what TOML would have for
    /// it: a number, text, list, or `serde_json::json!` of a table. An infinite number is the text `"inf"` or `"-inf"`.
    pub fn set(mut self, key: impl Into<String>, value: impl Into<Value>) -> Self {
        let (key, value) = (key.into(), value.into());
        self.settings.push(Setting { key, value });
        self
    }

    /// One value more in a list.
    fn push(mut self, key: &str, value: String) -> Self {
        let listed = self.settings.iter_mut().find(|setting| setting.key == key);
        match listed.map(|setting| &mut setting.value) {
            Some(Value::Array(items)) => {
                items.push(value.into());
                self
            }
            _ => self.set(key, vec![value]),
        }
    }

    /// Name of the problem. Default: `problem`.
    pub fn name(self, name: &str) -> Self {
        self.set("name", name)
    }

    /// Robot description (URDF).
    pub fn urdf(self, file: impl Into<String>) -> Self {
        self.set("robot.urdf", file.into())
    }

    /// Model of MuJoCo (MJCF), with what it says of gravity and drives.
    pub fn mjcf(self, file: impl Into<String>) -> Self {
        self.set("robot.mjcf", file.into())
    }

    /// Whether link parameters are unknown, as by default, or taken from the robot file.
    pub fn inertials(self, inertials: Inertials) -> Self {
        self.set("robot.inertials", inertials.word())
    }

    /// A recording to fit, beside those already named.
    pub fn train(self, file: impl Into<String>) -> Self {
        self.push("recordings.train", file.into())
    }

    /// A recording that no fit sees, to judge fits by, beside those already named.
    pub fn validation(self, file: impl Into<String>) -> Self {
        self.push("recordings.validation", file.into())
    }

    /// What the recordings hold beside the motion. Default: currents, A.
    pub fn signal(self, signal: Signal) -> Self {
        self.set("recordings.signal", signal.word())
    }

    /// Samples per second, Hz. Default: from the time stamps.
    pub fn rate(self, hertz: f64) -> Self {
        self.set("recordings.rate", hertz)
    }

    /// Time after which the motion repeats, s. Default: found in the recordings, where they repeat.
    pub fn period(self, seconds: f64) -> Self {
        self.set("recordings.period", seconds)
    }

    /// Torque of a motor at the joint per current, N·m/A (N/A): one number, or one per joint.
    pub fn torque_constant(self, per_joint: impl Into<Value>) -> Self {
        self.set("drive.torque_constant", per_joint)
    }

    /// Inertia of rotor and gear, reflected to the joint, kg·m² (kg): one number, or one per joint.
    pub fn rotor_inertia(self, per_joint: impl Into<Value>) -> Self {
        self.set("drive.rotor_inertia", per_joint)
    }

    /// The physics of all joints beside rigid bodies, by the identifiers of effects. Default: none.
    pub fn effects(self, ids: &[&str]) -> Self {
        self.set("drive.effects", ids)
    }

    /// How parameters follow from recordings. Default: that of the problem file's reference.
    pub fn estimator(self, estimator: Estimator) -> Self {
        self.set("fit.estimator", estimator.word())
    }

    /// Checks the keys and their values; `effect_ids` are the identifiers that lists of effects may hold.
    ///
    /// # Errors
    /// As [`ProblemFile::read`], with the key in the place of the line. Files of robot and recordings are read by the tasks.
    pub fn build(self, effect_ids: &[&str]) -> Result<ProblemFile, ProblemFileError> {
        let place = Place::file(&self.path);
        let mut root = Node {
            value: NodeValue::Table(Table::default()),
            place: place.clone(),
        };
        for Setting { key, value } in &self.settings {
            let value = Node::from_json(value, place.clone().key(key));
            overrides::set(&mut root, KEYS, key, value)?;
        }
        ProblemFile::of_document(&self.path, root, &[], effect_ids)
    }
}
