//! Jacobi rotations of two columns, from which decompositions of small matrices are made.

use nalgebra::{Dim, Matrix, RealField, StorageMut};

/// Columns (p, q) become (c p − s q, s p + c q).
#[derive(Debug, Clone, Copy)]
pub struct JacobiRotation<T> {
    /// p and q.
    pub columns: [usize; 2],
    /// c.
    pub cosine: T,
    /// s.
    pub sine: T,
}

impl<T: RealField + Copy> JacobiRotation<T> {
    /// Rotates the columns of a matrix.
    pub fn apply<R: Dim, C: Dim, S: StorageMut<T, R, C>>(&self, m: &mut Matrix<T, R, C, S>) {
        let ([p, q], c, s) = (self.columns, self.cosine, self.sine);
        for i in 0..m.nrows() {
            let (x, y) = (m[(i, p)], m[(i, q)]);
            m[(i, p)] = c * x - s * y;
            m[(i, q)] = s * x + c * y;
        }
    }
}
