//! The streaming QR of a tall matrix: its factor, equations with it, and which columns are independent.

mod factor;
mod kernel;
mod rank;
mod solve;

pub use crate::linalg::triangular::factor::Triangular;
pub use rank::IndependentColumns;
pub use solve::{ColumnScaling, System};

#[cfg(test)]
mod tests;
