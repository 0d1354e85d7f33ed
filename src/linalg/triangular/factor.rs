//! The streaming QR of a tall matrix A (m x p): only R of A = Q R is kept, so memory does not grow with m.
//!
//! A block B of rows updates R by Householder reflections of [R; B], which has the accuracy of a QR of the
//! whole: RᵀR = AᵀA (1 + O(eps)) without ever forming AᵀA. With the right-hand side as a last column, R holds
//! the whole least squares problem. Source: Demmel, Grigori, Hoemmen, Langou (2012), sequential TSQR.

use crate::linalg::lanes::lane::LANES;
use crate::linalg::triangular::kernel;
use crate::linalg::triangular::kernel::{Column, TILE_ROWS, ZERO_COLUMN};
use nalgebra::{DMatrix, DVector};

/// The upper-triangular factor R (p x p) of the rows absorbed so far.
#[derive(Debug, Clone)]
pub struct Triangular {
    pub(super) order: usize,
    /// Row-major: a reflection works along one row.
    pub(super) entries: Vec<f64>,
    pub(super) tile: Vec<Column>,
}

impl Triangular {
    /// R = 0 for matrices of this many columns.
    pub fn new(columns: usize) -> Self {
        Self {
            order: columns,
            entries: vec![0.0; columns * columns],
            tile: vec![ZERO_COLUMN; columns],
        }
    }

    /// R of a whole matrix.
    pub fn of(matrix: &DMatrix<f64>) -> Self {
        let mut triangular = Self::new(matrix.ncols());
        triangular.absorb(matrix.as_slice());
        triangular
    }

    /// R of [A, b]: the least squares problem min |A x - b| in p + 1 columns.
    pub fn of_system(matrix: &DMatrix<f64>, right: &DVector<f64>) -> Self {
        let mut triangular = Self::new(matrix.ncols() + 1);
        let mut columns: Vec<&[f64]> = Vec::with_capacity(matrix.ncols() + 1);
        let rows = matrix.nrows();
        if rows > 0 {
            columns.extend(matrix.as_slice().chunks_exact(rows));
            columns.push(right.as_slice());
            triangular.absorb_columns(&columns);
        }
        triangular
    }

    /// Number of columns p.
    pub fn columns(&self) -> usize {
        self.order
    }

    /// Absorbs the rows of a block, given column by column (m x p, m = block.len() / p).
    ///
    /// Entries are expected between 1e-145 and 1e145 in size, or zero.
    pub fn absorb(&mut self, block: &[f64]) {
        if self.order == 0 || block.len() < self.order {
            return;
        }
        let rows = block.len() / self.order;
        let columns: Vec<&[f64]> = block.chunks_exact(rows).take(self.order).collect();
        self.absorb_columns(&columns);
    }

    /// Absorbs rows given as p columns of equal length.
    pub fn absorb_columns(&mut self, columns: &[&[f64]]) {
        let rows = columns.iter().map(|c| c.len()).min().unwrap_or(0);
        for first in (0..rows).step_by(TILE_ROWS) {
            let last = rows.min(first + TILE_ROWS);
            for (to, from) in self.tile.iter_mut().zip(columns) {
                fill(to, &from[first..last]);
            }
            kernel::absorb_tile(&mut self.entries, &mut self.tile);
        }
    }

    /// Absorbs the rows of another R. A fixed order of merges gives the same bits for any number of threads.
    pub fn merge(&mut self, other: &Self) {
        self.absorb(other.matrix().as_slice());
    }

    /// The factor of weight · A.
    pub fn scaled(mut self, weight: f64) -> Self {
        for entry in &mut self.entries {
            *entry *= weight;
        }
        self
    }

    /// R_ij; zero below the diagonal.
    pub fn entry(&self, i: usize, j: usize) -> f64 {
        if i > j {
            0.0
        } else {
            self.entries[i * self.order + j]
        }
    }

    /// R as a matrix, p x p, with a diagonal that is not negative.
    pub fn matrix(&self) -> DMatrix<f64> {
        DMatrix::from_fn(self.order, self.order, |i, j| {
            let sign = if self.entry(i, i) < 0.0 { -1.0 } else { 1.0 };
            if i > j { 0.0 } else { sign * self.entry(i, j) }
        })
    }

    /// Norms of the columns of A.
    pub fn column_norms(&self) -> DVector<f64> {
        DVector::from_iterator(
            self.order,
            self.matrix().column_iter().map(|column| column.norm()),
        )
    }

    /// The factor of some columns of A, in the given order.
    pub fn select(&self, columns: &[usize]) -> Self {
        let matrix = self.matrix();
        Self::of(&matrix.select_columns(columns))
    }
}

/// Copies up to a tile of rows, and zeros below them.
pub(super) fn fill(to: &mut Column, from: &[f64]) {
    let (octets, tail) = from.as_chunks::<LANES>();
    for (place, octet) in to.iter_mut().zip(octets) {
        place.0 = *octet;
    }
    for (i, place) in to.iter_mut().enumerate().skip(octets.len()) {
        place.0 = [0.0; LANES];
        if i == octets.len() {
            place.0[..tail.len()].copy_from_slice(tail);
        }
    }
}
