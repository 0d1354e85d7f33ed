//! svec(S): a symmetric matrix as a vector with ⟨S, T⟩ = svec(S)ᵀ svec(T).
//!
//! The upper triangle column by column, off-diagonal entries times sqrt 2: (1, 1), (1, 2), (2, 2), (1, 3), ...
//! This is the order of the semidefinite cone in Clarabel.

use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

use nalgebra::{DMatrix, DVector};

/// Rows of the svec of a symmetric matrix of this order: n (n + 1) / 2.
pub fn rows(order: usize) -> usize {
    order * (order + 1) / 2
}

/// Row of the svec in which entry (i, j) stands.
pub fn row(i: usize, j: usize) -> usize {
    let (i, j) = (i.min(j), i.max(j));
    rows(j) + i
}

/// svec of an n x n matrix; only its upper triangle is read.
pub fn svec(matrix: &DMatrix<f64>) -> DVector<f64> {
    let order = matrix.ncols().min(matrix.nrows());
    let entries = (0..order).flat_map(|j| (0..=j).map(move |i| (i, j)));
    DVector::from_iterator(
        rows(order),
        entries.map(|(i, j)| matrix[(i, j)] * if i == j { 1.0 } else { SQRT_2 }),
    )
}

/// The symmetric n x n matrix of an svec; rows beyond the last whole column are not read.
pub fn smat(vector: &[f64]) -> DMatrix<f64> {
    let order = (1..).take_while(|n| rows(*n) <= vector.len()).count();
    DMatrix::from_fn(order, order, |i, j| {
        vector[row(i, j)] * if i == j { 1.0 } else { FRAC_1_SQRT_2 }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    /// Entries without symmetry between them, so that a wrong order shows.
    fn symmetric(order: usize, shift: f64) -> DMatrix<f64> {
        DMatrix::from_fn(order, order, |i, j| {
            let (i, j) = (i.min(j) as f64, i.max(j) as f64);
            (1.0 + i + 3.0 * j + shift * (i - j)).sin()
        })
    }

    #[test]
    fn matches_the_order_of_the_definition() {
        let s = svec(&dmatrix![1.0, 2.0, 4.0; 2.0, 3.0, 5.0; 4.0, 5.0, 6.0]);
        let w = SQRT_2;
        assert_eq!(s.as_slice(), [1.0, 2.0 * w, 3.0, 4.0 * w, 5.0 * w, 6.0]);
    }

    #[test]
    fn invariant_round_trip_and_inner_product() {
        for order in 0..9 {
            let (a, b) = (symmetric(order, 0.1), symmetric(order, 0.7));
            let back = smat(svec(&a).as_slice());
            assert!((&back - &a).amax() <= 2.0 * f64::EPSILON);
            let inner = svec(&a).dot(&svec(&b));
            let bound = 16.0 * f64::EPSILON * (1 + order * order) as f64;
            assert!((inner - a.component_mul(&b).sum()).abs() <= bound);
        }
    }
}
