//! Pseudo-inertias `D J D`, D = diag(1/ℓ, 1/ℓ, 1/ℓ, 1), in which masses and second moments have one size, and their rows in a cone.

use crate::linalg::svec::svec;
use crate::problem::affine::{AffineProblem, AffineRows};
use crate::problem::form::{Constraint, Variable};
use crate::robot::inertia::Inertia;
use nalgebra::{DMatrix, DVector, Matrix4};

/// ℓ, m: a typical radius of gyration of robot links.
pub const LENGTH: f64 = 0.1;

/// Rows of the svec of a pseudo-inertia.
pub const ROWS: usize = 10;

/// Margin beyond which a body is as good as any, kg.
pub const LARGEST_MARGIN: f64 = 0.05;

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

/// svec of one identity for every body.
pub fn identities(bodies: usize) -> DVector<f64> {
    let identity = svec4(&Matrix4::identity());
    let all = identity.iter().cycle().take(ROWS * bodies).copied();
    DVector::from_iterator(ROWS * bodies, all)
}

/// The problem of the largest margin t of bodies, a variable behind the others z, not much further from a reference than need be:
///
/// ```text
/// minimise ½ (t − LARGEST_MARGIN)² + ½ ‖nearby · away(z)‖²   subject to   cones(z) − t·1 ⪰ 0
/// ```
///
/// with the rows of the bodies before those of other constraints.
pub fn largest_margin(
    constraints: Vec<Constraint>,
    cones: &AffineRows,
    away: &AffineRows,
    nearby: f64,
) -> AffineProblem {
    let (rows, count) = away.matrix.shape();
    let mut slopes = cones.matrix.clone().resize_horizontally(count + 1, 0.0);
    let mut of_margin = slopes.view_mut((0, count), (rows, 1));
    of_margin.copy_from(&-identities(rows / ROWS));
    let mut matrix = (&away.matrix * nearby).resize(rows + 1, count + 1, 0.0);
    matrix[(rows, count)] = 1.0;
    let mut offset = (&away.offset * nearby).resize_vertically(rows + 1, 0.0);
    offset[rows] = -LARGEST_MARGIN;
    let cones = AffineRows {
        matrix: slopes,
        offset: cones.offset.clone(),
    };
    let squares = AffineRows { matrix, offset };
    AffineProblem::new(free(count + 1), constraints, squares, cones)
}

/// Directions in a class of bodies.
pub fn free(count: usize) -> Vec<Variable> {
    let directions = (0..count).map(|_| Variable::free("direction", ""));
    directions.collect()
}
