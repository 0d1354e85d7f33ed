//! Linear least squares within bounds: min 1/2 |A d - b|² subject to lower <= d <= upper.
//!
//! A primal active-set method: the minimiser over the free variables, a step towards it up to the first
//! bound, release of the bound with the largest multiplier of the wrong sign. Source: Stark and Parker
//! (1995), bounded-variable least squares; Lawson and Hanson (1974), chapter 23.

use nalgebra::{DMatrix, DVector};

use crate::linalg::triangular::Triangular;

/// A multiplier with |m_j| <= this times |A_j| |A d - b| is zero up to rounding.
const MULTIPLIER_TOLERANCE: f64 = 1e-13;

/// Changes of the active set per variable before the search ends with the best feasible point.
const CHANGES_PER_VARIABLE: usize = 10;

/// Bounds of a step, entry by entry; zero lies within them.
pub struct Bounds {
    /// Least step, <= 0; minus infinity where there is none.
    pub lower: DVector<f64>,
    /// Greatest step, >= 0; infinity where there is none.
    pub upper: DVector<f64>,
}

/// The minimiser over lower <= d <= upper; A is m x n of full column rank.
///
/// Columns that are dependent in spite of that keep the value zero.
pub fn minimize(matrix: &DMatrix<f64>, right: &DVector<f64>, bounds: &Bounds) -> DVector<f64> {
    let count = matrix.ncols();
    let mut step = DVector::zeros(count);
    let mut free: Vec<bool> = (0..count)
        .map(|j| bounds.lower[j] < bounds.upper[j])
        .collect();
    for _ in 0..CHANGES_PER_VARIABLE * (count + 1) {
        let target = free_minimizer(matrix, right, &free, &step);
        if advance(&mut step, &target, &mut free, bounds) {
            continue;
        }
        match wrongly_held(matrix, right, &step, &free, bounds) {
            Some(j) => free[j] = true,
            None => break,
        }
    }
    step
}

/// The minimiser over the free variables, the others as they are.
fn free_minimizer(
    matrix: &DMatrix<f64>,
    right: &DVector<f64>,
    free: &[bool],
    step: &DVector<f64>,
) -> DVector<f64> {
    let columns: Vec<usize> = (0..free.len()).filter(|j| free[*j]).collect();
    let mut held = step.clone();
    for j in &columns {
        held[*j] = 0.0;
    }
    let rest = right - matrix * &held;
    let mut target = held;
    let system = Triangular::of_system(&matrix.select_columns(&columns), &rest).system();
    let solution = system.and_then(|s| s.matrix.solve_upper_triangular(&s.right));
    if let Some(solution) = solution.filter(|s| s.iter().all(|v| v.is_finite())) {
        for (j, value) in columns.iter().zip(solution.iter()) {
            target[*j] = *value;
        }
    } else {
        target.copy_from(step);
    }
    target
}

/// Moves towards the target up to the first bound and holds what reaches it; whether a bound was met.
fn advance(
    step: &mut DVector<f64>,
    target: &DVector<f64>,
    free: &mut [bool],
    bounds: &Bounds,
) -> bool {
    let bound_of = |j: usize| {
        if target[j] < bounds.lower[j] {
            Some(bounds.lower[j])
        } else if target[j] > bounds.upper[j] {
            Some(bounds.upper[j])
        } else {
            None
        }
    };
    let share = |j: usize, bound: f64| (bound - step[j]) / (target[j] - step[j]);
    let first = (0..step.len())
        .filter(|j| free[*j])
        .filter_map(|j| bound_of(j).map(|bound| (j, bound, share(j, bound))))
        .min_by(|a, b| a.2.total_cmp(&b.2));
    let Some((hit, bound, share)) = first else {
        step.copy_from(target);
        return false;
    };
    *step += (target - &*step) * share;
    step[hit] = bound;
    free[hit] = false;
    true
}

/// The held variable whose release lowers the cost fastest.
fn wrongly_held(
    matrix: &DMatrix<f64>,
    right: &DVector<f64>,
    step: &DVector<f64>,
    free: &[bool],
    bounds: &Bounds,
) -> Option<usize> {
    let residual = right - matrix * step;
    let size = residual.norm();
    let gain = |j: usize| {
        let column = matrix.column(j);
        let descent = column.dot(&residual);
        let inward = if step[j] <= bounds.lower[j] {
            descent
        } else {
            -descent
        };
        let norm = column.norm();
        (inward > MULTIPLIER_TOLERANCE * norm * size).then(|| (j, inward / norm))
    };
    (0..step.len())
        .filter(|j| !free[*j] && bounds.lower[*j] < bounds.upper[*j])
        .filter_map(gain)
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(j, _)| j)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{dmatrix, dvector};

    #[test]
    fn matches_closed_form_where_one_bound_moves_the_other_variable() {
        // Minimise (x + y - 3)² + (x - y)²: free optimum (1.5, 1.5); x <= 1 gives y = 3/2 still.
        let a = dmatrix![1.0, 1.0; 1.0, -1.0];
        let bounds = Bounds {
            lower: dvector![-1.0, -1.0],
            upper: dvector![1.0, 5.0],
        };
        let d = minimize(&a, &dvector![3.0, 0.0], &bounds);
        assert!((d - dvector![1.0, 1.5]).amax() <= 1e-15);
    }

    #[test]
    fn invariant_solutions_satisfy_the_optimality_conditions() {
        // Strongly correlated columns: the projection of the free optimum is not the bounded optimum.
        for seed in 0..200_u32 {
            let value = |i: usize, j: usize| ((seed as usize * 37 + i * 11 + j * 5) as f64).sin();
            let a = DMatrix::from_fn(9, 6, |i, j| value(i, j) + 2.0 * value(i, 9));
            let b = DVector::from_fn(9, |i, _| 3.0 * value(i, 20));
            let bounds = Bounds {
                lower: DVector::from_fn(6, |j, _| -0.2 - value(j, 31).abs()),
                upper: DVector::from_fn(6, |j, _| 0.1 * value(j, 40).abs()),
            };
            let d = minimize(&a, &b, &bounds);
            let gradient = a.tr_mul(&(&a * &d - &b));
            let tolerance = 1e-11 * a.norm() * b.norm();
            for j in 0..6 {
                assert!(bounds.lower[j] <= d[j] && d[j] <= bounds.upper[j]);
                if d[j] > bounds.lower[j] {
                    assert!(gradient[j] <= tolerance, "seed {seed}, variable {j}");
                }
                if d[j] < bounds.upper[j] {
                    assert!(gradient[j] >= -tolerance, "seed {seed}, variable {j}");
                }
            }
        }
    }
}
