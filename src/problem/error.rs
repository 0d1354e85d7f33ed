//! What can be wrong with a problem before a solver starts: its form, or a view that it cannot give.

use std::fmt;

use crate::fault::{Description, Fault, Place, write_fault};

/// The `file` of a fault that lies in a problem built in memory.
const PROBLEM: &str = "problem";

/// A fault of a problem's form, or of what is asked of the problem.
#[derive(Debug, Clone, PartialEq)]
pub struct ProblemError {
    /// The variable or constraint at fault, under the name of the problem.
    pub place: Place,
    /// What is wrong with it.
    pub kind: ProblemErrorKind,
}

/// The kinds of [`ProblemError`].
#[derive(Debug, Clone, PartialEq)]
pub enum ProblemErrorKind {
    /// lower <= upper does not hold, or a bound is NaN.
    BoundsCross {
        /// The lower bound, in the variable's unit.
        lower: f64,
        /// The upper bound, in the variable's unit.
        upper: f64,
    },
    /// The scale of a variable is not a positive number.
    ScaleNotPositive {
        /// What was given in its place.
        scale: f64,
    },
    /// A semidefinite constraint whose rows are not the svec of a matrix of its order.
    RowsOfCone {
        /// Rows of the constraint.
        rows: usize,
        /// Order n of the matrix, whose svec has n(n + 1)/2 rows.
        order: usize,
    },
    /// The view needs a sum of squares.
    NotSumOfSquares {
        /// The name of the view.
        view: &'static str,
    },
    /// The view takes no constraints besides bounds.
    Constrained {
        /// The name of the view.
        view: &'static str,
        /// Constraints of the problem.
        constraints: usize,
    },
    /// The view takes no semidefinite constraints.
    HasCone {
        /// The name of the view.
        view: &'static str,
    },
    /// The view needs residual and rows that are affine in the variables.
    NotAffine {
        /// The name of the view.
        view: &'static str,
    },
    /// A variable that does not exist.
    NoSuchVariable {
        /// The index that was asked for.
        index: usize,
        /// Entries of x.
        variables: usize,
    },
    /// A value that is not a number, or outside the bounds, for a frozen variable.
    FrozenOutsideBounds {
        /// The value at which the variable was to be frozen, in its unit.
        value: f64,
        /// Its lower bound.
        lower: f64,
        /// Its upper bound.
        upper: f64,
    },
}

impl ProblemError {
    /// A fault of the problem as a whole.
    pub fn whole(kind: ProblemErrorKind) -> Self {
        Self {
            place: Place::file(PROBLEM),
            kind,
        }
    }

    /// A fault at a named variable or constraint.
    pub fn at(name: &str, kind: ProblemErrorKind) -> Self {
        Self {
            place: Place::file(PROBLEM).key(name),
            kind,
        }
    }
}

impl Fault for ProblemError {
    fn place(&self) -> &Place {
        &self.place
    }

    fn describe(&self) -> Description {
        use ProblemErrorKind as K;
        match &self.kind {
            K::BoundsCross { lower, upper } => Description::new(
                "bounds-cross",
                format!("no value lies within {lower} <= x <= {upper}"),
                "give a lower bound that is not above the upper bound",
            ),
            K::ScaleNotPositive { scale } => Description::new(
                "scale-not-positive",
                format!("the scale is {scale}"),
                "give the size of a change that matters, a positive number",
            ),
            K::RowsOfCone { rows, order } => Description::new(
                "rows-of-cone",
                format!("{rows} rows for a symmetric matrix of order {order}"),
                format!(
                    "give the svec of the matrix: {} rows",
                    order * (order + 1) / 2
                ),
            ),
            K::NotSumOfSquares { view } => Description::new(
                "not-sum-of-squares",
                format!("{view} needs a sum of squares, the objective is a smooth function"),
                "state the objective as a residual, or use a method for smooth functions",
            ),
            K::Constrained { view, constraints } => Description::new(
                "constrained",
                format!("{view} takes bounds only, the problem has {constraints} constraints"),
                "use a method for constraints, or express them through the variables",
            ),
            K::HasCone { view } => Description::new(
                "has-cone",
                format!("{view} takes no semidefinite constraint"),
                "use the interior-point method, or variables whose every value is feasible",
            ),
            K::NotAffine { view } => Description::new(
                "not-affine",
                format!("{view} needs residual and constraints that are affine in the variables"),
                "fix the variables that enter nonlinearly, or use a nonlinear method",
            ),
            K::NoSuchVariable { index, variables } => Description::new(
                "no-such-variable",
                format!("variable {index} of {variables}, counted from 0"),
                "name a variable of the problem",
            ),
            K::FrozenOutsideBounds {
                value,
                lower,
                upper,
            } => Description::new(
                "frozen-outside-bounds",
                format!("fixed at {value}, outside {lower} <= x <= {upper}"),
                "fix it at a value within its bounds, or widen them",
            ),
        }
    }
}

impl fmt::Display for ProblemError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_fault(f, self)
    }
}

impl std::error::Error for ProblemError {}
