//! lapack
