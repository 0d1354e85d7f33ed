//! The context of a design: its problem file, the inputs that it names, and the experiment that is optimised.

use crate::design::inputs::prepared::Prepared;
use crate::design::problem::Experiment;
use crate::problem_file::ProblemFile;

/// What all steps of a design refer to.
#[derive(Debug, Clone, Copy)]
pub struct DesignContext<'a> {
    /// What is asked for.
    pub problem: &'a ProblemFile,
    /// Model, values and limits.
    pub prepared: &'a Prepared,
    /// Criterion and constraints over the coefficients.
    pub experiment: &'a Experiment<'a>,
}
