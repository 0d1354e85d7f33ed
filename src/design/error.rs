//! Why a design cannot be made.

use crate::fault::{Description, Fault, Place, write_fault};
use crate::setup::error::SetupError;
use crate::solve::error::SolveError;
use std::fmt;

/// A fault of what a design is asked for.
#[derive(Debug)]
pub enum DesignError {
    /// The problem, its robot or its recordings.
    Setup(Box<SetupError>),
    /// A solver cannot start.
    Solve(SolveError),
    /// What is asked for cannot be designed.
    Unsuitable {
        /// The key of the problem file.
        place: Place,
        /// Why not.
        kind: Unsuitable,
    },
}

/// What makes a request unsuitable.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Unsuitable {
    /// Every parameter is known.
    NothingToEstimate,
    /// No parameter belongs to what is asked for.
    EmptyGroup,
    /// A parameter that no motion determines by itself.
    NotDetermined {
        /// Its name.
        found: String,
    },
    /// A clearance of a link that has no shape.
    NoShape {
        /// Name of the link.
        link: String,
    },
    /// Rivals are to be told apart, and there are none.
    NoRivals,
    /// Two rivals predict the same for every motion once they are fitted.
    SameRivals,
    /// A file that ought to hold coefficients does not.
    NotCoefficients {
        /// What is wrong with it.
        why: String,
    },
    /// The motion of a file has another period than the design, or more harmonics.
    OtherSeries,
    /// A joint cannot reach two speeds within its range of positions: no plan of constant velocities has room.
    TooFast {
        /// Name of the joint.
        joint: String,
    },
    /// Too few samples for the highest harmonic.
    TooFewSamples {
        /// Samples per period.
        found: usize,
        /// Samples that it needs.
        least: usize,
    },
}

impl DesignError {
    /// At a key of the problem file.
    pub fn unsuitable(place: &Place, kind: Unsuitable) -> Self {
        Self::Unsuitable {
            place: place.clone(),
            kind,
        }
    }

    /// Whether a robot file is at fault, and not the problem file.
    pub fn concerns_data(&self) -> bool {
        matches!(self, Self::Setup(e) if e.concerns_data())
    }
}

impl From<SetupError> for DesignError {
    fn from(e: SetupError) -> Self {
        Self::Setup(Box::new(e))
    }
}

impl From<SolveError> for DesignError {
    fn from(e: SolveError) -> Self {
        Self::Solve(e)
    }
}

fn no_shape(link: &str) -> Description {
    Description::new(
        "no-collision-shape",
        format!("link `{link}` has no collision shape that a clearance can be kept from"),
        "give one under [[design.workspace.shape]], or add a sphere, cylinder, capsule or box as its collision geometry \
         in the URDF",
    )
}

impl Fault for DesignError {
    fn place(&self) -> &Place {
        match self {
            Self::Setup(e) => e.place(),
            Self::Solve(e) => e.place(),
            Self::Unsuitable { place, .. } => place,
        }
    }

    fn describe(&self) -> Description {
        let kind = match self {
            Self::Setup(e) => return e.describe(),
            Self::Solve(e) => return e.describe(),
            Self::Unsuitable { kind, .. } => kind,
        };
        match kind {
            Unsuitable::NothingToEstimate => Description::new(
                "nothing-to-estimate",
                "every parameter of the model is known, so no motion is better than another",
                "set inertials = \"estimate\", give a payload, or list effects under [drive]",
            ),
            Unsuitable::EmptyGroup => Description::new(
                "empty-parameter-group",
                "the model has no unknown parameter in this group",
                "ask for \"all\", or add the load or the effects that the group is about",
            ),
            Unsuitable::NotDetermined { found } => Description::new(
                "parameter-not-determined",
                format!("no motion determines `{found}` by itself"),
                "ask for a base parameter of it: `exid check` and `exid fit` list them",
            ),
            Unsuitable::NoRivals => Description::new(
                "no-rivals",
                "the criterion \"discriminate\" has nothing to tell apart",
                "state the rival models under [[design.rival]]: effects, values, or the result of a fit",
            ),
            Unsuitable::SameRivals => Description::new(
                "same-rivals",
                "two rivals predict the same for every motion once they are fitted",
                "give them effects that differ, and values of these effects that are not zero",
            ),
            Unsuitable::NotCoefficients { why } => Description::new(
                "not-coefficients",
                format!("no coefficients can be read from this file: {why}"),
                "name `coefficients.json` or `result.json` of a design, or a file of the same form",
            ),
            Unsuitable::OtherSeries => Description::new(
                "other-series",
                "the motion of this file has another period or more harmonics than the design",
                "set design.period and design.harmonics to those of the file",
            ),
            Unsuitable::TooFast { joint } => Description::new(
                "no-room-for-strokes",
                format!("joint `{joint}` cannot reach two speeds within its range of positions"),
                "widen its range, raise its acceleration limit, or lock it",
            ),
            Unsuitable::TooFewSamples { found, least } => Description::new(
                "too-few-samples",
                format!("{found} samples of a period do not show its fastest harmonic"),
                format!("give at least {least}, or fewer harmonics"),
            ),
            Unsuitable::NoShape { link } => no_shape(link),
        }
    }
}

impl fmt::Display for DesignError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_fault(f, self)
    }
}

impl std::error::Error for DesignError {}
