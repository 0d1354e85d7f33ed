//! Why a text is no law, and in which part of it.

use crate::chain::effect::formula::fault::FormulaError;
use crate::chain::effect::own::MOST_PARAMETERS;

/// A part of a law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    Id,
    Torque,
    /// The rate of a state, and its first value.
    Rate(usize),
    Start(usize),
    /// A parameter by its place.
    Parameter(usize),
}

/// A fault of a law.
#[derive(Debug, Clone, PartialEq)]
pub struct LawError {
    pub part: Part,
    pub fault: LawFault,
}

/// What is wrong.
#[derive(Debug, Clone, PartialEq)]
pub enum LawFault {
    Formula {
        text: String,
        error: FormulaError,
    },
    /// Neither an identifier.
    BadName {
        found: String,
    },
    Reserved {
        found: String,
    },
    /// The formula has a variable that is not known there.
    NotKnownHere {
        variable: &'static str,
        remedy: &'static str,
    },
    UnknownUnit {
        found: String,
    },
    Dimensions {
        text: String,
        what: String,
    },
    Bounds {
        name: String,
        lower: f64,
        typical: f64,
        upper: f64,
    },
    Unused {
        name: String,
    },
    NoParameters,
    TooManyParameters {
        found: usize,
    },
    /// A state that does not stand in the torque.
    UnusedState,
}

impl LawError {
    /// Stable identifier of the kind of fault.
    pub fn code(&self) -> &'static str {
        match &self.fault {
            LawFault::Formula { .. } => "formula",
            LawFault::BadName { .. } | LawFault::Reserved { .. } => "law-name",
            LawFault::NotKnownHere { .. } => "law-variable",
            LawFault::UnknownUnit { .. } | LawFault::Dimensions { .. } => "law-unit",
            LawFault::Bounds { .. } => "law-bounds",
            LawFault::Unused { .. }
            | LawFault::NoParameters
            | LawFault::TooManyParameters { .. }
            | LawFault::UnusedState => "law-parameters",
        }
    }

    pub fn message(&self) -> String {
        match &self.fault {
            LawFault::Formula { text, error } => format!(
                "character {} of \"{}\": {}",
                error.at.start + 1,
                marked(text, error.at.start),
                error.fault.message()
            ),
            LawFault::BadName { found } => format!("\"{found}\" is no name for formulas and files"),
            LawFault::Reserved { found } => format!("\"{found}\" is a variable of every formula"),
            LawFault::NotKnownHere { variable, .. } => format!("{variable} is not known here"),
            LawFault::UnknownUnit { found } => format!("the unit \"{found}\" is not known"),
            LawFault::Dimensions { text, what } => format!("\"{text}\" is {what}"),
            LawFault::Bounds {
                name,
                lower,
                typical,
                upper,
            } => format!("{name} is typically {typical}, and its bounds are {lower} and {upper}"),
            LawFault::Unused { name } => format!("no formula of the law has \"{name}\" in it"),
            LawFault::NoParameters => "the law has no parameters".into(),
            LawFault::TooManyParameters { found } => format!("the law has {found} parameters"),
            LawFault::UnusedState => "the torque does not depend on this state".into(),
        }
    }

    pub fn remedy(&self) -> String {
        match &self.fault {
            LawFault::Formula { error, .. } => error.fault.remedy(),
            LawFault::BadName { .. } => {
                "use letters, digits and \"_\", and begin with a letter".into()
            }
            LawFault::Reserved { .. } => "give the parameter another name".into(),
            LawFault::NotKnownHere { remedy, .. } => (*remedy).into(),
            LawFault::UnknownUnit { .. } => {
                "write products of m, kg, s, rad, N, J, W, V, A, K, °C and Hz such as \"N·m·s/rad\", \"1\" for a pure number, or no unit at all"
                    .into()
            }
            LawFault::Dimensions { .. } => {
                "correct the formula or the units; a parameter without a unit goes with everything"
                    .into()
            }
            LawFault::Bounds { .. } => "put the typical value between its bounds".into(),
            LawFault::Unused { .. } => "use it in the formula, or leave it out".into(),
            LawFault::NoParameters => {
                "give it at least one, such as parameters.a = { typical = 0.1 }".into()
            }
            LawFault::TooManyParameters { .. } => {
                format!("write it with at most {MOST_PARAMETERS}, or as two laws")
            }
            LawFault::UnusedState => "use z in torque, or leave the state out".into(),
        }
    }
}

/// A formula with a sign where its fault is.
fn marked(text: &str, at: usize) -> String {
    let (before, behind): (String, String) = (
        text.chars().take(at).collect(),
        text.chars().skip(at).collect(),
    );
    format!("{before}»{behind}")
}
