//! `[design]`: the motions among which an excitation is sought, what makes one good, and its limits.

use crate::problem_file::choices::{Criterion, DesignKind, Scaling};
use crate::problem_file::document::{Node, NodeValue};
use crate::problem_file::error::{NumberFault, ProblemFileError, ValueFault};
use crate::problem_file::located::{Located, PerJoint};
use crate::problem_file::reader::Reader;
use crate::problem_file::values;

pub(crate) const KEYS: &[&str] = &[
    "kind",
    "harmonics",
    "period",
    "criterion",
    "scaling",
    "parameters",
    "samples",
    "noise",
    "rest_to_rest",
    "trajectories",
    "budget_s",
    "starts",
    "limits",
    "workspace",
];
pub(crate) const LIMITS_KEYS: &[&str] = &[
    "position_lower",
    "position_upper",
    "velocity",
    "acceleration",
    "jerk",
    "torque",
];
pub(crate) const WORKSPACE_KEYS: &[&str] = &["halfspace", "clearance"];
pub(crate) const HALFSPACE_KEYS: &[&str] = &["frame", "normal", "offset"];
pub(crate) const CLEARANCE_KEYS: &[&str] = &["links", "distance"];

/// Enough harmonics for full rank on six joints, few enough to stay smooth.
const DEFAULT_HARMONICS: usize = 5;
/// s.
const DEFAULT_PERIOD: f64 = 10.0;
/// Samples per period: 40 per cycle of the fifth harmonic.
const DEFAULT_SAMPLES: usize = 200;

/// The table `[design]`.
#[derive(Debug, Clone)]
pub struct DesignTable {
    /// Default: [`DesignKind::Fourier`].
    pub kind: Located<DesignKind>,
    /// Harmonics of the Fourier series, at least 1. Default: 5.
    pub harmonics: Located<usize>,
    /// s, positive. Default: 10.
    pub period: Located<f64>,
    /// Default: [`Criterion::DOptimal`].
    pub criterion: Located<Criterion>,
    /// Default: [`Scaling::Columns`].
    pub scaling: Located<Scaling>,
    /// Default: [`DesignParameters::All`].
    pub parameters: Located<DesignParameters>,
    /// Per period, of the criterion and the constraints while optimising, at least 1. Default: 200.
    pub samples: Located<usize>,
    /// Standard deviation of the signal, in its unit, positive. Default: none.
    pub noise: Option<Located<PerJoint>>,
    /// Start and stop at rest. Default: true.
    pub rest_to_rest: Located<bool>,
    /// Trajectories designed together, at least 1. Default: 1.
    pub trajectories: Located<usize>,
    /// Time for the search, s, positive. Default: none.
    pub budget_s: Option<Located<f64>>,
    /// Number of starts of the search, at least 1. Default: none.
    pub starts: Option<Located<usize>>,
    pub limits: LimitsTable,
    pub workspace: WorkspaceTable,
}

/// The parameters whose accuracy a design improves; the rest are nuisance parameters.
#[derive(Debug, Clone, PartialEq)]
pub enum DesignParameters {
    All,
    Inertial,
    Payload,
    Friction,
    Listed(Vec<Located<String>>),
}

/// The table `[design.limits]`, per joint. Default of each: from the robot file, where it has one.
#[derive(Debug, Clone)]
pub struct LimitsTable {
    /// rad (m).
    pub position_lower: Option<Located<PerJoint>>,
    /// rad (m).
    pub position_upper: Option<Located<PerJoint>>,
    /// rad/s (m/s), positive.
    pub velocity: Option<Located<PerJoint>>,
    /// rad/s² (m/s²), positive.
    pub acceleration: Option<Located<PerJoint>>,
    /// rad/s³ (m/s³), positive.
    pub jerk: Option<Located<PerJoint>>,
    /// N·m (N), positive.
    pub torque: Option<Located<PerJoint>>,
}

/// The table `[design.workspace]`. Default: empty.
#[derive(Debug, Clone)]
pub struct WorkspaceTable {
    pub halfspace: Vec<Halfspace>,
    pub clearance: Vec<Clearance>,
}

/// normal·p >= offset for the origin p of a link or frame, in the base frame.
#[derive(Debug, Clone)]
pub struct Halfspace {
    /// Link or frame of the robot file.
    pub frame: Located<String>,
    /// Not zero; need not have unit length.
    pub normal: Located<[f64; 3]>,
    /// m, if the normal has unit length.
    pub offset: Located<f64>,
}

/// Least distance between the collision shapes of two links.
#[derive(Debug, Clone)]
pub struct Clearance {
    pub links: Located<[String; 2]>,
    /// m, not negative.
    pub distance: Located<f64>,
}

