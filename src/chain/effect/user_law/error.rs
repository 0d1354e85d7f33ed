//! Errors in the text of a user-defined law, and the part that has them.

use crate::chain::effect::formula::fault::FormulaError;
use crate::chain::effect::user_law::MOST_PARAMETERS;

/// A part of a law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Its identifier.
    Id,
    /// The formula of its torque or factor.
    Torque,
    /// The rate of a state, and its first value.
    Rate(usize),
    /// The first value of a state by its place.
    Start(usize),
    /// A parameter by its place.
    Parameter(usize),
}

/// A fault of a law.
#[derive(Debug, Clone, PartialEq)]
pub struct LawError {
    /// Where in the law.
    pub part: Part,
    /// What is wrong there.
    pub fault: LawFault,
}

/// What is wrong.
#[derive(Debug, Clone, PartialEq)]
pub enum LawFault {
    /// A formula cannot be read.
    Formula {
        /// The formula as written.
        text: String,
        /// What is wrong with it, and where.
        error: FormulaError,
    },
    /// Neither an identifier.
    BadName {
        /// As written.
        found: String,
    },
    /// A parameter bears the name of a variable.
    Reserved {
        /// The name.
        found: String,
    },
    /// The formula has a variable that is not known there.
    NotKnownHere {
        /// The variable as formulas write it.
        variable: &'static str,
        /// What to do instead.
        remedy: &'static str,
    },
    /// A unit that is no product of known ones.
    UnknownUnit {
        /// As written.
        found: String,
    },
    /// Terms of different dimensions are added or compared, or the formula does not give what the law needs.
    Dimensions {
        /// The formula as written.
        text: String,
        /// Which dimensions, in words.
        what: String,
    },
    /// The typical value of a parameter does not lie between its limits, or a limit is not a number.
    Bounds {
        /// Name of the parameter.
        name: String,
        /// Its lower limit, in its unit.
        lower: f64,
        /// Its typical value.
        typical: f64,
        /// Its upper limit.
        upper: f64,
    },
    /// A parameter stands in no formula.
    Unused {
        /// Name of the parameter.
        name: String,
    },
    /// There is nothing to estimate.
    NoParameters,
    /// More parameters than evaluations have room for.
    TooManyParameters {
        /// How many there are; [`MOST_PARAMETERS`] are allowed.
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

    /// What is wrong, with the text found.
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

    /// What to do about it.
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
