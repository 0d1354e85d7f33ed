//! `[design]`: the motions among which an excitation is sought, what makes one good, and its limits.

use crate::problem_file::choices::{Criterion, DesignKind, Scaling};
use crate::problem_file::context::Context;
use crate::problem_file::document::{Node, NodeValue};
use crate::problem_file::error::{NumberFault, ProblemFileError, ValueFault};
use crate::problem_file::key::{Form, Key, Length, REQUIRED, Range, words};
use crate::problem_file::located::{FilePath, Located, Named, PerJoint};
use crate::problem_file::reader::Reader;
use crate::problem_file::values;

/// Keys of `[design]`.
#[rustfmt::skip]
pub(crate) const KEYS: &[Key] = &[
    Key { name: "kind", form: Form::Words(words::<DesignKind>), unit: "", default: "\"fourier\"", example: "\"constant_velocity\"", meaning: "Family of motions: Fourier series, or strokes at constant velocity" },
    Key { name: "harmonics", form: Form::Either(&[Form::Count(1), Form::List(&Form::Count(1), Length::Some)]), unit: "", default: "5", example: "[7, 5, 3]", meaning: "Harmonics of the series, of all joints or of each" },
    Key { name: "period", form: Form::Number(Range::Positive), unit: "s", default: "10.0", example: "20.0", meaning: "Period of the motion" },
    Key { name: "criterion", form: Form::Words(words::<Criterion>), unit: "", default: "\"d_optimal\"", example: "\"condition\"", meaning: "What makes a motion good: condition number, determinant, trace or least eigenvalue of the information, or the distance between rival models" },
    Key { name: "scaling", form: Form::Words(words::<Scaling>), unit: "", default: "\"columns\"", example: "\"whitened\"", meaning: "How the regressor is scaled before the criterion: columns by their norms, rows by the noise, or not" },
    Key { name: "parameters", form: Form::Either(&[Form::Words(groups), Form::List(&Form::Text, Length::SomeDistinct)]), unit: "", default: "\"all\"", example: "\"payload\"", meaning: "Parameters whose accuracy counts; the rest are nuisance parameters" },
    Key { name: "samples", form: Form::Count(1), unit: "", default: "200", example: "400", meaning: "Samples per period of the criterion and of the constraints while optimising" },
    Key { name: "noise", form: Form::PerJoint(Range::Positive), unit: "the signal's", default: "none", example: "[0.5, 0.6]", meaning: "Standard deviation of the signal" },
    Key { name: "rest_to_rest", form: Form::Boolean, unit: "", default: "true", example: "false", meaning: "Start and stop at rest" },
    Key { name: "trajectories", form: Form::Count(1), unit: "", default: "1", example: "3", meaning: "Motions designed together" },
    Key { name: "budget_s", form: Form::Number(Range::Positive), unit: "s", default: "none", example: "60.0", meaning: "Time for the search, after which the best motion is taken" },
    Key { name: "starts", form: Form::Count(1), unit: "", default: "none", example: "20", meaning: "Starts of the search, which make the run repeatable to the bit" },
    Key { name: "start_from", form: Form::File, unit: "", default: "none", example: "\"results/arm/design/coefficients.json\"", meaning: "Coefficients or result of an earlier design to go on from" },
    Key { name: "reference", form: Form::File, unit: "", default: "none", example: "\"hand_chosen.json\"", meaning: "Coefficients or result of a motion to compare with" },
    Key { name: "rest_position", form: Form::PerJoint(Range::Finite), unit: "rad (m)", default: "the middle of the ranges", example: "[0.0, -1.5]", meaning: "Where the ramps of a motion begin and end" },
    Key { name: "speeds", form: Form::Count(1), unit: "", default: "8", example: "12", meaning: "Speeds of each joint in a plan of constant velocities" },
    Key { name: "rival", form: Form::List(&Form::Table(RIVAL_KEYS), Length::Any), unit: "", default: "none", example: "", meaning: "A model that the motion is to tell from the others" },
    Key { name: "values", form: Form::Named(&Form::Number(Range::Finite)), unit: "each parameter's own", default: "those of the robot file or of an earlier fit", example: "{ \"payload.mass\" = 120.0 }", meaning: "Values with which torques are predicted" },
    Key { name: "limits", form: Form::Table(LIMITS_KEYS), unit: "", default: "those of the robot file", example: "", meaning: "Limits of the joints" },
    Key { name: "workspace", form: Form::Table(WORKSPACE_KEYS), unit: "", default: "none", example: "", meaning: "Limits in space" },
];

