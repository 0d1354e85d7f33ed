//! The context of a design: what is asked for, its inputs, and the experiment that is optimised.

use crate::design::inputs::prepared::Prepared;
use crate::design::inputs::request::DesignRequest;
use crate::design::problem::Experiment;

/// What all steps of a design refer to.
#[derive(Debug, Clone, Copy)]
pub struct DesignContext<'a> {
    /// What is asked for.
    pub request: &'a DesignRequest<'a>,
    /// Model, values and limits.
    pub prepared: &'a Prepared,
    /// Criterion and constraints over the coefficients.
    pub experiment: &'a Experiment<'a>,
}
