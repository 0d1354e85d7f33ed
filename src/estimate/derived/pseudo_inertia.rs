//! Pseudo-inertias `D J D`, D = diag(1/ℓ, 1/ℓ, 1/ℓ, 1), in which masses and second moments have one size, and their rows in a cone.

use crate::linalg::svec::svec;
use crate::robot::inertia::Inertia;
use nalgebra::{DMatrix, DVector, Matrix4};

/// ℓ, m: a typical radius of gyration of robot links.
pub const LENGTH: f64 = 0.1;

/// Rows of the svec of a pseudo-inertia.
pub const ROWS: usize = 10;

/// Of a body, kg.
pub fn scaled_pseudo_inertia(body: &Inertia) -> Matrix4<f64> {
    let inverse = 1.0 / LENGTH;
    let scale = Matrix4::from_diagonal(&[inverse, inverse, inverse, 1.0].into());
    scale * body.pseudo_inertia() * scale
}

/// Of the body whose parameters start at `first`.
pub fn scaled_body(values: &DVector<f64>, first: usize) -> Matrix4<f64> {
    scaled_pseudo_inertia(&Inertia(std::array::from_fn(|k| values[first + k])))
}

/// Its svec.
pub fn scaled_rows(values: &DVector<f64>, first: usize) -> Vec<f64> {
    svec4(&scaled_body(values, first))
}

/// svec of a 4 x 4 matrix.
pub fn svec4(matrix: &Matrix4<f64>) -> Vec<f64> {
    let dynamic = DMatrix::from_column_slice(4, 4, matrix.as_slice());
    svec(&dynamic).iter().copied().collect()
}