/// Keys of `[[design.rival]]`.
#[rustfmt::skip]
pub(crate) const RIVAL_KEYS: &[Key] = &[
    Key { name: "name", form: Form::Text, unit: "", default: REQUIRED, example: "\"efficiency\"", meaning: "Name of the rival" },
    Key { name: "effects", form: Form::List(&Form::Effect, Length::Distinct), unit: "", default: "the problem file's", example: "[\"coulomb_friction\", \"transmission_efficiency\"]", meaning: "What replaces drive.effects" },
    Key { name: "effects_of", form: Form::Named(&Form::List(&Form::Effect, Length::Distinct)), unit: "", default: "none", example: "{ a3 = [\"transmission_efficiency\"] }", meaning: "What replaces the effects of single joints" },
    Key { name: "parameters", form: Form::File, unit: "", default: "the problem file's values", example: "\"results/fit/result.json\"", meaning: "Result of a fit of this model: its values" },
    Key { name: "values", form: Form::Named(&Form::Number(Range::Finite)), unit: "each parameter's own", default: "none", example: "{ \"a3.transmission_efficiency.R\" = 0.84 }", meaning: "Values of single parameters" },
];

/// Keys of `[design.limits]`.
#[rustfmt::skip]
pub(crate) const LIMITS_KEYS: &[Key] = &[
    Key { name: "position_lower", form: Form::PerJoint(Range::Finite), unit: "rad (m)", default: "the robot file's", example: "[-2.9, -2.0]", meaning: "Lowest position" },
    Key { name: "position_upper", form: Form::PerJoint(Range::Finite), unit: "rad (m)", default: "the robot file's", example: "[2.9, 0.5]", meaning: "Highest position" },
    Key { name: "velocity", form: Form::PerJoint(Range::Positive), unit: "rad/s (m/s)", default: "the robot file's", example: "[1.5, 1.6]", meaning: "Largest speed" },
    Key { name: "acceleration", form: Form::PerJoint(Range::Positive), unit: "rad/s² (m/s²)", default: "none", example: "15.0", meaning: "Largest acceleration" },
    Key { name: "jerk", form: Form::PerJoint(Range::Positive), unit: "rad/s³ (m/s³)", default: "none", example: "[150.0, 160.0]", meaning: "Largest jerk" },
    Key { name: "torque", form: Form::PerJoint(Range::Positive), unit: "N·m (N)", default: "the robot file's", example: "[9000.0, 9100.0]", meaning: "Largest torque" },
];

/// Keys of `[design.workspace]`.
#[rustfmt::skip]
pub(crate) const WORKSPACE_KEYS: &[Key] = &[
    Key { name: "halfspace", form: Form::List(&Form::Table(HALFSPACE_KEYS), Length::Any), unit: "", default: "none", example: "", meaning: "normal·p >= offset for the origin p of a link or frame, in the base frame" },
    Key { name: "box", form: Form::List(&Form::Table(BOX_KEYS), Length::Any), unit: "", default: "none", example: "", meaning: "lower <= p <= upper for the origin p of a link or frame, in the base frame" },
    Key { name: "speed", form: Form::List(&Form::Table(SPEED_KEYS), Length::Any), unit: "", default: "none", example: "", meaning: "Largest speed of the origin of a link or frame" },
    Key { name: "clearance", form: Form::List(&Form::Table(CLEARANCE_KEYS), Length::Any), unit: "", default: "none", example: "", meaning: "Least distance between the collision shapes of two links" },
    Key { name: "shape", form: Form::List(&Form::Table(SHAPE_KEYS), Length::Any), unit: "", default: "those of the robot file", example: "", meaning: "A sphere or capsule on a link, beside the shapes of the robot file" },
];

