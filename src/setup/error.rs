//! Why the objects that a problem file describes cannot be built.

use crate::fault::{Description, Fault, Place, write_fault};
use crate::outcome::error::OutcomeError;
use crate::problem_file::ProblemFileError;
use crate::recording::error::RecordingError;
use crate::robot::error::RobotError;
use std::fmt;

/// A fault of the problem file, or of a file that it names.
#[derive(Debug)]
pub enum SetupError {
    ProblemFile(ProblemFileError),
    Robot(RobotError),
    Recording(Box<RecordingError>),
    /// An earlier result that the problem file starts from.
    Earlier(Box<OutcomeError>),
    /// The problem file and the robot or the recordings do not fit together.
    Mismatch {
        place: Place,
        kind: Box<Mismatch>,
    },
}

/// How the problem file and what it names do not fit together.
#[derive(Debug, Clone, PartialEq)]
pub enum Mismatch {
    UnknownJoint {
        found: String,
        known: Vec<String>,
    },
    UnknownFrame {
        found: String,
        known: Vec<String>,
    },
    JointTwice {
        found: String,
    },
    JointMissing {
        missing: Vec<String>,
    },
    AllLocked,
    UnknownParameter {
        found: String,
        nearest: Option<String>,
    },
    OutOfBounds {
        found: f64,
        lower: f64,
        upper: f64,
    },
    NeedsMass {
        found: String,
    },
    SingularCoupling,
    CouplingSize {
        found: usize,
        expected: usize,
    },
    LockedCoupled {
        joint: String,
    },
    NeedsTorqueConstant,
    NeedsRatio,
    NotYet {
        what: String,
        instead: String,
    },
    NotAFit,
    Impossible {
        link: String,
        eigenvalue: f64,
    },
    Unreachable {
        what: String,
    },
}

impl SetupError {
    pub fn mismatch(place: &Place, kind: Mismatch) -> Self {
        Self::Mismatch {
            place: place.clone(),
            kind: Box::new(kind),
        }
    }

    /// Whether a recording or robot file is at fault, and not the problem file.
    pub fn concerns_data(&self) -> bool {
        match self {
            Self::Robot(_) => true,
            Self::Recording(e) => !e.kind.concerns_request(),
            Self::Mismatch { kind, .. } => matches!(**kind, Mismatch::Impossible { .. }),
            _ => false,
        }
    }
}

impl Fault for SetupError {
    fn place(&self) -> &Place {
        match self {
            Self::ProblemFile(e) => e.place(),
            Self::Robot(e) => e.place(),
            Self::Recording(e) => e.place(),
            Self::Earlier(e) => e.place(),
            Self::Mismatch { place, .. } => place,
        }
    }

    fn describe(&self) -> Description {
        match self {
            Self::ProblemFile(e) => e.describe(),
            Self::Robot(e) => e.describe(),
            Self::Recording(e) => e.describe(),
            Self::Earlier(e) => e.describe(),
            Self::Mismatch { kind, .. } => match kind.as_ref() {
                Mismatch::UnknownJoint { .. }
                | Mismatch::UnknownFrame { .. }
                | Mismatch::JointTwice { .. }
                | Mismatch::JointMissing { .. }
                | Mismatch::AllLocked
                | Mismatch::LockedCoupled { .. } => of_joints(kind),
                _ => of_values(kind),
            },
        }
    }
}

fn list(names: &[String]) -> String {
    names.join(", ")
}

