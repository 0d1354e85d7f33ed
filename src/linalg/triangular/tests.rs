//! The factor against faer's, on dependent, graded and blocked matrices, merged and streamed.

use super::*;
use nalgebra::{DMatrix, DVector};

/// A dense matrix without structure, entries within -1..1, the same on every machine.
fn dense(rows: usize, columns: usize, seed: u64) -> DMatrix<f64> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    DMatrix::from_fn(rows, columns, |_, _| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    })
}

/// Bound on the error of a sum of `rows` products of entries of size one.
fn rounding(rows: usize) -> f64 {
    8.0 * f64::EPSILON * rows as f64
}

#[test]
fn matches_the_qr_of_nalgebra_for_any_shape() {
    for (rows, columns) in [
        (1, 1),
        (3, 5),
        (63, 7),
        (64, 8),
        (65, 9),
        (500, 46),
        (7, 61),
    ] {
        let a = dense(rows, columns, 3);
        let mut reference = DMatrix::zeros(columns, columns);
        let mut r = a.clone().qr().r();
        for (i, mut row) in r.row_iter_mut().enumerate() {
            if row[i] < 0.0 {
                row.neg_mut();
            }
        }
        reference.view_mut((0, 0), r.shape()).copy_from(&r);
        let found = Triangular::of(&a).matrix();
        let error = (&found - &reference).amax();
        // Both are backward stable; R of a random matrix of this size is as well conditioned as A.
        assert!(
            error <= 1e3 * rounding(rows + columns),
            "{rows} x {columns}: {error:.1e}"
        );
    }
}

#[test]
fn keeps_the_accuracy_of_qr_where_normal_equations_lose_it() {
    // cond(A) = 1e9: AᵀA has condition 1e18 and no correct digit left in its smallest singular value.
    let size = 1e-9;
    let mut a = dense(4000, 3, 5);
    let sum = a.column(0) + a.column(1);
    let off = a.column(2) * size;
    a.set_column(2, &(sum + off));
    let exact = Triangular::of(&dense(4000, 3, 5)).entry(2, 2).abs() * size;
    let found = Triangular::of(&a).entry(2, 2).abs();
    // eps / size of the column is rounded away when the column is formed.
    assert!(
        (found / exact - 1.0).abs() <= 100.0 * f64::EPSILON / size,
        "{found:e} {exact:e}"
    );
}

#[test]
fn invariant_blocks_merges_and_weights() {
    let a = dense(1000, 11, 8);
    let whole = Triangular::of(&a).matrix();
    let mut blocks = Triangular::new(11);
    for first in (0..1000).step_by(130) {
        let count = 130.min(1000 - first);
        blocks.absorb(a.rows(first, count).into_owned().as_slice());
    }
    assert!((blocks.matrix() - &whole).amax() <= rounding(1000));
    let mut left = Triangular::of(&a.rows(0, 400).into_owned());
    left.merge(&Triangular::of(&a.rows(400, 600).into_owned()));
    assert!((left.matrix() - &whole).amax() <= rounding(1000));
    let doubled = Triangular::of(&a).scaled(2.0).matrix();
    assert_eq!(doubled, &whole * 2.0);
}

#[test]
fn invariant_the_same_rows_give_the_same_bits() {
    let a = dense(777, 20, 2);
    assert_eq!(Triangular::of(&a).matrix(), Triangular::of(&a).matrix());
}

#[test]
fn recovers_known_solution_and_residual_of_a_system() {
    let a = dense(300, 6, 4);
    let truth = DVector::from_fn(6, |i, _| 1.0 + i as f64);
    let system = Triangular::of_system(&a, &(&a * &truth)).system().unwrap();
    let found = system.matrix.solve_upper_triangular(&system.right).unwrap();
    assert!((found - &truth).amax() <= rounding(300));
    assert!(system.rest <= rounding(300));
    let covariance = Triangular::of(&a).covariance().unwrap();
    let identity = covariance * a.tr_mul(&a);
    assert!((identity - DMatrix::identity(6, 6)).amax() <= rounding(300));
}

#[test]
fn recovers_known_dependencies_from_left_to_right() {
    // Columns: 0 zero, 1, 2 free, 3 = 2 c1 - c2, 4 free, 5 = c1 + 3 c4, 6 free.
    let base = dense(200, 4, 6);
    let mut a = DMatrix::zeros(200, 7);
    for (to, from) in [(1, 0), (2, 1), (4, 2), (6, 3)] {
        a.set_column(to, &base.column(from));
    }
    a.set_column(3, &(base.column(0) * 2.0 - base.column(1)));
    a.set_column(5, &(base.column(0) + base.column(2) * 3.0));
    let found = Triangular::of(&a).independent_columns(1e-10);
    assert_eq!(found.kept, [1, 2, 4, 6]);
    assert_eq!(found.dependent, [0, 3, 5]);
    let expected = nalgebra::dmatrix![
        0.0, 2.0, 1.0;
        0.0, -1.0, 0.0;
        0.0, 0.0, 3.0;
        0.0, 0.0, 0.0
    ];
    assert!((found.coefficients - expected).amax() <= rounding(200));
    assert!(
        Triangular::new(0)
            .independent_columns(1e-10)
            .kept
            .is_empty()
    );
}

#[test]
fn matches_closed_form_condition_number() {
    // Columns (1, 0) and (1, e) scaled by 1000: cosine of the angle c = 1 / sqrt(1 + e²).
    let e: f64 = 1e-3;
    let a = nalgebra::dmatrix![1.0, 1000.0; 0.0, 1000.0 * e];
    let c = 1.0 / (1.0 + e * e).sqrt();
    let expected = ((1.0 + c) / (1.0 - c)).sqrt();
    let found = Triangular::of(&a).condition_number(ColumnScaling::UnitNorm);
    // 1 - c is formed with an error eps / (1 - c) = 4e-10.
    assert!((found / expected - 1.0).abs() <= 1e-9, "{found} {expected}");
    assert!(Triangular::of(&a).condition_number(ColumnScaling::None) > found);
    assert_eq!(
        Triangular::new(2).condition_number(ColumnScaling::None),
        f64::INFINITY
    );
}
