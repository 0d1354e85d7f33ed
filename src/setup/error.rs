//! Why the objects that a problem file describes cannot be built.

use crate::chain::error::ModelError;
use crate::fault::{Description, Fault, Place, write_fault};
use crate::outcome::error::OutcomeError;
use crate::problem_file::ProblemFileError;
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::robot::error::RobotError;
use std::fmt;

/// A fault of the problem file, or of a file that it names.
#[derive(Debug)]
pub enum SetupError {
    /// The problem file lacks a table, or a list has not one value per joint.
    ProblemFile(ProblemFileError),
    /// The robot's file cannot be read.
    Robot(RobotError),
    /// A recording.
    Recording(Box<RecordingError>),
    /// An earlier result that the problem file starts from.
    Earlier(Box<OutcomeError>),
    /// The problem file and the robot or the recordings do not fit together.
    Mismatch {
        /// The key of the problem file.
        place: Place,
        /// What does not fit.
        kind: Box<Mismatch>,
    },
}

/// How the problem file and what it names do not fit together.
#[derive(Debug, Clone, PartialEq)]
pub enum Mismatch {
    /// No moving joint has the name.
    UnknownJoint {
        /// As written.
        found: String,
        /// The moving joints.
        known: Vec<String>,
    },
    /// No link or fixed frame has the name.
    UnknownFrame {
        /// As written.
        found: String,
        /// Links and frames.
        known: Vec<String>,
    },
    /// A joint stands twice in a list.
    JointTwice {
        /// Its name.
        found: String,
    },
    /// A list leaves joints out.
    JointMissing {
        /// Their names.
        missing: Vec<String>,
    },
    /// Every joint is locked: there is nothing to identify.
    AllLocked,
    /// Position limits that leave nothing between them.
    NoRange {
        /// Its name.
        joint: String,
    },
    /// The model has no such parameter.
    UnknownParameter {
        /// As written.
        found: String,
        /// The name most like it.
        nearest: Option<String>,
    },
    /// A value outside of its parameter's limits.
    OutOfBounds {
        /// What was given, in the parameter's unit.
        found: f64,
        /// Its lower limit.
        lower: f64,
        /// Its upper limit.
        upper: f64,
    },
    /// A quantity of a body that cannot be known without its mass.
    NeedsMass {
        /// The quantity as written.
        found: String,
    },
    /// V has no inverse.
    SingularCoupling,
    /// V has not one row per joint.
    CouplingSize {
        /// Rows that it has.
        found: usize,
        /// Joints of the robot.
        expected: usize,
    },
    /// A locked joint that other motors move through V.
    LockedCoupled {
        /// Its name.
        joint: String,
    },
    /// As many polynomials as joints are needed.
    PolynomialCount {
        /// How many there are.
        found: usize,
        /// Joints of the robot.
        expected: usize,
    },
    /// A polynomial that does not rise at small currents.
    FallingPolynomial {
        /// Its name.
        joint: String,
        /// c1, N·m/A (N/A).
        slope: f64,
    },
    /// An effect that takes a parameter of another.
    NeedsEffect {
        /// Name of the joint.
        joint: String,
        /// Identifier of the effect.
        effect: &'static str,
        /// Identifier of the one that is missing.
        needs: &'static str,
    },
    /// An effect that knows the motion of a joint that is not there.
    NeedsJoint {
        /// Name of the joint that has the effect.
        joint: String,
        /// Identifier of the effect.
        effect: &'static str,
        /// The joint as the effect names it.
        needs: &'static str,
    },
    /// A `[[law]]` that is none, in words.
    Law(Description),
    /// Currents, and nothing that says how much torque they give.
    NeedsTorqueConstant,
    /// Positions of the motor's side, and no ratio to the joint's.
    NeedsRatio,
    /// Something that is asked for where it cannot be had.
    NotYet {
        /// What.
        what: String,
        /// What to do instead.
        instead: String,
    },
    /// A file that ought to be the result of a fit is none.
    NotAFit,
    /// No body has the inertial parameters of a link.
    Impossible {
        /// Name of the link.
        link: String,
        /// Least eigenvalue of its pseudo-inertia, kg.
        eigenvalue: f64,
    },
    /// Limits that leave no motion.
    Unreachable {
        /// Which, in words.
        what: String,
    },
    /// A mechanism that the problem file does not describe well; the words say what to do.
    Mechanism {
        /// What is wrong with the description, in words.
        what: String,
    },
    /// Joints that cannot have parameters of an effect in common.
    NotShared {
        /// What stands against it, in words.
        what: String,
        /// What to do instead.
        instead: String,
    },
}