impl DesignTable {
    pub(super) fn from_node(node: &Node) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, KEYS)?;
        Ok(Self {
            kind: reader.or("kind", DesignKind::Fourier, values::choice)?,
            harmonics: reader.or("harmonics", DEFAULT_HARMONICS, values::count)?,
            period: reader.or("period", DEFAULT_PERIOD, values::positive)?,
            criterion: reader.or("criterion", Criterion::DOptimal, values::choice)?,
            scaling: reader.or("scaling", Scaling::Columns, values::choice)?,
            parameters: reader.or("parameters", DesignParameters::All, design_parameters)?,
            samples: reader.or("samples", DEFAULT_SAMPLES, values::count)?,
            noise: reader.optional("noise", values::per_joint_positive)?,
            rest_to_rest: reader.or("rest_to_rest", true, values::boolean)?,
            trajectories: reader.or("trajectories", 1, values::count)?,
            budget_s: reader.optional("budget_s", values::positive)?,
            starts: reader.optional("starts", values::count)?,
            limits: LimitsTable::from_node(&reader.table("limits"))?,
            workspace: WorkspaceTable::from_node(&reader.table("workspace"))?,
        })
    }
}

impl LimitsTable {
    fn from_node(node: &Node) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, LIMITS_KEYS)?;
        let table = Self {
            position_lower: reader.optional("position_lower", values::per_joint_finite)?,
            position_upper: reader.optional("position_upper", values::per_joint_finite)?,
            velocity: reader.optional("velocity", values::per_joint_positive)?,
            acceleration: reader.optional("acceleration", values::per_joint_positive)?,
            jerk: reader.optional("jerk", values::per_joint_positive)?,
            torque: reader.optional("torque", values::per_joint_positive)?,
        };
        if let (Some(lower), Some(upper)) = (&table.position_lower, &table.position_upper) {
            check_order(lower, upper)?;
        }
        Ok(table)
    }
}

/// lower < upper for every joint that has both: a joint that cannot move is locked, not limited.
fn check_order(
    lower: &Located<PerJoint>,
    upper: &Located<PerJoint>,
) -> Result<(), ProblemFileError> {
    let count = |values: &PerJoint| match values {
        PerJoint::All(_) => 1,
        PerJoint::Each(values) => values.len(),
    };
    for joint in 0..count(lower).max(count(upper)) {
        if let (Some(low), Some(high)) = (lower.get(joint), upper.get(joint))
            && low > high
        {
            return Err(ProblemFileError::new(
                &lower.place,
                NumberFault::LowerAboveUpper {
                    lower: low,
                    upper: high,
                },
            ));
        }
    }
    Ok(())
}

impl WorkspaceTable {
    fn from_node(node: &Node) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, WORKSPACE_KEYS)?;
        let halfspace = reader.tables("halfspace")?;
        let clearance = reader.tables("clearance")?;
        Ok(Self {
            halfspace: halfspace
                .iter()
                .map(Halfspace::from_node)
                .collect::<Result<_, _>>()?,
            clearance: clearance
                .iter()
                .map(Clearance::from_node)
                .collect::<Result<_, _>>()?,
        })
    }
}

impl Halfspace {
    fn from_node(node: &Node) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, HALFSPACE_KEYS)?;
        let normal = reader.required("normal", "state the normal, such as [0, 0, 1]", |n| {
            let normal = values::vector3(n)?;
            match normal.iter().all(|entry| *entry == 0.0) {
                true => Err(ProblemFileError::new(&n.place, NumberFault::Zero)),
                false => Ok(normal),
            }
        })?;
        Ok(Self {
            frame: reader.required("frame", "name a link or frame", values::text)?,
            normal,
            offset: reader.required("offset", "state the offset in m", values::finite)?,
        })
    }
}

impl Clearance {
    fn from_node(node: &Node) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, CLEARANCE_KEYS)?;
        let links = reader.required("links", "name the two links", |n| {
            let links: [String; 2] = values::array(n, "the names of two links", values::text)?;
            match links[0] == links[1] {
                true => Err(ProblemFileError::new(
                    &n.place,
                    ValueFault::Duplicate {
                        found: links[1].clone(),
                    },
                )),
                false => Ok(links),
            }
        })?;
        Ok(Self {
            links,
            distance: reader.required(
                "distance",
                "state the least distance in m",
                values::non_negative,
            )?,
        })
    }
}

fn design_parameters(node: &Node) -> Result<DesignParameters, ProblemFileError> {
    const WORDS: &[(&str, DesignParameters)] = &[
        ("all", DesignParameters::All),
        ("inertial", DesignParameters::Inertial),
        ("payload", DesignParameters::Payload),
        ("friction", DesignParameters::Friction),
    ];
    match &node.value {
        NodeValue::Text(word) => WORDS
            .iter()
            .find(|(known, _)| known == word)
            .map(|(_, choice)| choice.clone())
            .ok_or_else(|| {
                ProblemFileError::new(
                    &node.place,
                    ValueFault::UnknownWord {
                        noun: "group of parameters",
                        code: "unknown-parameter-group",
                        found: word.clone(),
                        known: WORDS.iter().map(|(word, _)| (*word).to_owned()).collect(),
                    },
                )
            }),
        NodeValue::List(_) => {
            let names = values::names(node, "a list of parameters")?;
            values::not_empty(names, node).map(DesignParameters::Listed)
        }
        _ => Err(values::wrong_type(
            node,
            "\"all\", \"inertial\", \"payload\", \"friction\" or a list of names",
        )),
    }
}