/// Keys of `[[design.workspace.halfspace]]`.
#[rustfmt::skip]
pub(crate) const HALFSPACE_KEYS: &[Key] = &[
    Key { name: "frame", form: Form::Text, unit: "", default: REQUIRED, example: "\"tool0\"", meaning: "Link or frame of the robot file" },
    Key { name: "normal", form: Form::List(&Form::Number(Range::Finite), Length::Exactly(3)), unit: "", default: REQUIRED, example: "[0.0, 0.0, 1.0]", meaning: "Normal of the plane, into the space that is allowed" },
    Key { name: "offset", form: Form::Number(Range::Finite), unit: "m", default: REQUIRED, example: "0.1", meaning: "Distance of the plane from the base, along a normal of unit length" },
];

/// Keys of `[[design.workspace.box]]`.
#[rustfmt::skip]
pub(crate) const BOX_KEYS: &[Key] = &[
    Key { name: "frame", form: Form::Text, unit: "", default: REQUIRED, example: "\"tool0\"", meaning: "Link or frame of the robot file" },
    Key { name: "lower", form: CORNER, unit: "m", default: REQUIRED, example: "[-1.0, -1.0, 0.0]", meaning: "Lowest x, y and z; -inf where there is no limit" },
    Key { name: "upper", form: CORNER, unit: "m", default: REQUIRED, example: "[1.0, 1.0, inf]", meaning: "Highest x, y and z; inf where there is no limit" },
];

const CORNER: Form = Form::List(&Form::Number(Range::Any), Length::Exactly(3));

/// Keys of `[[design.workspace.speed]]`.
#[rustfmt::skip]
pub(crate) const SPEED_KEYS: &[Key] = &[
    Key { name: "frame", form: Form::Text, unit: "", default: REQUIRED, example: "\"tool0\"", meaning: "Link or frame of the robot file" },
    Key { name: "limit", form: Form::Number(Range::Positive), unit: "m/s", default: REQUIRED, example: "0.5", meaning: "Largest speed of its origin in the base frame" },
];

/// Keys of `[[design.workspace.clearance]]`.
#[rustfmt::skip]
pub(crate) const CLEARANCE_KEYS: &[Key] = &[
    Key { name: "links", form: Form::List(&Form::Text, Length::TwoDistinct), unit: "", default: REQUIRED, example: "[\"link2\", \"link6\"]", meaning: "The two links" },
    Key { name: "distance", form: Form::Number(Range::NonNegative), unit: "m", default: REQUIRED, example: "0.05", meaning: "Least distance between their shapes" },
];

/// Keys of `[[design.workspace.shape]]`.
#[rustfmt::skip]
pub(crate) const SHAPE_KEYS: &[Key] = &[
    Key { name: "link", form: Form::Text, unit: "", default: REQUIRED, example: "\"link6\"", meaning: "Link of the robot file, or its base" },
    Key { name: "ends", form: Form::List(&Form::List(&Form::Number(Range::Finite), Length::Exactly(3)), Length::OneOrTwo), unit: "m", default: REQUIRED, example: "[[0.0, 0.0, 0.0], [0.0, 0.0, 0.2]]", meaning: "The centre of a sphere, or both ends of a capsule, in the frame of the link" },
    Key { name: "radius", form: Form::Number(Range::Positive), unit: "m", default: REQUIRED, example: "0.08", meaning: "Radius of the capsule" },
];

/// Enough harmonics for full rank on six joints, few enough to stay smooth.
const DEFAULT_HARMONICS: usize = 5;
/// s.
const DEFAULT_PERIOD: f64 = 10.0;
/// Enough speeds to see a curved law of friction, few enough for a plan of minutes.
const DEFAULT_SPEEDS: usize = 8;
/// Samples per period: 40 per cycle of the fifth harmonic.
const DEFAULT_SAMPLES: usize = 200;

/// The table `[design]`.
#[derive(Debug, Clone)]
pub struct DesignTable {
    /// Default: [`DesignKind::Fourier`].
    pub kind: Located<DesignKind>,
    /// Harmonics of the Fourier series, at least 1, of all joints or per joint. Default: 5.
    pub harmonics: Located<Harmonics>,
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
    /// Coefficients or result of an earlier design that the search goes on from. Default: none.
    pub start_from: Option<Located<FilePath>>,
    /// Coefficients or result of a motion to compare with. Default: none.
    pub reference: Option<Located<FilePath>>,
    /// Where the ramps of a motion begin and end, rad (m). Default: the middle of the ranges.
    pub rest_position: Option<Located<PerJoint>>,
    /// Speeds of each joint in a plan of constant velocities, at least 2. Default: 8.
    pub speeds: Located<usize>,
    /// Models that a motion is to tell apart. Default: none.
    pub rival: Vec<Rival>,
    /// Parameter values that torques are predicted with. Default: those of the robot file or an earlier fit.
    pub values: Vec<Named<f64>>,
    /// Limits of the joints.
    pub limits: LimitsTable,
    /// Limits in space.
    pub workspace: WorkspaceTable,
}

