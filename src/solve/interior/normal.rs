//! Factorisation of the normal equations `(P + Σ ÃᵀÃ) d = b`, dense and symmetric.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::{DMatrix, DVector};

/// First share of the diagonal that is added: a proximal term, which moves no solution but keeps directions
/// that nothing determines from being divided by rounding.
const FIRST_SHARE: f64 = 1e-14;

/// Growth of the share where the factorisation fails, and the share at which it is given up.
const GROWTH: f64 = 100.0;
const LAST_SHARE: f64 = 1e-4;

/// Lower L of `H + share·diag(H) = L Lᵀ`.
pub(super) struct Factor {
    /// Lower triangle of H.
    normal: DMatrix<f64>,
    lower: DMatrix<f64>,
}

/// Refinements of a solution against H itself.
const REFINEMENTS: usize = 2;

impl Factor {
    /// Reads the lower triangle; `None` where the matrix is not finite.
    pub fn of(normal: DMatrix<f64>) -> Option<Self> {
        let mut share = FIRST_SHARE;
        let largest = normal.diagonal().amax();
        while share <= LAST_SHARE {
            let mut lower = normal.clone();
            for k in 0..lower.nrows() {
                // A variable that nothing sees keeps its value.
                let own = lower[(k, k)].max(f64::MIN_POSITIVE.max(f64::EPSILON.powi(2) * largest));
                lower[(k, k)] = own * (1.0 + share);
            }
            if factorise(&mut lower) && lower.diagonal().iter().all(|x| x.is_finite()) {
                return Some(Self { normal, lower });
            }
            share *= GROWTH;
        }
        None
    }

    pub fn solve(&self, right: &DVector<f64>) -> DVector<f64> {
        let mut x = self.substitute(right.clone());
        let mut rest = self.rest(&x, right);
        for _ in 0..REFINEMENTS {
            let better = &x + self.substitute(rest.clone());
            let smaller = self.rest(&better, right);
            if smaller.norm() >= rest.norm() {
                break;
            }
            (x, rest) = (better, smaller);
        }
        x
    }

    fn substitute(&self, mut x: DVector<f64>) -> DVector<f64> {
        self.lower.solve_lower_triangular_mut(&mut x);
        self.lower.tr_solve_lower_triangular_mut(&mut x);
        x
    }

    /// b − H x.
    fn rest(&self, x: &DVector<f64>, right: &DVector<f64>) -> DVector<f64> {
        let mut rest = right.clone();
        rest.sygemv(-1.0, &self.normal, x, 1.0);
        rest
    }
}

/// One thread: the same bits on every machine with as many or fewer.
fn factorise(matrix: &mut DMatrix<f64>) -> bool {
    let n = matrix.nrows();
    let mut memory = MemBuffer::new(cholesky_in_place_scratch::<f64>(
        n,
        Par::Seq,
        Default::default(),
    ));
    let view = MatMut::from_column_major_slice_mut(matrix.as_mut_slice(), n, n);
    let stack = MemStack::new(&mut memory);
    cholesky_in_place(
        view,
        Default::default(),
        Par::Seq,
        stack,
        Default::default(),
    )
    .is_ok()
}

/// The lower triangle of MᵀM.
pub(super) fn gram(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let (rows, n) = matrix.shape();
    let mut gram = DMatrix::zeros(n, n);
    let whole = MatRef::from_column_major_slice(matrix.as_slice(), rows, n);
    let shape = if is_upper_triangular(matrix) {
        BlockStructure::TriangularUpper
    } else {
        BlockStructure::Rectangular
    };
    let transposed = match shape {
        BlockStructure::TriangularUpper => BlockStructure::TriangularLower,
        other => other,
    };
    matmul(
        MatMut::from_column_major_slice_mut(gram.as_mut_slice(), n, n),
        BlockStructure::TriangularLower,
        Accum::Replace,
        whole.transpose(),
        transposed,
        whole,
        shape,
        1.0,
        Par::Seq,
    );
    gram
}

fn is_upper_triangular(matrix: &DMatrix<f64>) -> bool {
    let (rows, columns) = matrix.shape();
    rows == columns && (0..columns).all(|j| matrix.column(j).iter().skip(j + 1).all(|x| *x == 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invariant_the_solution_satisfies_the_equations() {
        for triangular in [false, true] {
            let matrix = DMatrix::from_fn(7, 7, |i, j| {
                let kept = !triangular || i <= j;
                f64::from(u8::from(kept)) * (1.0 + (3 * i + 5 * j) as f64).sin()
            });
            let gram = gram(&matrix);
            let whole = matrix.tr_mul(&matrix);
            for (i, j) in (0..7).flat_map(|i| (0..=i).map(move |j| (i, j))) {
                assert!((gram[(i, j)] - whole[(i, j)]).abs() <= 1e-14);
            }
            let truth = DVector::from_fn(7, |i, _| 1.0 + i as f64);
            let shifted = whole + DMatrix::identity(7, 7);
            let found = Factor::of(shifted.clone())
                .unwrap()
                .solve(&(&shifted * &truth));
            // The proximal share times the condition number, below 100 here.
            assert!((found - truth).amax() <= 1e-11);
        }
    }
}
