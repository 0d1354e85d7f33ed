//! Symmetric matrices of order one to four, held in the upper left corner of a 4 x 4 matrix of which the
//! rest is zero: svec, Cholesky factor, singular values by one-sided Jacobi rotations (Hestenes 1958).

use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

use crate::linalg::jacobi_rotation::JacobiRotation;
use nalgebra::Matrix4;

/// Largest order.
pub(super) const LARGEST: usize = 4;

/// Rows of the svec of order four.
pub(super) const ROWS: usize = 10;

pub(super) type Small = Matrix4<f64>;

/// Sweeps of rotations; quadratic convergence needs four to six.
const SWEEPS: usize = 30;

/// The matrix of an svec (see [`crate::linalg::svec`]).
pub(super) fn smat(rows: &[f64], order: usize) -> Small {
    let mut matrix = Small::zeros();
    let mut row = 0;
    for j in 0..order {
        for i in 0..=j {
            let factor = if i == j { 1.0 } else { FRAC_1_SQRT_2 };
            matrix[(i, j)] = factor * rows[row];
            matrix[(j, i)] = factor * rows[row];
            row += 1;
        }
    }
    matrix
}

/// svec; rows beyond those of the order are zero.
pub(super) fn svec(matrix: &Small, order: usize) -> [f64; ROWS] {
    let mut rows = [0.0; ROWS];
    let mut row = 0;
    for j in 0..order {
        for i in 0..=j {
            rows[row] = matrix[(i, j)] * if i == j { 1.0 } else { SQRT_2 };
            row += 1;
        }
    }
    rows
}

/// Identity in the corner.
pub(super) fn identity(order: usize) -> Small {
    Small::from_fn(|i, j| if i == j && i < order { 1.0 } else { 0.0 })
}

/// Lower L with `matrix = L Lᵀ`; `None` where the matrix is not positive definite.
pub(super) fn cholesky(matrix: &Small, order: usize) -> Option<Small> {
    let mut l = Small::zeros();
    for j in 0..order {
        let mut pivot = matrix[(j, j)];
        for k in 0..j {
            pivot -= l[(j, k)] * l[(j, k)];
        }
        if !(pivot > 0.0 && pivot.is_finite()) {
            return None;
        }
        l[(j, j)] = pivot.sqrt();
        for i in j + 1..order {
            let mut entry = matrix[(i, j)];
            for k in 0..j {
                entry -= l[(i, k)] * l[(j, k)];
            }
            l[(i, j)] = entry / l[(j, j)];
        }
    }
    Some(l)
}

/// U, σ, V of a nonsingular `matrix = U diag(σ) Vᵀ`, σ in no order.
pub(super) fn singular(matrix: &Small, order: usize) -> (Small, [f64; LARGEST], Small) {
    let (mut u, mut v) = (*matrix, identity(order));
    for _ in 0..SWEEPS {
        let mut rotated = false;
        for p in 0..order {
            for q in p + 1..order {
                let (a, b) = (u.column(p).norm_squared(), u.column(q).norm_squared());
                let c = u.column(p).dot(&u.column(q));
                if c.abs() <= f64::EPSILON * (a * b).sqrt() {
                    continue;
                }
                rotated = true;
                let zeta = (b - a) / (2.0 * c);
                let t = zeta.signum() / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
                let cosine = 1.0 / (1.0 + t * t).sqrt();
                let rotation = JacobiRotation {
                    columns: [p, q],
                    cosine,
                    sine: cosine * t,
                };
                rotation.apply(&mut u);
                rotation.apply(&mut v);
            }
        }
        if !rotated {
            break;
        }
    }
    let mut values = [0.0; LARGEST];
    for k in 0..order {
        values[k] = u.column(k).norm();
        u.column_mut(k).scale_mut(1.0 / values[k]);
    }
    (u, values, v)
}

/// Smallest eigenvalue, or zero where all are positive and the order is below four.
pub(super) fn least_eigenvalue(matrix: &Small, order: usize) -> f64 {
    if order == 1 {
        return matrix[(0, 0)];
    }
    matrix.symmetric_eigenvalues().min()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn definite(order: usize) -> Small {
        let root = Small::from_fn(|i, j| {
            let corner = i < order && j < order;
            f64::from(u8::from(corner)) * (1.0 + 3.0 * i as f64 + 7.0 * j as f64).sin()
        });
        root * root.transpose() + identity(order) * 1e-3
    }

    #[test]
    fn invariant_factors_multiply_to_the_matrix() {
        for order in 1..=LARGEST {
            let matrix = definite(order);
            let l = cholesky(&matrix, order).unwrap();
            assert!((l * l.transpose() - matrix).amax() <= 1e-14);
            let (u, sigma, v) = singular(&l, order);
            let back = u * Small::from_diagonal(&sigma.into()) * v.transpose();
            assert!((back - l).amax() <= 1e-14);
            assert!((v.transpose() * v - identity(order)).amax() <= 1e-14);
            assert!((smat(&svec(&matrix, order), order) - matrix).amax() <= 1e-15);
        }
    }

    #[test]
    fn an_indefinite_matrix_has_no_factor() {
        assert!(cholesky(&-identity(3), 3).is_none());
        assert!(cholesky(&Small::from_element(f64::NAN), 4).is_none());
    }
}
