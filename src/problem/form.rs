//! The form of a problem: names, units, shapes and sets, known before any number is computed.

use crate::problem::error::{ProblemError, ProblemErrorKind};

/// What a problem minimises over what, without numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Form {
    /// Entries of x, in order.
    pub variables: Vec<Variable>,
    /// What is minimised.
    pub objective: Objective,
    /// Rows of g with their sets, in the order in which values have them.
    pub constraints: Vec<Constraint>,
    /// Whether one linearisation describes residual and rows everywhere.
    pub structure: Structure,
}

/// One entry of x.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// The name in messages, traces and reports.
    pub name: String,
    /// SI unit of the value and of the bounds.
    pub unit: String,
    /// Lower bound; minus infinity where there is none.
    pub lower: f64,
    /// Upper bound; infinity where there is none.
    pub upper: f64,
    /// A change of the variable that matters, > 0, in its unit.
    pub scale: f64,
}

/// The kind of objective.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Objective {
    /// A smooth function with a gradient.
    Smooth,
    /// f(x) = 1/2 |r(x)|^2 with this many rows of r before any compression.
    SumOfSquares {
        /// Rows of r.
        rows: usize,
    },
}

/// Some rows of g, and the set in which they must lie.
#[derive(Debug, Clone, PartialEq)]
pub struct Constraint {
    /// The name in messages and reports; rows are numbered behind it.
    pub name: String,
    /// SI unit of the rows.
    pub unit: String,
    /// Rows of g that belong to it.
    pub rows: usize,
    /// Where the rows have to lie.
    pub set: Set,
}

/// The set of a constraint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Set {
    /// g = 0.
    Zero,
    /// g >= 0, row by row.
    Nonnegative,
    /// smat(g) is positive semidefinite; the rows are the svec of a symmetric matrix of this order
    /// (see [`crate::linalg::svec`]).
    Psd {
        /// n of the n x n matrix.
        order: usize,
    },
}

/// How residual (or smooth cost) and constraints depend on x.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Structure {
    /// Residual and rows are affine in x; a smooth cost is linear. One linearisation is the whole problem.
    Affine,
    /// Once continuously differentiable.
    Smooth,
}

impl Variable {
    /// A variable without bounds, of scale one.
    pub fn free(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            unit: unit.into(),
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
            scale: 1.0,
        }
    }

    /// The same variable within lower <= x <= upper.
    pub fn within(mut self, lower: f64, upper: f64) -> Self {
        self.lower = lower;
        self.upper = upper;
        self
    }

    /// The same variable with another scale.
    pub fn scale(mut self, scale: f64) -> Self {
        self.scale = scale;
        self
    }

    fn validate(&self) -> Result<(), ProblemError> {
        let fault = |kind| Err(ProblemError::at(&self.name, kind));
        // A comparison with NaN is false, so NaN bounds fail here as well.
        let ordered = self.lower <= self.upper;
        if !ordered || self.lower == f64::INFINITY || self.upper == f64::NEG_INFINITY {
            return fault(ProblemErrorKind::BoundsCross {
                lower: self.lower,
                upper: self.upper,
            });
        }
        if !(self.scale > 0.0 && self.scale.is_finite()) {
            return fault(ProblemErrorKind::ScaleNotPositive { scale: self.scale });
        }
        Ok(())
    }
}

impl Constraint {
    fn validate(&self) -> Result<(), ProblemError> {
        match self.set {
            Set::Psd { order } if self.rows != order * (order + 1) / 2 => Err(ProblemError::at(
                &self.name,
                ProblemErrorKind::RowsOfCone {
                    rows: self.rows,
                    order,
                },
            )),
            _ => Ok(()),
        }
    }
}

impl Form {
    /// Checks bounds, scales and shapes; the error names the first variable or constraint at fault.
    pub fn validate(&self) -> Result<(), ProblemError> {
        self.variables.iter().try_for_each(Variable::validate)?;
        self.constraints.iter().try_for_each(Constraint::validate)
    }

    /// Rows of all constraints together.
    pub fn constraint_rows(&self) -> usize {
        self.constraints.iter().map(|c| c.rows).sum()
    }

    /// The name of a constraint row, such as `torque[12]`.
    pub fn row_name(&self, row: usize) -> String {
        let mut first = 0;
        for constraint in &self.constraints {
            if row < first + constraint.rows {
                return format!("{}[{}]", constraint.name, row - first);
            }
            first += constraint.rows;
        }
        format!("row {row}")
    }
}
