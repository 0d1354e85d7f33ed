//! `[robot]`: the kinematics, what is known of it, and what is to be estimated.

use crate::problem_file::choices::{Choice, ClosedJoint, Inertials, Mechanism};
use crate::problem_file::context::Context;
use crate::problem_file::document::{Node, NodeValue};
use crate::problem_file::error::{KeyFault, ProblemFileError};
use crate::problem_file::key::{Form, Key, Length, REQUIRED, Range, words};
use crate::problem_file::located::{FilePath, Located, Named};
use crate::problem_file::reader::Reader;
use crate::problem_file::values;

/// Keys of `[robot]`.
#[rustfmt::skip]
pub(crate) const KEYS: &[Key] = &[
    Key { name: "urdf", form: Form::File, unit: "", default: "one of urdf, mjcf, mdh and mechanism is required", example: "\"arm6.urdf\"", meaning: "Robot description (URDF)" },
    Key { name: "mdh", form: Form::File, unit: "", default: "one of urdf, mjcf, mdh and mechanism is required", example: "\"arm.mdh.toml\"", meaning: "Table of modified Denavit-Hartenberg parameters (TOML)" },
    Key { name: "mjcf", form: Form::File, unit: "", default: "one of urdf, mjcf, mdh and mechanism is required", example: "\"model.xml\"", meaning: "Model of MuJoCo (MJCF), with what it says of gravity and drives" },
    Key { name: "mechanism", form: Form::Words(words::<Mechanism>), unit: "", default: "one of urdf, mjcf, mdh and mechanism is required", example: "\"h4\"", meaning: "A mechanism whose kinematics is built in, with its lengths in a table of its name" },
    Key { name: "gravity", form: Form::List(&Form::Number(Range::Finite), Length::Exactly(3)), unit: "m/s²", default: "that of the robot file, or [0.0, 0.0, -9.81]", example: "[0.0, 0.0, -9.81]", meaning: "Gravity in the base frame" },
    Key { name: "joints", form: Form::List(&Form::Text, Length::SomeDistinct), unit: "", default: "the order of the robot file", example: "[\"a1\", \"a2\"]", meaning: "Order of the joints in every list with one value per joint" },
    Key { name: "locked", form: Form::Named(&Form::Number(Range::Finite)), unit: "rad (m)", default: "none", example: "{ a1 = 0.0 }", meaning: "Joints that do not move, and where they stand" },
    Key { name: "inertials", form: Form::Words(words::<Inertials>), unit: "", default: "\"estimate\"", example: "\"known\"", meaning: "Whether link parameters are unknown, or taken from the robot file" },
    Key { name: "zero", form: Form::List(&Form::Text, Length::Distinct), unit: "", default: "none", example: "[\"link2.com_y\"]", meaning: "Parameters that are zero by construction and not estimated" },
    Key { name: "parameters", form: Form::File, unit: "", default: "none", example: "\"results/kr150/fit/result.json\"", meaning: "Result of an earlier fit: its values, with its covariance as prior" },
    Key { name: "payload", form: Form::Text, unit: "", default: "no load", example: "\"last\"", meaning: "Ten unknown parameters of a load, on the last moving link (\"last\") or on a named link or fixed frame" },
    Key { name: "h4", form: Form::Table(H4_KEYS), unit: "", default: "none", example: "", meaning: "Lengths of the parallel robot H4" },
    Key { name: "passive", form: Form::Named(&Form::Number(Range::Finite)), unit: "rad (m)", default: "none", example: "{ elbow = 0.0 }", meaning: "Joints without a motor, which closed joints hold, and positions near which the loops close" },
    Key { name: "closed", form: Form::List(&Form::Table(CLOSED_KEYS), Length::Any), unit: "", default: "none", example: "", meaning: "A joint that closes a loop of the robot file's tree" },
];

