//! What can be wrong with a robot file.

use crate::fault::{Description, Fault, Place, write_fault};
use crate::robot::mjcf_fault::MjcfFault;
use std::fmt;

/// A fault of a robot description, with its place.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotError {
    /// The file, with line and element where they are known.
    pub place: Place,
    // Boxed, so that every result of the readers stays small.
    /// What is wrong there.
    pub kind: Box<RobotErrorKind>,
}

impl RobotError {
    /// A fault at a place.
    pub fn new(place: Place, kind: RobotErrorKind) -> Self {
        Self {
            place,
            kind: Box::new(kind),
        }
    }
}

/// Largest magnitude of a length (m), angle (rad), mass (kg) or moment of inertia (kg·m²): far beyond
/// any robot, and products of several such numbers stay finite.
pub(crate) const LARGEST_NUMBER: f64 = 1e20;

/// Kinds of faults of a robot description.
#[derive(Debug, Clone, PartialEq)]
pub enum RobotErrorKind {
    /// No file has the path.
    NotFound,
    /// The path is a folder's.
    IsDirectory,
    /// The operating system does not give the file.
    NotReadable {
        /// What it says.
        reason: String,
    },
    /// The file is larger than any description of a robot.
    TooLarge {
        /// Its size in bytes, at least.
        bytes: u64,
        /// The largest size that is read, bytes.
        limit: u64,
    },
    /// The file is not UTF-8.
    NotText,
    /// There is nothing in the file.
    Empty,
    /// The file is not well-formed XML.
    NotXml {
        /// What the XML reader says.
        reason: String,
    },
    /// The root element is not that of a robot.
    NotRobot {
        /// Name of the root element.
        root: String,
    },
    /// An element lacks an attribute that it needs.
    MissingAttribute {
        /// Name of the element.
        element: String,
        /// The attribute that is missing.
        attribute: &'static str,
    },
    /// An element lacks one that it has to contain.
    MissingElement {
        /// Name of the element.
        element: String,
        /// The element that is missing in it.
        child: &'static str,
    },
    /// A text stands where a number is needed.
    NotNumber {
        /// The text.
        found: String,
    },
    /// A number is infinite or NaN.
    NotFinite {
        /// As written.
        found: String,
    },
    /// A magnitude that no robot has in SI units.
    TooLargeNumber {
        /// As written.
        found: String,
        /// The largest magnitude that is read.
        limit: f64,
    },
    /// A list has too many or too few numbers.
    WrongCount {
        /// How many it has.
        found: usize,
        /// How many are needed.
        expected: usize,
    },
    /// The kind of a joint is none that URDF knows.
    UnknownJointType {
        /// The kind as written.
        found: String,
        /// The known kind most like it.
        nearest: Option<String>,
    },
    /// A file with macros that are not expanded.
    Xacro,
    /// A joint follows one that does not exist.
    UnknownLeader {
        /// The name as written.
        found: String,
        /// The name of a joint most like it.
        nearest: Option<String>,
    },
    /// A joint follows two others.
    TwoLeaders {
        /// The joints that it follows.
        leaders: [String; 2],
    },
    /// Joints follow each other, and none of them leads.
    LeadersInCircle {
        /// Their names, along the circle.
        joints: Vec<String>,
    },
    /// Two joints have one name.
    DuplicateJoint {
        /// Line of the first of them, where it is known.
        first_line: Option<usize>,
    },
    /// Two links have one name.
    DuplicateLink {
        /// Line of the first of them, where it is known.
        first_line: Option<usize>,
    },
    /// A link has two elements `inertial`.
    DuplicateInertial,
    /// A joint names a link that does not exist.
    UnknownLink {
        /// The name as written.
        found: String,
        /// The name of a link most like it.
        nearest: Option<String>,
    },
    /// Two joints carry one link: the tree would have a loop.
    TwoParents {
        /// The link.
        link: String,
        /// The other joint that carries it.
        other: String,
    },
    /// Links carry each other in a circle.
    Cycle {
        /// Their names, along the circle.
        links: Vec<String>,
    },
    /// Several links are carried by none, where one base is needed.
    SeveralRoots {
        /// Their names.
        roots: Vec<String>,
    },
    /// The file has no link.
    NoLinks,
    /// Every joint is fixed: there is nothing to identify.
    NoMovingJoint,
    /// The robot has more moving joints than are read.
    TooManyJoints {
        /// How many it has.
        found: usize,
        /// How many are read.
        limit: usize,
    },
    /// The axis of a joint is the zero vector.
    ZeroAxis,
    /// The mass of a link is below zero.
    NegativeMass {
        /// As written, kg.
        found: f64,
    },
    /// The lower limit of a joint is above its upper one.
    LimitsReversed {
        /// rad (m).
        lower: f64,
        /// rad (m).
        upper: f64,
    },
    /// The table of modified Denavit-Hartenberg parameters cannot be read.
    NotMdh {
        /// What is wrong with it.
        reason: String,
    },
    /// A fault that only MJCF files have.
    Mjcf(MjcfFault),
}

