//! The equations of a Newton step, `(KᵀK) x = Kᵀ b − c`, by QR of the rows K: KᵀK has no digits left where cones at
//! their edge and a weak pull meet.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::householder;
use faer::linalg::qr::no_pivoting::factor::{
    qr_in_place, qr_in_place_scratch, recommended_block_size,
};
use faer::{Conj, MatMut, MatRef, Par};
use nalgebra::{DMatrix, DVector};

/// Refinements of a solution against K itself.
const REFINEMENTS: usize = 2;

/// K = Q R, its rows and columns by falling size: small rows below large ones keep their digits (Powell and Reid 1969).
pub(super) struct Factor {
    rows: DMatrix<f64>,
    order: Vec<usize>,
    columns: Vec<usize>,
    reflections: DMatrix<f64>,
    coefficients: DMatrix<f64>,
}

impl Factor {
    /// `None` where a number is not finite.
    pub fn of(rows: &DMatrix<f64>) -> Option<Self> {
        let (count, n) = rows.shape();
        let order = falling(rows.row_iter().map(|row| row.amax()).collect());
        let columns = falling(rows.column_iter().map(|column| column.amax()).collect());
        let mut sorted = DMatrix::zeros(count, n);
        for (to, &from) in order.iter().enumerate() {
            for (j, &column) in columns.iter().enumerate() {
                sorted[(to, j)] = rows[(from, column)];
            }
        }
        let block = recommended_block_size::<f64>(count, n);
        let mut coefficients = DMatrix::zeros(block, n);
        let scratch = qr_in_place_scratch::<f64>(count, n, block, Par::Seq, Default::default());
        let mut memory = MemBuffer::new(scratch);
        qr_in_place(
            of_mut(&mut sorted),
            of_mut(&mut coefficients),
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        );
        let regular = (0..n).all(|k| sorted[(k, k)].is_finite() && sorted[(k, k)] != 0.0);
        regular.then_some(Self {
            rows: rows.clone(),
            order,
            columns,
            reflections: sorted,
            coefficients,
        })
    }

    /// x for b and c.
    pub fn solve(&self, right: &DVector<f64>, linear: &DVector<f64>) -> DVector<f64> {
        let mut x = self.once(right, linear);
        for _ in 0..REFINEMENTS {
            x += self.once(&(right - &self.rows * &x), linear);
        }
        x
    }

    fn once(&self, right: &DVector<f64>, linear: &DVector<f64>) -> DVector<f64> {
        let (rows, n) = self.reflections.shape();
        let sorted = self.order.iter().map(|&row| right[row]);
        let mut turned = DMatrix::zeros(rows, 1);
        turned.iter_mut().zip(sorted).for_each(|(to, x)| *to = x);
        let block = self.coefficients.nrows();
        let scratch =
            householder::apply_block_householder_sequence_transpose_on_the_left_in_place_scratch::<
                f64,
            >(rows, block, 1);
        let mut memory = MemBuffer::new(scratch);
        householder::apply_block_householder_sequence_transpose_on_the_left_in_place_with_conj(
            of(&self.reflections),
            of(&self.coefficients),
            Conj::No,
            of_mut(&mut turned),
            Par::Seq,
            MemStack::new(&mut memory),
        );
        let upper = self.reflections.view((0, 0), (n, n));
        let mut x = turned.rows(0, n).column(0).into_owned();
        let mut by_linear = linear.select_rows(&self.columns);
        upper.tr_solve_upper_triangular_mut(&mut by_linear);
        x -= by_linear;
        upper.solve_upper_triangular_mut(&mut x);
        let mut whole = DVector::zeros(n);
        for (k, &column) in self.columns.iter().enumerate() {
            whole[column] = x[k];
        }
        whole
    }
}

/// Positions by falling size.
fn falling(sizes: Vec<f64>) -> Vec<usize> {
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    order.sort_by(|&a, &b| sizes[b].total_cmp(&sizes[a]));
    order
}

fn of(matrix: &DMatrix<f64>) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(matrix.as_slice(), matrix.nrows(), matrix.ncols())
}

fn of_mut(matrix: &mut DMatrix<f64>) -> MatMut<'_, f64> {
    let (rows, columns) = matrix.shape();
    MatMut::from_column_major_slice_mut(matrix.as_mut_slice(), rows, columns)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invariant_the_solution_satisfies_the_equations() {
        let rows = DMatrix::from_fn(9, 7, |i, j| (1.0 + (3 * i + 5 * j) as f64).sin())
            + DMatrix::identity(9, 7);
        let right = DVector::from_fn(9, |i, _| 1.0 + i as f64);
        let linear = DVector::from_fn(7, |i, _| 2.0 - i as f64);
        let found = Factor::of(&rows).unwrap().solve(&right, &linear);
        let miss = rows.tr_mul(&(&rows * found - right)) + linear;
        assert!(miss.amax() <= 1e-11, "{miss}");
    }

    /// Ten rows of size 1e10 that leave one direction to rows of size one.
    #[test]
    fn recovers_what_small_rows_say_beside_large_ones() {
        let truth = DVector::from_fn(5, |i, _| 1.0 + i as f64);
        let rows = DMatrix::from_fn(15, 5, |i, j| match i {
            0..5 => f64::from(u8::from(i == j)),
            _ => {
                let other = if j == 4 { 0 } else { j };
                1e10 * (1.0 + (3 * i + 5 * other) as f64).sin()
            }
        });
        let right = &rows * &truth;
        let found = Factor::of(&rows).unwrap().solve(&right, &DVector::zeros(5));
        assert!((found - truth).amax() <= 1e-4);
    }
}