/// Keys of `[robot.h4]`.
#[rustfmt::skip]
pub(crate) const H4_KEYS: &[Key] = &[
    Key { name: "lever", form: Form::Number(Range::Positive), unit: "m", default: REQUIRED, example: "0.26", meaning: "Length of a lever, l" },
    Key { name: "rod", form: Form::Number(Range::Positive), unit: "m", default: REQUIRED, example: "0.48", meaning: "Length of a rod, L" },
    Key { name: "half_bar", form: Form::Number(Range::Positive), unit: "m", default: REQUIRED, example: "0.06", meaning: "Half of the bar between two rods, h" },
    Key { name: "half_width", form: Form::Number(Range::NonNegative), unit: "m", default: REQUIRED, example: "0.06", meaning: "Half of the platform's width, d" },
    Key { name: "radius", form: Form::Number(Range::Positive), unit: "m", default: REQUIRED, example: "0.14", meaning: "From where the levers would meet the platform at rest to the motors, R" },
];

/// Keys of `[[robot.closed]]`.
#[rustfmt::skip]
pub(crate) const CLOSED_KEYS: &[Key] = &[
    Key { name: "frames", form: Form::List(&Form::Text, Length::Exactly(2)), unit: "", default: REQUIRED, example: "[\"coupler_tip\", \"forearm_rear\"]", meaning: "Links or fixed frames on both sides of the cut; their origins are the joint's centres" },
    Key { name: "joint", form: Form::Words(words::<ClosedJoint>), unit: "", default: "\"hinge\"", example: "\"hinge\"", meaning: "Kind of joint: one axis, a ball, or a massless rod with a ball at both ends" },
    Key { name: "axis", form: Form::List(&Form::Number(Range::Finite), Length::Exactly(3)), unit: "", default: "[0.0, 0.0, 1.0]", example: "[0.0, 1.0, 0.0]", meaning: "Axis of a hinge, in both frames" },
    Key { name: "length", form: Form::Number(Range::Positive), unit: "m", default: "none; required for a rod", example: "0.48", meaning: "Length of a rod" },
];

/// The table `[robot]`.
#[derive(Debug, Clone)]
pub struct RobotTable {
    /// Where the kinematics comes from. Required.
    pub source: RobotSource,
    /// Gravity in the base frame, m/s². Default: that of the robot file, else (0, 0, −9.81).
    pub gravity: Option<Located<[f64; 3]>>,
    /// Order of all per-joint arrays. Default: the order of the robot file's chain.
    pub joints: Option<Located<Vec<Located<String>>>>,
    /// Joints that do not move and their positions, rad (m). Default: none.
    pub locked: Vec<Named<f64>>,
    /// Default: [`Inertials::Estimate`].
    pub inertials: Located<Inertials>,
    /// Parameters that are zero by construction. Default: none.
    pub zero: Vec<Located<String>>,
    /// `result.json` of an earlier fit to start from. Default: none.
    pub parameters: Option<Located<FilePath>>,
    /// Ten unknown parameters of a load. Default: none.
    pub payload: Option<Located<PayloadPlace>>,
    /// Joints without a motor, which closed joints hold, and positions near which the loops close, rad (m).
    /// Default: none.
    pub passive: Vec<Named<f64>>,
    /// Joints that close loops of the robot file's tree. Default: none.
    pub closed: Vec<ClosedTable>,
}

/// An entry of `[[robot.closed]]`: a joint between two links or frames that are both in the tree.
#[derive(Debug, Clone)]
pub struct ClosedTable {
    /// Links or fixed frames of the robot file; their origins are the joint's centres.
    pub frames: Located<[String; 2]>,
    /// Default: [`ClosedJoint::Hinge`].
    pub joint: Located<ClosedJoint>,
    /// Axis of a hinge in both frames. Default: z.
    pub axis: Located<[f64; 3]>,
    /// Length of a rod, m; required for it.
    pub length: Option<Located<f64>>,
}

/// Where the kinematics comes from.
#[derive(Debug, Clone)]
pub enum RobotSource {
    /// Robot description (URDF).
    Urdf(Located<FilePath>),
    /// Modified Denavit-Hartenberg parameters, a TOML file.
    Mdh(Located<FilePath>),
    /// The format of MuJoCo.
    Mjcf(Located<FilePath>),
    /// A mechanism the tool knows, with its own table `[robot.<mechanism>]` (empty where absent).
    Mechanism {
        /// Which one.
        mechanism: Located<Mechanism>,
        /// Its lengths.
        table: Located<toml::Value>,
    },
}

/// The body that carries the load.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PayloadPlace {
    /// The last moving link.
    Last,
    /// A link or fixed frame of the robot file.
    Named(String),
}

