//! Errors in formulas: what, where, and the remedy.

use super::words::names_of_functions;
use std::fmt;
use std::ops::Range;

/// Brackets within brackets that a formula may have: more than anybody writes, and far from what a stack holds.
pub(super) const DEEPEST: usize = 64;

/// Why a text is no formula, and where: characters from its start.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FormulaError {
    /// Where in the text, in characters.
    pub at: Range<usize>,
    /// What is wrong there.
    pub fault: FormulaFault,
}

/// What is wrong with a formula.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FormulaFault {
    /// There is no formula.
    Empty,
    /// Something else ought to stand here.
    Expected {
        /// What stands there.
        found: String,
        /// What may stand there, in words.
        expected: &'static str,
    },
    /// A bracket is opened and not closed.
    Unclosed,
    /// A text that begins like a number and is none.
    NotANumber {
        /// As written.
        found: String,
    },
    /// A name that is no parameter and no variable.
    UnknownName {
        /// As written.
        found: String,
        /// The known name most like it.
        nearest: Option<String>,
    },
    /// A name before a bracket that is no function.
    UnknownFunction {
        /// As written.
        found: String,
        /// The known function most like it.
        nearest: Option<String>,
    },
    /// A function with too many or too few arguments.
    Arguments {
        /// Name of the function.
        function: String,
        /// How many it was given.
        found: usize,
        /// How many it takes.
        expected: usize,
    },
    /// Only q and v of another joint can be asked for.
    OtherJoint {
        /// The name before the bracket.
        found: String,
    },
    /// Brackets and powers are nested more deeply than formulas of physics are.
    TooDeep,
}

impl FormulaFault {
    /// What is wrong, without the place.
    pub fn message(&self) -> String {
        match self {
            Self::Empty => "there is no formula".into(),
            Self::Expected { found, expected } => format!("found {found} where {expected} is due"),
            Self::Unclosed => "this bracket is not closed".into(),
            Self::NotANumber { found } => format!("\"{found}\" is not a number"),
            Self::UnknownName { found, .. } => {
                format!("\"{found}\" is neither a parameter of the law nor a variable")
            }
            Self::UnknownFunction { found, .. } => format!("there is no function \"{found}\""),
            Self::Arguments {
                function,
                found,
                expected,
            } => format!("{function} has {found} arguments, and needs {expected}"),
            Self::OtherJoint { found } => {
                format!("\"{found}\" of another joint is not known to a law")
            }
            Self::TooDeep => format!("brackets are nested more than {DEEPEST} deep"),
        }
    }

    /// What to do about it.
    pub fn remedy(&self) -> String {
        match self {
            Self::Empty => "state it, such as \"a*sin(n*q + phi)\"".into(),
            Self::Expected { .. } => {
                "write a product with *, a power with ^, and arguments between brackets with commas"
                    .into()
            }
            Self::Unclosed => "add the bracket that closes it".into(),
            Self::NotANumber { .. } => "write numbers as 0.5 or 1e-3".into(),
            Self::UnknownName { found, nearest } => {
                let state = format!(
                    "add parameters.{found} = {{ ... }} to the law, or use one of q, v, acc, tau, i, t, T, period, z, pi"
                );
                with_nearest(nearest.as_ref(), state)
            }
            Self::UnknownFunction { nearest, .. } => with_nearest(
                nearest.as_ref(),
                format!("the functions are {}", names_of_functions()),
            ),
            Self::Arguments { .. } => "separate arguments by commas".into(),
            Self::OtherJoint { .. } => "use q[joint] or v[joint]".into(),
            Self::TooDeep => "write the formula with fewer of them".into(),
        }
    }
}

fn with_nearest(nearest: Option<&String>, other: String) -> String {
    match nearest {
        Some(name) => format!("did you mean \"{name}\"? Otherwise {other}"),
        None => other,
    }
}

impl fmt::Display for FormulaError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "character {}: {}; {}",
            self.at.start + 1,
            self.fault.message(),
            self.fault.remedy()
        )
    }
}

impl std::error::Error for FormulaError {}
