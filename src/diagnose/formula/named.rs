//! Terms of formulas with named parameters.

use crate::diagnose::formula::term::Term;

/// A term with its parameters.
#[derive(Debug, Clone)]
pub struct NamedTerm {
    pub term: Term,
    /// It is subtracted.
    pub is_negative: bool,
    pub size: Named,
    /// Of each factor, its own one.
    pub inner: Vec<Option<Named>>,
    /// Of each factor, the place about which it is one.
    pub centre: Vec<Option<Named>>,
    /// Phase of a wave, or what slopes of two sides have to each other.
    pub second: Option<Named>,
}

/// A parameter.
#[derive(Debug, Clone)]
pub struct Named {
    pub name: String,
    pub value: f64,
    pub unit: String,
    pub meaning: &'static str,
    pub bounds: [f64; 2],
    pub is_shape: bool,
}

impl NamedTerm {
    pub fn parameters(&self) -> impl Iterator<Item = &Named> {
        let own = self.inner.iter().chain(&self.centre).flatten();
        std::iter::once(&self.size).chain(own).chain(&self.second)
    }
}
