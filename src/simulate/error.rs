//! Why a problem file cannot be simulated.

use crate::chain::effect::TRANSITION;
use crate::fault::{Description, Fault, Place, write_fault};
use crate::problem_file::ProblemFileError;
use crate::recording::error::RecordingError;
use crate::setup::error::SetupError;
use std::fmt;

/// A fault of what the problem file names, or of the simulation that it asks for.
#[derive(Debug)]
pub enum SimulateError {
    /// The problem, its robot or its recordings.
    Setup(Box<SetupError>),
    /// The simulation itself.
    Simulation {
        /// The key of the problem file, or the file.
        place: Place,
        /// In a box, so that results without an error stay small.
        kind: Box<SimulateErrorKind>,
    },
}

/// The kinds of fault, each with what was found.
#[derive(Debug, Clone, PartialEq)]
pub enum SimulateErrorKind {
    /// An effect acts whose parameters have no values.
    NoValue {
        /// Joint and effect, `<joint>.<effect>`.
        effect: String,
        /// Names of the parameters.
        missing: Vec<String>,
    },
    /// A body is given a centre of mass or an inertia, and no mass.
    NeedsMass {
        /// Name of the link or load.
        body: String,
    },
    /// A concealed load beside the declared one.
    TwoLoads {
        /// The value that hangs it there.
        found: String,
    },
    /// Two rates are stated.
    RateConflict {
        /// simulate.rate, Hz.
        simulate: f64,
        /// recordings.rate, Hz.
        recordings: f64,
    },
    /// The recording would be too short to be read again.
    TooShort {
        /// Samples that it would have.
        samples: usize,
        /// Samples at least.
        least: usize,
    },
    /// A name that ends like no format that is written.
    FormatNotWritten {
        /// The name.
        found: String,
    },
    /// Two recordings would bear one name.
    SameName {
        /// The name.
        found: String,
    },
    /// Gravity leaves too little of a torque limit.
    Unreachable {
        /// Name of the joint.
        joint: String,
        /// Torque that it needs near its middle position, N·m (N).
        found: f64,
        /// Its limit, N·m (N).
        limit: f64,
    },
    /// The trajectory's file and the problem state different periods.
    PeriodConflict {
        /// Duration of the file, s.
        file: f64,
        /// recordings.period, s.
        recordings: f64,
    },
    /// A period is stated of a motion that has none.
    PeriodOfFreeMotion {
        /// recordings.period, s.
        recordings: f64,
    },
    /// A trajectory's file whose rows are not even in time.
    UnevenTime {
        /// A step of its time, s.
        step: f64,
        /// The mean step, s.
        mean: f64,
    },
    /// Dry friction without a transition, of which forward dynamics has no solution at rest.
    SharpFriction {
        /// Name of the joint.
        joint: String,
    },
    /// The mass matrix is not positive definite.
    SingularMass {
        /// Name of the joint at which its factorisation fails.
        joint: String,
        /// The pivot there, kg·m² (kg).
        pivot: f64,
    },
    /// A controlled joint leaves its trajectory.
    Diverged {
        /// Name of the joint.
        joint: String,
        /// When, s.
        time: f64,
    },
    /// More joints than forward dynamics has room for.
    TooManyJoints {
        /// How many.
        found: usize,
    },
    /// The loops of a mechanism stay open.
    OpenLoops {
        /// When in the motion, s.
        time: f64,
        /// What the mechanism says.
        reason: String,
    },
    /// It was interrupted; nothing was written.
    Interrupted,
}

impl SimulateError {
    pub(super) fn new(place: &Place, kind: SimulateErrorKind) -> Self {
        Self::Simulation {
            place: place.clone(),
            kind: Box::new(kind),
        }
    }

    /// Whether a recording or robot file is at fault, and not the problem file.
    pub fn concerns_data(&self) -> bool {
        match self {
            Self::Setup(e) => e.concerns_data(),
            Self::Simulation { .. } => false,
        }
    }

    /// Whether the caller ended the run.
    pub fn is_interrupt(&self) -> bool {
        match self {
            Self::Setup(_) => false,
            Self::Simulation { kind, .. } => **kind == SimulateErrorKind::Interrupted,
        }
    }
}

impl Fault for SimulateError {
    fn place(&self) -> &Place {
        match self {
            Self::Setup(e) => e.place(),
            Self::Simulation { place, .. } => place,
        }
    }

    fn describe(&self) -> Description {
        match self {
            Self::Setup(e) => e.describe(),
            Self::Simulation { kind, .. } => of_truth(kind)
                .or_else(|| of_motion(kind))
                .unwrap_or_else(|| of_dynamics(kind)),
        }
    }
}

