//! `[robot]`: the kinematics, what is known of it, and what is to be estimated.

use crate::problem_file::choices::{Choice, ClosedJoint, Inertials, Mechanism};
use crate::problem_file::document::{Node, NodeValue};
use crate::problem_file::error::{KeyFault, ProblemFileError};
use crate::problem_file::located::{FilePath, Located, Named};
use crate::problem_file::reader::Reader;
use crate::problem_file::{Context, values};

pub(crate) const KEYS: &[&str] = &[
    "urdf",
    "mdh",
    "mjcf",
    "mechanism",
    "gravity",
    "joints",
    "locked",
    "inertials",
    "zero",
    "parameters",
    "payload",
    "h4",
    "passive",
    "closed",
];
pub(crate) const CLOSED_KEYS: &[&str] = &["frames", "joint", "axis", "length"];

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
    Urdf(Located<FilePath>),
    /// Modified Denavit-Hartenberg parameters, a TOML file.
    Mdh(Located<FilePath>),
    /// The format of MuJoCo.
    Mjcf(Located<FilePath>),
    /// A mechanism the tool knows, with its own table `[robot.<mechanism>]` (empty where absent).
    Mechanism {
        mechanism: Located<Mechanism>,
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