/// Harmonics of the Fourier series.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Harmonics {
    /// As many for each joint.
    All(usize),
    /// In the order of the joints.
    Each(Vec<usize>),
}

impl Harmonics {
    /// The most of any joint.
    pub fn most(&self) -> usize {
        match self {
            Self::All(count) => *count,
            Self::Each(counts) => counts.iter().copied().max().unwrap_or(1),
        }
    }
}

/// One of the models that a motion is to tell apart: the problem file's, but for what is given here.
#[derive(Debug, Clone)]
pub struct Rival {
    /// Name in the result.
    pub name: Located<String>,
    /// What replaces `drive.effects` on all joints. Default: the problem file's effects.
    pub effects: Option<Located<Vec<Located<String>>>>,
    /// What replaces the effects of single joints. Default: none.
    pub effects_of: Vec<Named<Vec<Located<String>>>>,
    /// Result of a fit of this model: its values. Default: those of the problem file.
    pub parameters: Option<Located<FilePath>>,
    /// Values of single parameters. Default: none.
    pub values: Vec<Named<f64>>,
}

/// The parameters whose accuracy a design improves; the rest are nuisance parameters.
#[derive(Debug, Clone, PartialEq)]
pub enum DesignParameters {
    /// All unknown parameters.
    All,
    /// Those of links.
    Inertial,
    /// Those of the load.
    Payload,
    /// Those of effects of the drives.
    Friction,
    /// These.
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
    /// Points that stay on one side of a plane.
    pub halfspace: Vec<Halfspace>,
    /// Points that stay in a box; the table `box`.
    pub boxes: Vec<Region>,
    /// Points whose speed is limited.
    pub speed: Vec<Speed>,
    /// Links that keep a distance.
    pub clearance: Vec<Clearance>,
    /// Shapes beside those of the robot file.
    pub shape: Vec<Shape>,
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

/// lower <= p <= upper for the origin p of a link or frame, in the base frame.
#[derive(Debug, Clone)]
pub struct Region {
    /// Link or frame of the robot file.
    pub frame: Located<String>,
    /// m; minus infinity where there is no limit.
    pub lower: Located<[f64; 3]>,
    /// m; infinity where there is no limit.
    pub upper: Located<[f64; 3]>,
}

/// Largest speed of the origin of a link or frame in the base frame.
#[derive(Debug, Clone)]
pub struct Speed {
    /// Link or frame of the robot file.
    pub frame: Located<String>,
    /// m/s, positive.
    pub limit: Located<f64>,
}

/// A sphere (one end) or a capsule (two) on a link.
#[derive(Debug, Clone)]
pub struct Shape {
    /// Link of the robot file, or its base.
    pub link: Located<String>,
    /// m, in the frame of the link.
    pub ends: Located<Vec<[f64; 3]>>,
    /// m, positive.
    pub radius: Located<f64>,
}

/// Least distance between the collision shapes of two links.
#[derive(Debug, Clone)]
pub struct Clearance {
    /// Names of the two links.
    pub links: Located<[String; 2]>,
    /// m, not negative.
    pub distance: Located<f64>,
}

impl DesignTable {
    pub(super) fn from_node(node: &Node, context: &Context) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, KEYS)?;
        let file = |n: &Node| values::file_path(n, context);
        let rivals = reader.tables("rival")?;
        let rival: Vec<Rival> = rivals
            .iter()
            .map(|table| Rival::from_node(table, context))
            .collect::<Result<_, _>>()?;
        values::check_no_duplicates(rival.iter().map(|rival| &rival.name))?;
        Ok(Self {
            kind: reader.or("kind", DesignKind::Fourier, values::choice)?,
            harmonics: reader.or("harmonics", Harmonics::All(DEFAULT_HARMONICS), harmonics)?,
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
            start_from: reader.optional("start_from", file)?,
            reference: reader.optional("reference", file)?,
            rest_position: reader.optional("rest_position", values::per_joint_finite)?,
            speeds: reader.or("speeds", DEFAULT_SPEEDS, values::count)?,
            rival,
            values: reader.named("values", values::finite)?,
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
        Ok(Self {
            halfspace: each(&reader, "halfspace", Halfspace::from_node)?,
            boxes: each(&reader, "box", Region::from_node)?,
            speed: each(&reader, "speed", Speed::from_node)?,
            clearance: each(&reader, "clearance", Clearance::from_node)?,
            shape: each(&reader, "shape", Shape::from_node)?,
        })
    }
}

fn each<T>(
    reader: &Reader<'_>,
    key: &str,
    parse: impl Fn(&Node) -> Result<T, ProblemFileError>,
) -> Result<Vec<T>, ProblemFileError> {
    reader.tables(key)?.iter().map(parse).collect()
}

impl Rival {
    fn from_node(node: &Node, context: &Context) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, RIVAL_KEYS)?;
        Ok(Self {
            name: reader.required("name", "name the rival", values::text)?,
            effects: reader.optional("effects", |n| values::effects(n, context))?,
            effects_of: reader.named("effects_of", |n| values::effects(n, context))?,
            parameters: reader.optional("parameters", |n| values::file_path(n, context))?,
            values: reader.named("values", values::finite)?,
        })
    }
}

