//! The BLAS and LAPACK symbols that Clarabel's semidefinite cone calls, in Rust, so that no system library
//! is needed: {s, d} x potrf potrs gesdd gesvd syevr gesv gemm gemv symv syrk syr2k.
//!
//! The matrices are the blocks of the cone (order 4 for a rigid body), so clarity counts more than speed.
//! `dense` holds the arithmetic, generic over the precision, `symbols` the Fortran interface.

mod dense;
mod foreign;
mod symbols;

pub use symbols::keep;

#[cfg(test)]
mod tests;
