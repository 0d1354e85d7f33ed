//! The trait of an optimality criterion, and its value with its gradient.

use nalgebra::DMatrix;

/// The logarithm that is minimised, and its gradient.
#[derive(Debug, Clone, PartialEq)]
pub struct Graded {
    /// Natural logarithm of the criterion, or of the mean that stands for it.
    pub value: f64,
    /// `∂value/∂matrix`, symmetric.
    pub gradient: DMatrix<f64>,
}

/// A criterion of a symmetric positive definite matrix.
pub trait Criterion: Sync + std::fmt::Debug {
    /// The word of problem files.
    fn id(&self) -> &'static str;

    /// What the reported value is.
    fn meaning(&self) -> &'static str;

    /// The reported value; infinite where the matrix is singular.
    fn value(&self, information: &DMatrix<f64>) -> f64;

    /// What is minimised, with exponent ρ for extremes; `None` where the matrix is singular.
    fn minimised(&self, information: &DMatrix<f64>, exponent: f64) -> Option<f64>;

    /// The same with its gradient.
    fn graded(&self, information: &DMatrix<f64>, exponent: f64) -> Option<Graded>;

    /// Exponents with which the search works through; one where the criterion has no extremes.
    fn exponents(&self) -> &'static [f64] {
        &[1.0]
    }
}
