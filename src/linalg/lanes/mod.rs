//! Arithmetic on eight numbers at once: a kernel is written once, for any lanes, and compiled for each instruction set.

pub mod inner_product;
pub mod instructions;
// Visible to the library alone: the lanes of an instruction set are sound only where it was detected.
pub(crate) mod lane;
mod registers;
pub mod scalar;
mod sine;

#[cfg(test)]
mod tests;