impl Region {
    fn from_node(node: &Node) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, BOX_KEYS)?;
        let corner = |n: &Node| values::array(n, "three numbers along x, y, z", values::not_nan);
        let lower = reader.required("lower", "state the lower corner in m", corner)?;
        let upper = reader.required("upper", "state the upper corner in m", corner)?;
        if let Some(axis) = (0..3).find(|&axis| lower.value[axis] >= upper.value[axis]) {
            let (lower_value, upper_value) = (lower.value[axis], upper.value[axis]);
            return Err(ProblemFileError::new(
                &lower.place,
                NumberFault::LowerAboveUpper {
                    lower: lower_value,
                    upper: upper_value,
                },
            ));
        }
        Ok(Self {
            frame: reader.required("frame", "name a link or frame", values::text)?,
            lower,
            upper,
        })
    }
}

impl Speed {
    fn from_node(node: &Node) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, SPEED_KEYS)?;
        Ok(Self {
            frame: reader.required("frame", "name a link or frame", values::text)?,
            limit: reader.required("limit", "state the speed in m/s", values::positive)?,
        })
    }
}

impl Shape {
    fn from_node(node: &Node) -> Result<Self, ProblemFileError> {
        const ENDS: &str = "one centre or two ends, each three numbers along x, y, z";
        let reader = Reader::open(node, SHAPE_KEYS)?;
        let ends = reader.required("ends", "state one centre or two ends in m", |n| {
            let ends = values::items(n, ENDS)?;
            match ends.len() {
                1 | 2 => ends.iter().map(values::vector3).collect(),
                found => Err(ProblemFileError::new(
                    &n.place,
                    ValueFault::WrongLength {
                        expected: ENDS.to_owned(),
                        found,
                    },
                )),
            }
        })?;
        Ok(Self {
            link: reader.required("link", "name a link", values::text)?,
            ends,
            radius: reader.required("radius", "state the radius in m", values::positive)?,
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

fn harmonics(node: &Node) -> Result<Harmonics, ProblemFileError> {
    match &node.value {
        NodeValue::List(items) => {
            let counts = items.iter().map(values::count).collect::<Result<_, _>>()?;
            Ok(Harmonics::Each(values::not_empty(counts, node)?))
        }
        _ => values::count(node).map(Harmonics::All),
    }
}

const GROUPS: &[(&str, DesignParameters)] = &[
    ("all", DesignParameters::All),
    ("inertial", DesignParameters::Inertial),
    ("payload", DesignParameters::Payload),
    ("friction", DesignParameters::Friction),
];

fn groups() -> Vec<&'static str> {
    GROUPS.iter().map(|(word, _)| *word).collect()
}

fn design_parameters(node: &Node) -> Result<DesignParameters, ProblemFileError> {
    match &node.value {
        NodeValue::Text(word) => GROUPS
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
                        known: groups().into_iter().map(str::to_owned).collect(),
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