fn of_truth(kind: &SimulateErrorKind) -> Option<Description> {
    use SimulateErrorKind as Kind;
    let words = match kind {
        Kind::NoValue { effect, missing } => Description::new(
            "needs-value",
            format!("{effect} acts in the model, and its truth has no value"),
            format!(
                "add {} to [simulate.values]",
                missing
                    .iter()
                    .map(|name| format!("\"{name}\""))
                    .collect::<Vec<_>>()
                    .join(", ")
            ),
        ),
        Kind::NeedsMass { body } => Description::new(
            "body-needs-mass",
            format!("`{body}` has no mass, and a centre of mass or an inertia is given for it"),
            format!("give \"{body}.mass\" too"),
        ),
        Kind::TwoLoads { found } => Description::new(
            "two-loads",
            format!("`{found}` hangs a load on the robot that `robot.payload` already has"),
            "give the values of the one load as payload.mass, payload.com_x and so on",
        ),
        _ => return None,
    };
    Some(words)
}

fn of_motion(kind: &SimulateErrorKind) -> Option<Description> {
    use SimulateErrorKind as Kind;
    let words = match kind {
        Kind::RateConflict {
            simulate,
            recordings,
        } => Description::new(
            "rate-conflict",
            format!("the rate is {simulate} Hz here and {recordings} Hz under recordings.rate"),
            "remove one of the two",
        ),
        Kind::TooShort { samples, least } => Description::new(
            "simulation-too-short",
            format!("the recording would have {samples} samples"),
            format!("raise simulate.periods or simulate.rate: {least} samples are the least"),
        ),
        Kind::FormatNotWritten { found } => Description::new(
            "format-not-written",
            format!("recordings are written as .csv or .csv.gz, not as `{found}`"),
            "list a file with one of these ends for the simulation",
        ),
        Kind::SameName { found } => Description::new(
            "same-recording-name",
            format!("two recordings would be written as `{found}` in the results folder"),
            "give the recordings different file names",
        ),
        Kind::Unreachable {
            joint,
            found,
            limit,
        } => Description::new(
            "torque-limit-unreachable",
            format!(
                "joint `{joint}` needs {found:.4} near its middle position, more than 80 % of its \
                 torque limit {limit:.4}"
            ),
            "raise design.limits.torque, or shift the middle by design.limits.position_lower and \
             position_upper",
        ),
        Kind::PeriodConflict { file, recordings } => Description::new(
            "period-conflict",
            format!("the trajectory lasts {file:.6} s and recordings.period is {recordings} s"),
            "give one period of the motion in the file, or correct recordings.period",
        ),
        Kind::PeriodOfFreeMotion { recordings } => Description::new(
            "period-of-free-motion",
            format!(
                "recordings.period is {recordings} s and the motion of [simulate] does not repeat"
            ),
            "remove recordings.period, or simulate a motion that repeats: trajectory = \"random\"",
        ),
        Kind::UnevenTime { step, mean } => Description::new(
            "uneven-time",
            format!("a step of the time column is {step:.6} s where the mean step is {mean:.6} s"),
            "give a periodic trajectory at even steps",
        ),
        _ => return None,
    };
    Some(words)
}

fn of_dynamics(kind: &SimulateErrorKind) -> Description {
    use SimulateErrorKind as Kind;
    match kind {
        Kind::SharpFriction { joint } => Description::new(
            "friction-without-width",
            format!(
                "the Coulomb friction of joint `{joint}` jumps at standstill (w = 0), where \
                 forward dynamics has no solution"
            ),
            format!(
                "set \"{joint}.{}.{}\" to 0.004, or use mode = \"inverse\"",
                TRANSITION.effect.id,
                TRANSITION.name()
            ),
        ),
        Kind::SingularMass { joint, pivot } => Description::new(
            "singular-mass",
            format!("the mass matrix is not positive definite at joint `{joint}` ({pivot:.3e})"),
            "correct the inertial parameters of its links, or give drive.rotor_inertia",
        ),
        Kind::Diverged { joint, time } => Description::new(
            "simulation-diverged",
            format!("joint `{joint}` leaves its trajectory at t = {time:.3} s"),
            "reduce the concealed effects or the motion, or use mode = \"inverse\"",
        ),
        Kind::TooManyJoints { found } => Description::new(
            "too-many-joints",
            format!("forward dynamics of {found} joints is not available"),
            "use mode = \"inverse\"",
        ),
        Kind::OpenLoops { time, reason } => Description::new(
            "loops-open",
            format!("at t = {time:.3} s of the motion {reason}"),
            "narrow design.limits.position_lower and position_upper about a position at which the loops close",
        ),
        _ => Description::new(
            "interrupted",
            "the simulation was interrupted",
            "run it again; nothing was written",
        ),
    }
}

impl fmt::Display for SimulateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_fault(f, self)
    }
}

impl std::error::Error for SimulateError {}

impl From<SetupError> for SimulateError {
    fn from(e: SetupError) -> Self {
        Self::Setup(Box::new(e))
    }
}

impl From<ProblemFileError> for SimulateError {
    fn from(e: ProblemFileError) -> Self {
        SetupError::from(e).into()
    }
}

impl From<RecordingError> for SimulateError {
    fn from(e: RecordingError) -> Self {
        SetupError::from(e).into()
    }
}