impl SetupError {
    /// At a key of the problem file.
    pub fn mismatch(place: &Place, kind: Mismatch) -> Self {
        Self::Mismatch {
            place: place.clone(),
            kind: Box::new(kind),
        }
    }

    /// Whether reading was interrupted.
    pub fn is_interrupt(&self) -> bool {
        matches!(self, Self::Recording(e) if e.kind == RecordingErrorKind::Interrupted)
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
            Self::Mismatch { kind, .. } => {
                Description::new(kind.code(), kind.message(), kind.remedy())
            }
        }
    }
}

fn list(names: &[String]) -> String {
    names.join(", ")
}

impl Mismatch {
    fn code(&self) -> &'static str {
        match self {
            Self::UnknownJoint { .. } => "unknown-joint",
            Self::UnknownFrame { .. } => "unknown-frame",
            Self::JointTwice { .. } => "joint-twice",
            Self::JointMissing { .. } => "joint-missing",
            Self::AllLocked => "all-joints-locked",
            Self::NoRange { .. } => "no-range",
            Self::UnknownParameter { .. } => "unknown-parameter",
            Self::OutOfBounds { .. } => "parameter-out-of-bounds",
            Self::NeedsMass { .. } => "parameter-needs-mass",
            Self::SingularCoupling => "singular-coupling",
            Self::CouplingSize { .. } => "coupling-size",
            Self::LockedCoupled { .. } => "locked-joint-coupled",
            Self::PolynomialCount { .. } => "polynomial-count",
            Self::FallingPolynomial { .. } => "falling-polynomial",
            Self::NeedsEffect { .. } => "effect-needs-effect",
            Self::NeedsJoint { .. } => "effect-needs-joint",
            Self::Law(description) => description.code,
            Self::NeedsTorqueConstant => "needs-torque-constant",
            Self::NeedsRatio => "needs-ratio",
            Self::NotYet { .. } => "not-available",
            Self::NotAFit => "not-a-fit",
            Self::Impossible { .. } => "impossible-inertia",
            Self::Unreachable { .. } => "unreachable",
            Self::NotShared { .. } => "not-shared",
            Self::Mechanism { .. } => "mechanism",
        }
    }

    fn message(&self) -> String {
        match self {
            Self::UnknownJoint { found, .. } => format!("the robot has no moving joint `{found}`"),
            Self::UnknownFrame { found, .. } => {
                format!("the robot has no link or frame `{found}`")
            }
            Self::JointTwice { found } => format!("joint `{found}` is listed twice"),
            Self::JointMissing { missing } => format!("the list leaves out {}", list(missing)),
            Self::AllLocked => "every joint is locked".to_string(),
            Self::NoRange { joint } => {
                format!("joint `{joint}` has no room to move between its position limits")
            }
            Self::UnknownParameter { found, .. } => format!("the model has no parameter `{found}`"),
            Self::OutOfBounds {
                found,
                lower,
                upper,
            } => format!("the value {found} lies outside {lower} .. {upper}"),
            Self::NeedsMass { found } => format!(
                "`{found}` cannot be given alone: torques are linear in mass times centre of mass \
                 and in inertia about the link's origin"
            ),
            Self::NotYet { what, .. } => format!("{what} is not available here"),
            Self::NotAFit => "the earlier result is not that of a fit".to_string(),
            Self::Impossible { link, eigenvalue } => format!(
                "no body has the inertial parameters of link `{link}`: its pseudo-inertia has the \
                 eigenvalue {eigenvalue:.3e}"
            ),
            Self::Unreachable { what }
            | Self::Mechanism { what }
            | Self::NotShared { what, .. } => what.clone(),
            Self::Law(description) => description.message.clone(),
            drive => drive.message_of_drive(),
        }
    }

    fn message_of_drive(&self) -> String {
        match self {
            Self::SingularCoupling => "the coupling matrix cannot be inverted".to_string(),
            Self::CouplingSize { found, expected } => {
                format!("the coupling matrix has {found} rows for {expected} joints")
            }
            Self::LockedCoupled { joint } => {
                format!("joint `{joint}` is locked, but the coupling lets other motors move it")
            }
            Self::NeedsTorqueConstant => {
                "the signal is a current, and nothing says how much torque a current gives"
                    .to_string()
            }
            Self::NeedsRatio => {
                "the recordings are of the motor's side, and no ratio leads to the joint's"
                    .to_string()
            }
            Self::PolynomialCount { found, expected } => {
                format!("there are {found} polynomials for {expected} joints")
            }
            Self::FallingPolynomial { joint, slope } => format!(
                "the polynomial of `{joint}` has c1 = {slope}: torque would not rise with current"
            ),
            Self::NeedsEffect {
                joint,
                effect,
                needs,
            } => format!(
                "`{effect}` of `{joint}` takes a parameter of `{needs}`, which is not listed"
            ),
            Self::NeedsJoint {
                joint,
                effect,
                needs,
            } => format!(
                "`{effect}` of `{joint}` knows the motion of joint `{needs}`, which is not there"
            ),
            _ => self.code().to_string(),
        }
    }

    fn remedy(&self) -> String {
        let fixed = match self {
            Self::UnknownJoint { known, .. } => {
                return format!("its moving joints are {}", list(known));
            }
            Self::UnknownFrame { known, .. } => {
                return format!("its links and frames are {}", list(known));
            }
            Self::UnknownParameter {
                nearest: Some(name),
                ..
            } => return format!("did you mean `{name}`?"),
            Self::CouplingSize { expected, .. } => {
                return format!("give {expected} rows of {expected} numbers");
            }
            Self::NotYet { instead, .. } => return instead.clone(),
            Self::PolynomialCount { expected, .. } => {
                return format!("give {expected} rows of four coefficients, c0 to c3");
            }
            Self::Law(description) => return description.remedy.clone(),
            Self::NotShared { instead, .. } => return instead.clone(),
            Self::NeedsJoint { .. } => {
                "name a moving joint of the robot, or list the law for other joints under drive.effects_of"
            }
            Self::NeedsEffect { needs, .. } => {
                return format!("list `{needs}` for this joint as well");
            }
            Self::UnknownParameter { nearest: None, .. } => {
                "give joint.effect.parameter, as `exid effects` has them, or link.mass, link.com_x and so on, of this robot"
            }
            Self::JointTwice { .. } => "list every joint once",
            Self::JointMissing { .. } => {
                "list every moving joint of the robot; hold those that stand still under `robot.locked`"
            }
            Self::AllLocked => "leave at least one joint that moves",
            Self::NoRange { .. } => "correct the limits, or hold the joint under robot.locked",
            Self::LockedCoupled { .. } => "set its row of `drive.coupling` to that of the identity",
            Self::OutOfBounds { .. } => "give a value within the bounds",
            Self::NeedsMass { .. } => {
                "give the link's mass too (and for an inertia its centre of mass)"
            }
            Self::SingularCoupling => "give independent rows; a joint that nothing moves is locked",
            Self::NeedsTorqueConstant => {
                "set `drive.torque_constant` in N·m/A at the joint side, or `recordings.signal` to \
                 what the files hold"
            }
            Self::FallingPolynomial { .. } => {
                "give a positive c1, N·m/A at the joint side; a motor that is mounted the other way \
                 round is a sign of `drive.ratio`"
            }
            Self::NeedsRatio => "set `drive.ratio`, motor turns per joint turn",
            Self::NotAFit => "name the result.json that `exid fit` wrote",
            Self::Impossible { .. } => {
                "correct mass and inertia in the robot file (principal moments obey the triangle \
                 inequality), or use `inertials = \"estimate\"`"
            }
            Self::Unreachable { .. } => "widen the limits or shorten the motion",
            Self::Mechanism { .. } => {
                "correct it under [robot] or [recordings.sensors]; lengths are in metres, angles in radians"
            }
        };
        fixed.to_string()
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

pub(crate) fn unknown(place: &crate::fault::Place, found: &str, known: &[String]) -> SetupError {
    SetupError::mismatch(
        place,
        Mismatch::UnknownJoint {
            found: found.to_string(),
            known: known.to_vec(),
        },
    )
}

/// A fault of the model as one of the problem file.
pub(super) fn at(place: &Place, error: ModelError) -> SetupError {
    let kind = match error {
        ModelError::UnknownParameter { name, nearest } => Mismatch::UnknownParameter {
            found: name,
            nearest,
        },
        ModelError::NeedsMass { name } => Mismatch::NeedsMass { found: name },
        ModelError::OutOfBounds {
            value,
            lower,
            upper,
            ..
        } => Mismatch::OutOfBounds {
            found: value,
            lower,
            upper,
        },
        ModelError::SingularCoupling => Mismatch::SingularCoupling,
        ModelError::NeedsJoint {
            joint,
            effect,
            needs,
        } => Mismatch::NeedsJoint {
            joint,
            effect,
            needs,
        },
        ModelError::NeedsEffect {
            joint,
            effect,
            needs,
        } => Mismatch::NeedsEffect {
            joint,
            effect,
            needs,
        },
    };
    SetupError::mismatch(place, kind)
}

pub(super) fn faulty(place: &Place, what: String) -> SetupError {
    SetupError::mismatch(place, Mismatch::Mechanism { what })
}
