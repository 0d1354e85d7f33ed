//! Every symbol against known factorisations, round trips and plain loops.

#![allow(unsafe_code, reason = "Clarabel calls LAPACK by raw pointers")]

use nalgebra::{DMatrix, DVector};

use super::dense;
use super::keep;

/// Entries within -1..1 without structure.
fn dense_matrix(rows: usize, columns: usize, seed: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows, columns, |i, j| {
        ((i * 37 + j * 101 + seed * 53) as f64 * 0.37).sin()
    })
}

/// An orthonormal basis.
fn orthonormal(order: usize, seed: usize) -> DMatrix<f64> {
    dense_matrix(order, order, seed).qr().q()
}

/// Bound on the backward error of a stable factorisation of order n, entries of size one.
fn rounding(n: usize) -> f64 {
    16.0 * f64::EPSILON * (n * n) as f64
}

#[test]
fn invariant_cholesky_and_lu_give_back_the_matrix() {
    for n in 1..=12 {
        let b = dense_matrix(n, n, n);
        let a = &b * b.transpose() + DMatrix::identity(n, n);
        let l = dense::cholesky(a.clone()).unwrap();
        assert!((&l * l.transpose() - &a).amax() <= rounding(n) * a.amax());
        let mut factors = b.clone();
        let swaps = dense::lu(&mut factors).unwrap();
        let mut permuted = b.clone();
        for (k, swap) in swaps.iter().enumerate() {
            permuted.swap_rows(k, *swap);
        }
        let mut lower = factors.lower_triangle();
        lower.fill_diagonal(1.0);
        assert!((lower * factors.upper_triangle() - permuted).amax() <= rounding(n));
    }
    let indefinite = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, -1.0]));
    assert_eq!(dense::cholesky(indefinite), Err(2));
    assert_eq!(dense::lu(&mut DMatrix::<f64>::zeros(3, 3)), Err(1));
}

#[test]
fn recovers_known_singular_values_also_clustered_and_zero() {
    let spectra: [fn(usize) -> f64; 5] = [
        |i| 1.0 / (1 + i) as f64,
        |_| 1.0,
        |i| if i < 3 { 1.0 - 1e-9 * i as f64 } else { 1e-6 },
        |i| 10f64.powi(-2 * i as i32),
        |i| {
            if i % 2 == 0 {
                2.0 - 0.1 * i as f64
            } else {
                0.0
            }
        },
    ];
    for spectrum in spectra {
        for (m, n) in [(1, 1), (4, 4), (7, 4), (4, 7), (12, 12), (12, 5), (1, 6)] {
            let k = usize::min(m, n);
            let mut expected: Vec<f64> = (0..k).map(spectrum).collect();
            expected.sort_by(|a, b| b.total_cmp(a));
            let expected = DVector::from_vec(expected);
            let (p, q) = (orthonormal(m, 1), orthonormal(n, 2));
            let a =
                p.columns(0, k) * DMatrix::from_diagonal(&expected) * q.columns(0, k).transpose();
            let (u, s, v) = dense::svd(&a).unwrap();
            let bound = rounding(m.max(n)) * expected[0];
            assert!((&s - &expected).amax() <= bound, "{m} x {n}: {s}");
            assert!((&u * DMatrix::from_diagonal(&s) * v.transpose() - &a).amax() <= bound);
            let identity = DMatrix::identity(k, k);
            assert!(
                (u.tr_mul(&u) - &identity).amax() <= rounding(m.max(n)),
                "{m} x {n}"
            );
            assert!(
                (v.tr_mul(&v) - &identity).amax() <= rounding(m.max(n)),
                "{m} x {n}"
            );
        }
    }
}

#[test]
fn recovers_known_eigenvalues_in_ascending_order() {
    for n in 1..=12 {
        for gap in [0.5, 1e-9, 0.0] {
            let expected = DVector::from_fn(n, |i, _| i as f64 * gap - 1.0);
            let q = orthonormal(n, 3);
            let a = &q * DMatrix::from_diagonal(&expected) * q.transpose();
            let (values, vectors) = dense::symmetric_eigen(a.clone()).unwrap();
            let bound = rounding(n) * expected.amax();
            assert!((&values - &expected).amax() <= bound, "{n} {gap}");
            let back = &vectors * DMatrix::from_diagonal(&values) * vectors.transpose();
            assert!((back - a).amax() <= bound, "{n} {gap}");
        }
    }
}

/// The symbols as the `blas` and `lapack` crates call them, through Clarabel's own dense algebra.
mod fortran {
    use core::ffi::{c_char, c_int};

