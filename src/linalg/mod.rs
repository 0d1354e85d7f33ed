//! Dense linear algebra that the crates do not offer in this shape.

pub mod jacobi_rotation;
pub mod lanes;
pub mod normal_equations;
pub mod svec;
pub mod triangular;
