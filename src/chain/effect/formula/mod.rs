//! Formulas in text: parsed, differentiated exactly, checked for dimensions, and compiled once for many
//! samples.
//!
//! A formula becomes an [`Expression`](crate::chain::effect::expression::Expression), the form that exported code is printed
//! from, so that a law of one's own has one meaning everywhere. Derivatives are those of the formula, not differences.

pub mod derivative;
pub mod dimension;
pub mod fault;
pub mod syntax;
pub mod tape;
pub mod words;

mod simplify;

#[cfg(test)]
mod tests;