impl Fault for RobotError {
    fn place(&self) -> &Place {
        &self.place
    }

    fn describe(&self) -> Description {
        match &*self.kind {
            RobotErrorKind::Mjcf(fault) => fault.describe(),
            kind @ (RobotErrorKind::NotFound
            | RobotErrorKind::IsDirectory
            | RobotErrorKind::NotReadable { .. }
            | RobotErrorKind::TooLarge { .. }
            | RobotErrorKind::NotText
            | RobotErrorKind::Empty
            | RobotErrorKind::NotXml { .. }
            | RobotErrorKind::NotRobot { .. }
            | RobotErrorKind::Xacro
            | RobotErrorKind::NotMdh { .. }) => of_file(kind),
            kind @ (RobotErrorKind::MissingAttribute { .. }
            | RobotErrorKind::MissingElement { .. }
            | RobotErrorKind::NotNumber { .. }
            | RobotErrorKind::NotFinite { .. }
            | RobotErrorKind::TooLargeNumber { .. }
            | RobotErrorKind::WrongCount { .. }
            | RobotErrorKind::ZeroAxis
            | RobotErrorKind::NegativeMass { .. }
            | RobotErrorKind::LimitsReversed { .. }) => of_value(kind),
            kind => of_joint(kind),
        }
    }
}

fn suggestion(nearest: &Option<String>, otherwise: &str) -> String {
    match nearest {
        Some(name) => format!("did you mean `{name}`?"),
        None => otherwise.to_string(),
    }
}

fn already(element: &str, first_line: &Option<usize>) -> String {
    match first_line {
        Some(line) => format!("a {element} of this name stands at line {line} already"),
        None => format!("there is a {element} of this name already"),
    }
}

fn of_file(kind: &RobotErrorKind) -> Description {
    use RobotErrorKind as K;
    match kind {
        K::NotFound => Description::new(
            "robot-file-not-found",
            "there is no such robot file",
            "correct the path; what a problem file names is relative to the problem file",
        ),
        K::IsDirectory => Description::new(
            "robot-file-is-directory",
            "the robot file is a directory",
            "name the file inside it",
        ),
        K::NotReadable { reason } => Description::new(
            "robot-file-not-readable",
            format!("the robot file cannot be read: {reason}"),
            "check its permissions",
        ),
        K::TooLarge { bytes, limit } => Description::new(
            "robot-file-too-large",
            format!("the robot file has {bytes} bytes or more, above the limit of {limit}"),
            "check that this is a robot description and not a recording or mesh",
        ),
        K::NotText => Description::new(
            "robot-file-not-text",
            "the robot file is not UTF-8 text",
            "save it as UTF-8",
        ),
        K::Empty => Description::new(
            "robot-file-empty",
            "the robot file is empty",
            "write the robot's description into it",
        ),
        K::NotXml { reason } => Description::new(
            "urdf-not-xml",
            format!("the file is not well-formed XML: {reason}"),
            "correct the XML; xacro files must be expanded first",
        ),
        K::NotMdh { reason } => Description::new(
            "mdh-not-readable",
            format!("the table of Denavit-Hartenberg parameters cannot be read: {reason}"),
            "see the README for its keys",
        ),
        K::Xacro => Description::new(
            "urdf-xacro",
            "the file has xacro macros, which are no URDF before they are expanded",
            "expand it with `xacro robot.urdf.xacro > robot.urdf` and name the file that this writes",
        ),
        K::NotRobot { root } if root == "mujoco" => Description::new(
            "urdf-not-robot",
            "the root element is <mujoco>, not <robot>: the file is MJCF",
            "name it as robot.mjcf instead of robot.urdf",
        ),
        K::NotRobot { root } => Description::new(
            "urdf-not-robot",
            format!("the root element is <{root}>, not <robot>"),
            "give a URDF file, or an MJCF file as robot.mjcf; SDF is another format",
        ),
        other => of_joint(other),
    }
}