impl RobotTable {
    pub(super) fn from_node(node: &Node, context: &Context) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, KEYS)?;
        let table = Self {
            source: source(&reader, context)?,
            gravity: reader.optional("gravity", values::vector3)?,
            joints: reader.optional("joints", |n| {
                values::not_empty(
                    values::names(n, "a list of joints such as [\"joint1\", \"joint2\"]")?,
                    n,
                )
            })?,
            locked: reader.named("locked", values::finite)?,
            inertials: reader.or("inertials", Inertials::Estimate, values::choice)?,
            zero: reader.list("zero", |n| {
                values::names(n, "a list of parameters such as [\"link2.com_y\"]")
            })?,
            parameters: reader.optional("parameters", |n| values::file_path(n, context))?,
            payload: reader.optional("payload", payload_place)?,
            passive: reader.named("passive", values::finite)?,
            closed: reader
                .tables("closed")?
                .iter()
                .map(ClosedTable::from_node)
                .collect::<Result<_, _>>()?,
        };
        table.check_locked()?;
        Ok(table)
    }

    /// A joint either moves and has a place in the arrays, or is locked.
    fn check_locked(&self) -> Result<(), ProblemFileError> {
        let moving = |name: &str| {
            let joints = self.joints.as_ref();
            joints.is_some_and(|joints| joints.iter().any(|joint| joint.value == name))
        };
        match self.locked.iter().find(|locked| moving(&locked.name)) {
            None => Ok(()),
            Some(locked) => Err(ProblemFileError::new(
                &locked.value.place,
                KeyFault::Conflict {
                    found: format!("joint \"{}\" is locked and listed in joints", locked.name),
                    remedy: "remove it from one of the two".into(),
                },
            )),
        }
    }
}

impl ClosedTable {
    fn from_node(node: &Node) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, CLOSED_KEYS)?;
        let names = |n: &Node| values::array(n, "two links or frames", values::text);
        let remedy = "name the two links or frames that the joint holds together";
        let table = Self {
            frames: reader.required("frames", remedy, names)?,
            joint: reader.or("joint", ClosedJoint::Hinge, values::choice)?,
            axis: reader.or("axis", [0.0, 0.0, 1.0], values::vector3)?,
            length: reader.optional("length", values::positive)?,
        };
        if table.joint.value == ClosedJoint::Rod && table.length.is_none() {
            return Err(reader.missing("length", "give the length of the rod in metres"));
        }
        Ok(table)
    }
}

/// Exactly one of `urdf`, `mjcf`, `mdh`, `mechanism`.
fn source(reader: &Reader, context: &Context) -> Result<RobotSource, ProblemFileError> {
    let path = |n: &Node| values::file_path(n, context);
    reader.at_most_one(&["urdf", "mdh", "mjcf", "mechanism"])?;
    reader.at_most_one(&["urdf", "mdh", "mjcf", "h4"])?;
    if let Some(file) = reader.optional("urdf", path)? {
        return Ok(RobotSource::Urdf(file));
    }
    if let Some(file) = reader.optional("mdh", path)? {
        return Ok(RobotSource::Mdh(file));
    }
    if let Some(file) = reader.optional("mjcf", path)? {
        return Ok(RobotSource::Mjcf(file));
    }
    let Some(mechanism) = reader.optional("mechanism", values::choice::<Mechanism>)? else {
        let remedy = "name the robot's file with urdf, mjcf or mdh, or a mechanism such as \"h4\"";
        return Err(reader.missing("urdf", remedy));
    };
    let empty = toml::Value::Table(toml::Table::new());
    Ok(RobotSource::Mechanism {
        table: reader.or(mechanism.word(), empty, own_table)?,
        mechanism,
    })
}

/// A mechanism's own table, whose keys the mechanism checks.
fn own_table(node: &Node) -> Result<toml::Value, ProblemFileError> {
    match &node.value {
        NodeValue::Table(_) => Ok(node.to_toml()),
        _ => Err(values::wrong_type(node, "a table")),
    }
}

fn payload_place(node: &Node) -> Result<PayloadPlace, ProblemFileError> {
    Ok(match values::text(node)?.as_str() {
        "last" => PayloadPlace::Last,
        name => PayloadPlace::Named(name.to_owned()),
    })
}