fn of_joints(kind: &Mismatch) -> Description {
    match kind {
        Mismatch::UnknownJoint { found, known } => Description::new(
            "unknown-joint",
            format!("the robot has no moving joint `{found}`"),
            format!("its moving joints are {}", list(known)),
        ),
        Mismatch::UnknownFrame { found, known } => Description::new(
            "unknown-frame",
            format!("the robot has no link or frame `{found}`"),
            format!("its links and frames are {}", list(known)),
        ),
        Mismatch::JointTwice { found } => Description::new(
            "joint-twice",
            format!("joint `{found}` is listed twice"),
            "list every joint once",
        ),
        Mismatch::JointMissing { missing } => Description::new(
            "joint-missing",
            format!("the list leaves out {}", list(missing)),
            "list every moving joint of the robot; hold those that stand still under `robot.locked`",
        ),
        Mismatch::AllLocked => Description::new(
            "all-joints-locked",
            "every joint is locked",
            "leave at least one joint that moves",
        ),
        Mismatch::LockedCoupled { joint } => Description::new(
            "locked-joint-coupled",
            format!("joint `{joint}` is locked, but the coupling lets other motors move it"),
            "set its row of `drive.coupling` to that of the identity",
        ),
        other => of_values(other),
    }
}

fn of_values(kind: &Mismatch) -> Description {
    match kind {
        Mismatch::UnknownParameter { found, nearest } => Description::new(
            "unknown-parameter",
            format!("the model has no parameter `{found}`"),
            match nearest {
                Some(name) => format!("did you mean `{name}`?"),
                None => "see `exid effects` for the names".to_string(),
            },
        ),
        Mismatch::OutOfBounds {
            found,
            lower,
            upper,
        } => Description::new(
            "parameter-out-of-bounds",
            format!("the value {found} lies outside {lower} .. {upper}"),
            "give a value within the bounds",
        ),
        Mismatch::NeedsMass { found } => Description::new(
            "parameter-needs-mass",
            format!(
                "`{found}` cannot be given alone: torques are linear in mass times centre of mass and in inertia about the link's origin"
            ),
            "give the link's mass too (and for an inertia its centre of mass)",
        ),
        Mismatch::SingularCoupling => Description::new(
            "singular-coupling",
            "the coupling matrix cannot be inverted",
            "give independent rows; a joint that nothing moves is locked",
        ),
        Mismatch::CouplingSize { found, expected } => Description::new(
            "coupling-size",
            format!("the coupling matrix has {found} rows for {expected} joints"),
            format!("give {expected} rows of {expected} numbers"),
        ),
        other => of_needs(other),
    }
}

fn of_needs(kind: &Mismatch) -> Description {
    match kind {
        Mismatch::NeedsTorqueConstant => Description::new(
            "needs-torque-constant",
            "the signal is a current, and nothing says how much torque a current gives",
            "set `drive.torque_constant` in N·m/A at the joint side, or `recordings.signal` to what the files hold",
        ),
        Mismatch::NeedsRatio => Description::new(
            "needs-ratio",
            "the recordings are of the motor's side, and no ratio leads to the joint's",
            "set `drive.ratio`, motor turns per joint turn",
        ),
        Mismatch::NotYet { what, instead } => Description::new(
            "not-available",
            format!("{what} is not available here"),
            instead,
        ),
        Mismatch::NotAFit => Description::new(
            "not-a-fit",
            "the earlier result is not that of a fit",
            "name the result.json that `exid fit` wrote",
        ),
        Mismatch::Impossible { link, eigenvalue } => Description::new(
            "impossible-inertia",
            format!(
                "no body has the inertial parameters of link `{link}`: its pseudo-inertia has the eigenvalue {eigenvalue:.3e}"
            ),
            "correct mass and inertia in the robot file (principal moments obey the triangle inequality), or use `inertials = \"estimate\"`",
        ),
        Mismatch::Unreachable { what } => Description::new(
            "unreachable",
            what.clone(),
            "widen the limits or shorten the motion",
        ),
        other => of_joints(other),
    }
}

impl fmt::Display for SetupError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_fault(f, self)
    }
}

impl std::error::Error for SetupError {}

impl From<ProblemFileError> for SetupError {
    fn from(e: ProblemFileError) -> Self {
        Self::ProblemFile(e)
    }
}

impl From<RobotError> for SetupError {
    fn from(e: RobotError) -> Self {
        Self::Robot(e)
    }
}

impl From<RecordingError> for SetupError {
    fn from(e: RecordingError) -> Self {
        Self::Recording(Box::new(e))
    }
}