fn of_value(kind: &RobotErrorKind) -> Description {
    use RobotErrorKind as K;
    match kind {
        K::MissingAttribute { element, attribute } => Description::new(
            "urdf-missing-attribute",
            format!("<{element}> has no attribute `{attribute}`"),
            format!("add {attribute}=\"...\""),
        ),
        K::MissingElement { element, child } => Description::new(
            "urdf-missing-element",
            format!("<{element}> has no <{child}>"),
            format!("add <{child} .../>"),
        ),
        K::NotNumber { found } => Description::new(
            "robot-not-a-number",
            format!("`{found}` is not a number"),
            "write a decimal number",
        ),
        K::NotFinite { found } => Description::new(
            "robot-not-finite",
            format!("`{found}` is not a finite number"),
            "write a finite number",
        ),
        K::TooLargeNumber { found, limit } => Description::new(
            "robot-number-too-large",
            format!("the magnitude of `{found}` is above {limit:e}"),
            "write lengths in m, masses in kg and angles in rad",
        ),
        K::WrongCount { found, expected } => Description::new(
            "robot-wrong-count",
            format!("{found} numbers where {expected} are needed"),
            format!("write {expected} numbers separated by spaces"),
        ),
        K::ZeroAxis => Description::new(
            "robot-zero-axis",
            "the joint's axis has no length",
            "give a direction, for example xyz=\"0 0 1\"",
        ),
        K::NegativeMass { found } => Description::new(
            "robot-negative-mass",
            format!("the mass is {found} kg"),
            "give a mass that is not negative",
        ),
        K::LimitsReversed { lower, upper } => Description::new(
            "robot-limits-reversed",
            format!("the lower limit {lower} is above the upper limit {upper}"),
            "exchange them",
        ),
        other => of_joint(other),
    }
}

fn of_joint(kind: &RobotErrorKind) -> Description {
    use RobotErrorKind as K;
    match kind {
        K::UnknownJointType { found, nearest } => Description::new(
            "urdf-unknown-joint-type",
            format!("the joint's type is `{found}`"),
            suggestion(
                nearest,
                "write revolute, continuous, prismatic, fixed, floating or planar",
            ),
        ),
        K::UnknownLeader { found, nearest } => Description::new(
            "robot-unknown-leader",
            format!("the joint follows `{found}`, and there is no such joint"),
            suggestion(nearest, "name a joint of the robot"),
        ),
        K::TwoLeaders { leaders } => Description::new(
            "robot-two-leaders",
            format!("the joint follows {} at once", leaders.join(" and ")),
            "keep one of them",
        ),
        K::LeadersInCircle { joints } => Description::new(
            "robot-leaders-in-circle",
            format!(
                "the joints {} follow each other in a circle",
                joints.join(", ")
            ),
            "let one of them follow none",
        ),
        other => of_structure(other),
    }
}

fn of_structure(kind: &RobotErrorKind) -> Description {
    use RobotErrorKind as K;
    match kind {
        K::DuplicateJoint { first_line } => Description::new(
            "robot-duplicate-joint",
            already("joint", first_line),
            "give every joint its own name",
        ),
        K::DuplicateLink { first_line } => Description::new(
            "robot-duplicate-link",
            already("link", first_line),
            "give every link its own name",
        ),
        K::DuplicateInertial => Description::new(
            "urdf-duplicate-inertial",
            "the link has two <inertial> elements",
            "keep one of them",
        ),
        K::UnknownLink { found, nearest } => Description::new(
            "urdf-unknown-link",
            format!("there is no link `{found}`"),
            suggestion(nearest, "define the link or correct the name"),
        ),
        K::TwoParents { link, other } => Description::new(
            "urdf-two-parents",
            format!("link `{link}` is the child of joint `{other}` too"),
            "a link hangs on one joint; closed loops need a mechanism of their own",
        ),
        K::Cycle { links } => Description::new(
            "urdf-cycle",
            format!(
                "the links {} hang on each other in a circle",
                links.join(", ")
            ),
            "cut the circle at one joint",
        ),
        K::SeveralRoots { roots } => Description::new(
            "urdf-several-roots",
            format!("the links {} all have no parent", roots.join(", ")),
            "connect them to one base link by fixed joints",
        ),
        K::TooManyJoints { found, limit } => Description::new(
            "robot-too-many-joints",
            format!("the robot has {found} moving joints, more than {limit}"),
            "make the joints fixed that are not to be identified",
        ),
        K::NoLinks => Description::new(
            "urdf-no-links",
            "the robot has no links",
            "define links and joints",
        ),
        _ => Description::new(
            "robot-no-moving-joint",
            "no joint of the robot can move",
            "make at least one joint revolute, continuous or prismatic",
        ),
    }
}

impl fmt::Display for RobotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_fault(f, self)
    }
}

impl std::error::Error for RobotError {}
