//! Factorisations of small dense matrices in any precision: A = L Lᵀ, P A = L U, A = U diag(s) Vᵀ, S = V diag(w) Vᵀ.

use crate::linalg::jacobi_rotation::JacobiRotation;
use nalgebra::{DMatrix, DVector, RealField, SymmetricEigen};

/// Sweeps of the Jacobi method; convergence is quadratic and takes fewer than ten.
const SWEEPS: usize = 60;

/// Iterations of the QR algorithm per row of a symmetric matrix; two or three are usual.
const ITERATIONS_PER_ROW: usize = 60;

/// The lower factor of a symmetric positive definite matrix, of which the lower triangle is read.
///
/// The error is the order of the leading minor that is not positive, from 1.
pub(super) fn cholesky<T: RealField + Copy>(mut a: DMatrix<T>) -> Result<DMatrix<T>, usize> {
    let n = a.nrows();
    for j in 0..n {
        let mut pivot = a[(j, j)];
        for k in 0..j {
            pivot -= a[(j, k)] * a[(j, k)];
        }
        if !pivot.is_finite() || pivot <= T::zero() {
            return Err(j + 1);
        }
        let diagonal = pivot.sqrt();
        a[(j, j)] = diagonal;
        for i in j + 1..n {
            let mut entry = a[(i, j)];
            for k in 0..j {
                entry -= a[(i, k)] * a[(j, k)];
            }
            a[(i, j)] = entry / diagonal;
        }
        for i in 0..j {
            a[(i, j)] = T::zero();
        }
    }
    Ok(a)
}

/// LU with partial pivoting in place (unit lower triangle below U); the row swapped with each row, from 0.
///
/// The error is the number of the first pivot that is zero, from 1.
pub(super) fn lu<T: RealField + Copy>(a: &mut DMatrix<T>) -> Result<Vec<usize>, usize> {
    let n = a.nrows();
    let mut swaps = Vec::with_capacity(n);
    for k in 0..n {
        let pivot = k + a.column(k).rows(k, n - k).iamax();
        if a[(pivot, k)] == T::zero() {
            return Err(k + 1);
        }
        a.swap_rows(k, pivot);
        swaps.push(pivot);
        for i in k + 1..n {
            let factor = a[(i, k)] / a[(k, k)];
            a[(i, k)] = factor;
            for j in k + 1..n {
                let change = factor * a[(k, j)];
                a[(i, j)] -= change;
            }
        }
    }
    Ok(swaps)
}

/// U (m x k), s descending (k) and V (n x k) with k = min(m, n), by one-sided Jacobi rotations.
///
/// Each singular value is accurate to rounding times its own size where the columns allow it, also for
/// clustered values. Source: Demmel and Veselić (1992). `None` if the sweeps do not converge.
pub(super) fn svd<T: RealField + Copy>(
    a: &DMatrix<T>,
) -> Option<(DMatrix<T>, DVector<T>, DMatrix<T>)> {
    if a.nrows() < a.ncols() {
        let (u, s, v) = svd(&a.transpose())?;
        return Some((v, s, u));
    }
    let n = a.ncols();
    let (mut u, mut v) = (a.clone(), DMatrix::identity(n, n));
    let mut sweeps = 0;
    while rotate_all(&mut u, &mut v) {
        sweeps += 1;
        if sweeps == SWEEPS {
            return None;
        }
    }
    let norms: Vec<T> = u.column_iter().map(|c| c.norm()).collect();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|i, j| {
        norms[*j]
            .partial_cmp(&norms[*i])
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    let (mut u, v) = (u.select_columns(&order), v.select_columns(&order));
    let s = DVector::from_iterator(n, order.iter().map(|j| norms[*j]));
    normalize(&mut u, &s);
    Some((u, s, v))
}

/// One sweep of rotations that make pairs of columns orthogonal; whether one was needed.
fn rotate_all<T: RealField + Copy>(u: &mut DMatrix<T>, v: &mut DMatrix<T>) -> bool {
    let n = u.ncols();
    // A product of columns carries the rounding of as many terms as they have rows: asking for less
    // turns the same pair for ever.
    let terms = T::from_usize(u.nrows().max(1)).unwrap_or_else(T::one);
    let rounding = T::default_epsilon() * terms;
    let mut rotated = false;
    for p in 0..n {
        for q in p + 1..n {
            let (pp, qq) = (u.column(p).norm_squared(), u.column(q).norm_squared());
            let pq = u.column(p).dot(&u.column(q));
            let coupled = pq.abs() > rounding * pp.sqrt() * qq.sqrt();
            if !coupled {
                continue;
            }
            rotated = true;
            let zeta = (qq - pp) / (pq + pq);
            let t = zeta.signum() / (zeta.abs() + (T::one() + zeta * zeta).sqrt());
            let c = T::one() / (T::one() + t * t).sqrt();
            let rotation = JacobiRotation {
                columns: [p, q],
                cosine: c,
                sine: c * t,
            };
            rotation.apply(u);
            rotation.apply(v);
        }
    }
    rotated
}

/// Divides columns by their norms; columns lost in rounding become unit vectors orthogonal to the others.
fn normalize<T: RealField + Copy>(u: &mut DMatrix<T>, s: &DVector<T>) {
    let largest = if s.is_empty() { T::zero() } else { s[0] };
    for j in 0..u.ncols() {
        if s[j] > T::default_epsilon() * T::default_epsilon() * largest {
            u.column_mut(j).unscale_mut(s[j]);
            continue;
        }
        let before = u.columns(0, j).into_owned();
        // The unit vector that the columns before reach least.
        let reached = |i: usize| before.row(i).norm_squared();
        let axis = (0..u.nrows()).min_by(|a, b| {
            reached(*a)
                .partial_cmp(&reached(*b))
                .unwrap_or(std::cmp::Ordering::Equal)
        });
        let mut unit = DVector::zeros(u.nrows());
        if let Some(axis) = axis {
            unit[axis] = T::one();
        }
        // Twice is enough for orthogonality to rounding (Kahan, in Parlett 1998, section 6.9).
        for _ in 0..2 {
            let explained = &before * before.tr_mul(&unit);
            unit -= explained;
        }
        unit.normalize_mut();
        u.set_column(j, &unit);
    }
}

/// Eigenvalues ascending and eigenvectors of a symmetric matrix; `None` if the iteration does not converge.
pub(super) fn symmetric_eigen<T: RealField + Copy>(
    a: DMatrix<T>,
) -> Option<(DVector<T>, DMatrix<T>)> {
    let limit = ITERATIONS_PER_ROW * (a.nrows() + 1);
    let eigen = SymmetricEigen::try_new(a, T::default_epsilon(), limit)?;
    let values = &eigen.eigenvalues;
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|i, j| {
        values[*i]
            .partial_cmp(&values[*j])
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    Some((
        values.select_rows(&order),
        eigen.eigenvectors.select_columns(&order),
    ))
}
