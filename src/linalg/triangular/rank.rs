//! Which columns of A are independent of those before them, and how the others follow from these.
//!
//! The scan keeps the leftmost columns, so the basis is the same for every recording that excites the same
//! directions; a pivoted QR would choose by size and differ from run to run.

use nalgebra::DMatrix;

use crate::linalg::triangular::Triangular;

/// A = A_kept [I, coefficients] up to the tolerance of the scan, columns ordered as (kept, dependent).
#[derive(Debug, Clone, PartialEq)]
pub struct IndependentColumns {
    /// Indices of the columns kept, ascending.
    pub kept: Vec<usize>,
    /// Indices of the other columns, ascending.
    pub dependent: Vec<usize>,
    /// A_dependent = A_kept coefficients, kept x dependent.
    pub coefficients: DMatrix<f64>,
}

impl Triangular {
    /// Scans from left to right and keeps each column whose part orthogonal to the columns kept before
    /// exceeds tolerance · |column|.
    pub fn independent_columns(&self, tolerance: f64) -> IndependentColumns {
        let mut work = self.matrix();
        let norms = self.column_norms();
        let (mut kept, mut dependent) = (Vec::new(), Vec::new());
        for k in 0..self.columns() {
            let rank = kept.len();
            // Row rank and below: what the columns kept so far do not explain.
            let rest = work.view((rank, k), (k + 1 - rank, 1)).norm();
            if rest > tolerance * norms[k] {
                eliminate(&mut work, rank, k);
                kept.push(k);
            } else {
                dependent.push(k);
            }
        }
        let rank = kept.len();
        let rows = work.rows(0, rank);
        let right = rows.select_columns(&dependent);
        // Every kept diagonal entry exceeds a positive number, so the solution exists.
        let coefficients = rows
            .select_columns(&kept)
            .solve_upper_triangular(&right)
            .unwrap_or(right);
        IndependentColumns {
            kept,
            dependent,
            coefficients,
        }
    }
}

/// Reflects rows `row..=column` so that the column ends at `row`; columns to its right follow.
fn eliminate(work: &mut DMatrix<f64>, row: usize, column: usize) {
    let rows = column + 1 - row;
    let mut v = work.column(column).rows(row, rows).clone_owned();
    let beta = -v.norm().copysign(v[0]);
    v[0] -= beta;
    let gamma = -1.0 / (beta * v[0]);
    // A row past the diagonal of a later column is zero there, so rows up to `column` are enough.
    for j in column..work.ncols() {
        let mut whole = work.column_mut(j);
        let mut target = whole.rows_mut(row, rows);
        let factor = -gamma * v.dot(&target);
        target.axpy(factor, &v, 1.0);
    }
}