    unsafe extern "C" {
        pub fn dgemm_(
            transa: *const c_char,
            transb: *const c_char,
            m: *const c_int,
            n: *const c_int,
            k: *const c_int,
            alpha: *const f64,
            a: *const f64,
            lda: *const c_int,
            b: *const f64,
            ldb: *const c_int,
            beta: *const f64,
            c: *mut f64,
            ldc: *const c_int,
        );
        pub fn dgemv_(
            trans: *const c_char,
            m: *const c_int,
            n: *const c_int,
            alpha: *const f64,
            a: *const f64,
            lda: *const c_int,
            x: *const f64,
            incx: *const c_int,
            beta: *const f64,
            y: *mut f64,
            incy: *const c_int,
        );
        pub fn dsymv_(
            uplo: *const c_char,
            n: *const c_int,
            alpha: *const f64,
            a: *const f64,
            lda: *const c_int,
            x: *const f64,
            incx: *const c_int,
            beta: *const f64,
            y: *mut f64,
            incy: *const c_int,
        );
        pub fn dsyrk_(
            uplo: *const c_char,
            trans: *const c_char,
            n: *const c_int,
            k: *const c_int,
            alpha: *const f64,
            a: *const f64,
            lda: *const c_int,
            beta: *const f64,
            c: *mut f64,
            ldc: *const c_int,
        );
        pub fn dsyr2k_(
            uplo: *const c_char,
            trans: *const c_char,
            n: *const c_int,
            k: *const c_int,
            alpha: *const f64,
            a: *const f64,
            lda: *const c_int,
            b: *const f64,
            ldb: *const c_int,
            beta: *const f64,
            c: *mut f64,
            ldc: *const c_int,
        );
        pub fn dpotrf_(
            uplo: *const c_char,
            n: *const c_int,
            a: *mut f64,
            lda: *const c_int,
            info: *mut c_int,
        );
        pub fn dpotrs_(
            uplo: *const c_char,
            n: *const c_int,
            nrhs: *const c_int,
            a: *const f64,
            lda: *const c_int,
            b: *mut f64,
            ldb: *const c_int,
            info: *mut c_int,
        );
        pub fn dgesv_(
            n: *const c_int,
            nrhs: *const c_int,
            a: *mut f64,
            lda: *const c_int,
            ipiv: *mut c_int,
            b: *mut f64,
            ldb: *const c_int,
            info: *mut c_int,
        );
    }
}

fn flag(letter: u8) -> core::ffi::c_char {
    letter as core::ffi::c_char
}

/// Stored with a leading dimension larger than the rows, so that a wrong stride shows.
fn padded(matrix: &DMatrix<f64>) -> (DMatrix<f64>, i32) {
    let rows = matrix.nrows() + 2;
    let stored = DMatrix::from_fn(rows, matrix.ncols(), |i, j| {
        if i < matrix.nrows() {
            matrix[(i, j)]
        } else {
            f64::NAN
        }
    });
    (stored, rows as i32)
}

#[test]
fn invariant_products_of_every_shape_and_flag() {
    keep();
    let (m, n, k) = (3, 4, 5);
    let (alpha, beta) = (1.5, -0.5);
    for (ta, tb) in [(b'N', b'N'), (b'T', b'N'), (b'N', b'T'), (b't', b't')] {
        let (a, b, c) = (
            dense_matrix(m, k, 1),
            dense_matrix(k, n, 2),
            dense_matrix(m, n, 3),
        );
        let (sa, lda) = padded(&if ta == b'N' { a.clone() } else { a.transpose() });
        let (sb, ldb) = padded(&if tb == b'N' { b.clone() } else { b.transpose() });
        let (mut sc, ldc) = padded(&c);
        // SAFETY: the sizes are those of the arrays.
        unsafe {
            fortran::dgemm_(
                &flag(ta),
                &flag(tb),
                &(m as i32),
                &(n as i32),
                &(k as i32),
                &alpha,
                sa.as_ptr(),
                &lda,
                sb.as_ptr(),
                &ldb,
                &beta,
                sc.as_mut_ptr(),
                &ldc,
            );
        }
        let expected = alpha * &a * &b + beta * &c;
        assert!((sc.rows(0, m) - expected).amax() <= rounding(k));
        let (x, y) = (dense_matrix(k, 1, 4), dense_matrix(m, 1, 5));
        let mut spread = dense_matrix(2 * m, 1, 0);
        for i in 0..m {
            spread[2 * i] = y[i];
        }
        let (rows, columns) = if ta == b'N' { (m, k) } else { (k, m) };
        // SAFETY: as above; y has increment 2.
        unsafe {
            fortran::dgemv_(
                &flag(ta),
                &(rows as i32),
                &(columns as i32),
                &alpha,
                sa.as_ptr(),
                &lda,
                x.as_ptr(),
                &1,
                &0.0,
                spread.as_mut_ptr(),
                &2,
            );
        }
        let expected = alpha * &a * &x;
        assert!((0..m).all(|i| (spread[2 * i] - expected[i]).abs() <= rounding(k)));
    }
}

fn in_triangle(uplo: u8, i: usize, j: usize) -> bool {
    if uplo == b'U' { i <= j } else { i >= j }
}

#[test]
fn invariant_rank_updates_touch_one_triangle() {
    let (n, k, alpha, beta) = (4, 3, 0.7, 2.0);
    for (uplo, trans) in [(b'U', b'N'), (b'L', b'N'), (b'U', b'T'), (b'L', b'T')] {
        let (a, b, c) = (
            dense_matrix(n, k, 1),
            dense_matrix(n, k, 2),
            dense_matrix(n, n, 3),
        );
        let stored = |m: &DMatrix<f64>| {
            padded(&if trans == b'N' {
                m.clone()
            } else {
                m.transpose()
            })
        };
        let ((sa, lda), (sb, ldb), (mut one, ldc)) = (stored(&a), stored(&b), padded(&c));
        let mut two = one.clone();
        let (pa, pb, order, depth) = (sa.as_ptr(), sb.as_ptr(), n as i32, k as i32);
        let (u, t) = (&flag(uplo), &flag(trans));
        let (p1, p2) = (one.as_mut_ptr(), two.as_mut_ptr());
        // SAFETY: the sizes are those of the arrays.
        unsafe {
            fortran::dsyrk_(u, t, &order, &depth, &alpha, pa, &lda, &beta, p1, &ldc);
            fortran::dsyr2k_(
                u, t, &order, &depth, &alpha, pa, &lda, pb, &ldb, &beta, p2, &ldc,
            );
        }
        let first = alpha * &a * a.transpose() + beta * &c;
        let second = alpha * (&a * b.transpose() + &b * a.transpose()) + beta * &c;
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let source = |m: &DMatrix<f64>| {
                if in_triangle(uplo, i, j) {
                    m[(i, j)]
                } else {
                    c[(i, j)]
                }
            };
            assert!((one[(i, j)] - source(&first)).abs() <= rounding(n));
            assert!((two[(i, j)] - source(&second)).abs() <= rounding(n));
        }
    }
}

#[test]
fn invariant_a_symmetric_product_reads_one_triangle() {
    let (n, alpha) = (4, 0.7);
    for uplo in [b'U', b'L'] {
        let (c, x, mut y) = (
            dense_matrix(n, n, 3),
            dense_matrix(n, 1, 6),
            dense_matrix(n, 1, 7),
        );
        let (stored, ldc) = padded(&c);
        let (pc, px, py) = (stored.as_ptr(), x.as_ptr(), y.as_mut_ptr());
        // SAFETY: the sizes are those of the arrays.
        unsafe {
            fortran::dsymv_(
                &flag(uplo),
                &(n as i32),
                &alpha,
                pc,
                &ldc,
                px,
                &1,
                &0.0,
                py,
                &1,
            )
        };
        let symmetric = DMatrix::from_fn(n, n, |i, j| {
            if in_triangle(uplo, i, j) {
                c[(i, j)]
            } else {
                c[(j, i)]
            }
        });
        assert!((y - alpha * symmetric * x).amax() <= rounding(n));
    }
}

#[test]
fn recovers_known_solutions_of_linear_systems() {
    for n in 1..=12 {
        let b = dense_matrix(n, n, 5);
        let a = &b * b.transpose() + DMatrix::identity(n, n);
        let truth = dense_matrix(n, 2, 9);
        let order = n as i32;
        for uplo in [b'U', b'L'] {
            let ((mut factor, lda), (mut x, ldx)) = (padded(&a), padded(&(&a * &truth)));
            let mut info = -9;
            // SAFETY: the sizes are those of the arrays.
            unsafe {
                fortran::dpotrf_(&flag(uplo), &order, factor.as_mut_ptr(), &lda, &mut info);
                assert_eq!(info, 0);
                let factor = factor.as_ptr();
                fortran::dpotrs_(
                    &flag(uplo),
                    &order,
                    &2,
                    factor,
                    &lda,
                    x.as_mut_ptr(),
                    &ldx,
                    &mut info,
                );
            }
            assert_eq!(info, 0);
            let condition = 1.0 + (n * n) as f64;
            assert!((x.rows(0, n) - &truth).amax() <= rounding(n) * condition);
        }
        let ((mut factor, lda), (mut x, ldx)) = (padded(&a), padded(&(&a * &truth)));
        let (mut info, mut pivots) = (-9, vec![0; n]);
        // SAFETY: as above.
        unsafe {
            let pivots = pivots.as_mut_ptr();
            fortran::dgesv_(
                &order,
                &2,
                factor.as_mut_ptr(),
                &lda,
                pivots,
                x.as_mut_ptr(),
                &ldx,
                &mut info,
            );
        }
        assert_eq!(info, 0);
        assert!((x.rows(0, n) - &truth).amax() <= rounding(n) * (1.0 + (n * n) as f64));
    }
}
