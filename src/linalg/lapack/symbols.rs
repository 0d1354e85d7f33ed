//! The Fortran interface: every argument a pointer, matrices column-major with a leading dimension.
//!
//! # Safety
//!
//! As for any BLAS and LAPACK: pointers are valid for the sizes that the other arguments state.

#![allow(unsafe_code, reason = "Clarabel calls LAPACK by raw pointers")]

use core::ffi::{c_char, c_int};

use nalgebra::{DMatrix, RealField};

use crate::linalg::lapack::dense;
use crate::linalg::lapack::foreign::{Foreign, is, triangle};

unsafe fn potrf<T: RealField + Copy>(uplo: *const c_char, a: Foreign<T>, info: *mut c_int) {
    unsafe {
        let upper = is(uplo, b'U');
        *info = match dense::cholesky(a.read_symmetric(upper)) {
            Ok(lower) if upper => {
                a.write_where(&lower.transpose(), triangle(true));
                0
            }
            Ok(lower) => {
                a.write_where(&lower, triangle(false));
                0
            }
            Err(minor) => minor as c_int,
        };
    }
}

unsafe fn potrs<T: RealField + Copy>(
    uplo: *const c_char,
    a: Foreign<T>,
    b: Foreign<T>,
    info: *mut c_int,
) {
    unsafe {
        let lower = a.read_as(is(uplo, b'U'));
        let mut x = b.read();
        let solved =
            lower.solve_lower_triangular_mut(&mut x) && lower.tr_solve_lower_triangular_mut(&mut x);
        b.write(&x);
        *info = if solved { 0 } else { 1 };
    }
}

/// Where a matrix of results goes: its first entry, and the entries from one column to the next.
struct ResultMatrix<T> {
    first: *mut T,
    stride: *const c_int,
}

impl<T: RealField + Copy> ResultMatrix<T> {
    unsafe fn write(self, matrix: &DMatrix<T>) {
        let (rows, columns) = (matrix.nrows() as c_int, matrix.ncols() as c_int);
        unsafe { Foreign::new(self.first, [&rows, &columns], self.stride).write(matrix) }
    }
}

/// The economy decomposition (job 'S'); another job is refused as argument 1.
unsafe fn svd<T: RealField + Copy>(
    job: *const c_char,
    a: Foreign<T>,
    s: *mut T,
    u: ResultMatrix<T>,
    vt: ResultMatrix<T>,
    info: *mut c_int,
) {
    unsafe {
        if !is(job, b'S') {
            *info = -1;
            return;
        }
        let Some((left, values, right)) = dense::svd(&a.read()) else {
            *info = 1;
            return;
        };
        u.write(&left);
        vt.write(&right.transpose());
        for (i, value) in values.iter().enumerate() {
            *s.add(i) = *value;
        }
        *info = 0;
    }
}

/// Whether vectors are wanted, which eigenvalues, and which triangle holds the matrix.
struct EigenFlags {
    job: *const c_char,
    range: *const c_char,
    uplo: *const c_char,
}

/// All eigenvalues, and the vectors for job 'V'; a range other than 'A' is refused as argument 2.
unsafe fn syevr<T: RealField + Copy>(
    flags: EigenFlags,
    a: Foreign<T>,
    count: *mut c_int,
    w: *mut T,
    z: ResultMatrix<T>,
    info: *mut c_int,
) {
    let EigenFlags { job, range, uplo } = flags;
    unsafe {
        if !is(range, b'A') {
            *info = -2;
            return;
        }
        let Some((values, vectors)) = dense::symmetric_eigen(a.read_symmetric(is(uplo, b'U')))
        else {
            *info = 1;
            return;
        };
        for (i, value) in values.iter().enumerate() {
            *w.add(i) = *value;
        }
        if is(job, b'V') {
            z.write(&vectors);
        }
        *count = a.rows as c_int;
        *info = 0;
    }
}

unsafe fn gesv<T: RealField + Copy>(
    a: Foreign<T>,
    pivots: *mut c_int,
    b: Foreign<T>,
    info: *mut c_int,
) {
    unsafe {
        let mut factors = a.read();
        let swaps = match dense::lu(&mut factors) {
            Ok(swaps) => swaps,
            Err(pivot) => {
                *info = pivot as c_int;
                return;
            }
        };
        let mut x = b.read();
        for (k, swap) in swaps.iter().enumerate() {
            x.swap_rows(k, *swap);
            *pivots.add(k) = *swap as c_int + 1;
        }
        factors.solve_lower_triangular_with_diag_mut(&mut x, T::one());
        factors.solve_upper_triangular_mut(&mut x);
        a.write(&factors);
        b.write(&x);
        *info = 0;
    }
}

/// Defines the eleven symbols of one precision as wrappers of the functions above.
macro_rules! symbols {
    ($T:ty: $potrf:ident $potrs:ident $gesdd:ident $gesvd:ident $syevr:ident $gesv:ident
     $gemm:ident $gemv:ident $symv:ident $syrk:ident $syr2k:ident) => {
        #[unsafe(no_mangle)]
        unsafe extern "C" fn $potrf(
            uplo: *const c_char,
            n: *const c_int,
            a: *mut $T,
            lda: *const c_int,
            info: *mut c_int,
        ) {
            unsafe { potrf(uplo, Foreign::new(a, [n, n], lda), info) }
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $potrs(
            uplo: *const c_char,
            n: *const c_int,
            nrhs: *const c_int,
            a: *const $T,
            lda: *const c_int,
            b: *mut $T,
            ldb: *const c_int,
            info: *mut c_int,
        ) {
            unsafe {
                potrs(
                    uplo,
                    Foreign::new(a, [n, n], lda),
                    Foreign::new(b, [n, nrhs], ldb),
                    info,
                )
            }
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $gesdd(
            job: *const c_char,
            m: *const c_int,
            n: *const c_int,
            a: *mut $T,
            lda: *const c_int,
            s: *mut $T,
            u: *mut $T,
            ldu: *const c_int,
            vt: *mut $T,
            ldvt: *const c_int,
            work: *mut $T,
            lwork: *const c_int,
            _iwork: *mut c_int,
            info: *mut c_int,
        ) {
            unsafe {
                $gesvd(
                    job, job, m, n, a, lda, s, u, ldu, vt, ldvt, work, lwork, info,
                )
            }
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $gesvd(
            job: *const c_char,
            _jobvt: *const c_char,
            m: *const c_int,
            n: *const c_int,
            a: *mut $T,
            lda: *const c_int,
            s: *mut $T,
            u: *mut $T,
            ldu: *const c_int,
            vt: *mut $T,
            ldvt: *const c_int,
            work: *mut $T,
            lwork: *const c_int,
            info: *mut c_int,
        ) {
            unsafe {
                if *lwork == -1 {
                    // A query of the workspace: one entry, which is never used.
                    *work = 1.0;
                    *info = 0;
                    return;
                }
                svd(
                    job,
                    Foreign::new(a, [m, n], lda),
                    s,
                    ResultMatrix {
                        first: u,
                        stride: ldu,
                    },
                    ResultMatrix {
                        first: vt,
                        stride: ldvt,
                    },
                    info,
                )
            }
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $syevr(
            job: *const c_char,
            range: *const c_char,
            uplo: *const c_char,
            n: *const c_int,
            a: *mut $T,
            lda: *const c_int,
            _vl: *const $T,
            _vu: *const $T,
            _il: *const c_int,
            _iu: *const c_int,
            _abstol: *const $T,
            m: *mut c_int,
            w: *mut $T,
            z: *mut $T,
            ldz: *const c_int,
            _isuppz: *mut c_int,
            work: *mut $T,
            lwork: *const c_int,
            iwork: *mut c_int,
            liwork: *const c_int,
            info: *mut c_int,
        ) {
            unsafe {
                if *lwork == -1 || *liwork == -1 {
                    *work = 1.0;
                    *iwork = 1;
                    *info = 0;
                    return;
                }
                syevr(
                    EigenFlags { job, range, uplo },
                    Foreign::new(a, [n, n], lda),
                    m,
                    w,
                    ResultMatrix {
                        first: z,
                        stride: ldz,
                    },
                    info,
                )
            }
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $gesv(
            n: *const c_int,
            nrhs: *const c_int,
            a: *mut $T,
            lda: *const c_int,
            ipiv: *mut c_int,
            b: *mut $T,
            ldb: *const c_int,
            info: *mut c_int,
        ) {
            unsafe {
                gesv(
                    Foreign::new(a, [n, n], lda),
                    ipiv,
                    Foreign::new(b, [n, nrhs], ldb),
                    info,
                )
            }
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $gemm(
            transa: *const c_char,
            transb: *const c_char,
            m: *const c_int,
            n: *const c_int,
            k: *const c_int,
            alpha: *const $T,
            a: *const $T,
            lda: *const c_int,
            b: *const $T,
            ldb: *const c_int,
            beta: *const $T,
            c: *mut $T,
            ldc: *const c_int,
        ) {
            unsafe {
                let (ta, tb) = (!is(transa, b'N'), !is(transb, b'N'));
                let a = Foreign::new(a, if ta { [k, m] } else { [m, k] }, lda).read_as(ta);
                let b = Foreign::new(b, if tb { [n, k] } else { [k, n] }, ldb).read_as(tb);
                Foreign::new(c, [m, n], ldc).update(a * b * *alpha, *beta, |_, _| true);
            }
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $gemv(
            trans: *const c_char,
            m: *const c_int,
            n: *const c_int,
            alpha: *const $T,
            a: *const $T,
            lda: *const c_int,
            x: *const $T,
            incx: *const c_int,
            beta: *const $T,
            y: *mut $T,
            incy: *const c_int,
        ) {
            unsafe {
                // Vectors are rows, so y = x Aᵀ.
                let a = Foreign::new(a, [m, n], lda).read_as(is(trans, b'N'));
                let x = Foreign::row(x, a.nrows(), incx).read();
                Foreign::row(y, a.ncols(), incy).update(x * a * *alpha, *beta, |_, _| true);
            }
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $symv(
            uplo: *const c_char,
            n: *const c_int,
            alpha: *const $T,
            a: *const $T,
            lda: *const c_int,
            x: *const $T,
            incx: *const c_int,
            beta: *const $T,
            y: *mut $T,
            incy: *const c_int,
        ) {
            unsafe {
                let a = Foreign::new(a, [n, n], lda).read_symmetric(is(uplo, b'U'));
                let x = Foreign::row(x, a.nrows(), incx).read();
                Foreign::row(y, a.ncols(), incy).update(x * a * *alpha, *beta, |_, _| true);
            }
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $syrk(
            uplo: *const c_char,
            trans: *const c_char,
            n: *const c_int,
            k: *const c_int,
            alpha: *const $T,
            a: *const $T,
            lda: *const c_int,
            beta: *const $T,
            c: *mut $T,
            ldc: *const c_int,
        ) {
            unsafe {
                let t = !is(trans, b'N');
                let a = Foreign::new(a, if t { [k, n] } else { [n, k] }, lda).read_as(t);
                let product = &a * a.transpose() * *alpha;
                Foreign::new(c, [n, n], ldc).update(product, *beta, triangle(is(uplo, b'U')));
            }
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $syr2k(
            uplo: *const c_char,
            trans: *const c_char,
            n: *const c_int,
            k: *const c_int,
            alpha: *const $T,
            a: *const $T,
            lda: *const c_int,
            b: *const $T,
            ldb: *const c_int,
            beta: *const $T,
            c: *mut $T,
            ldc: *const c_int,
        ) {
            unsafe {
                let t = !is(trans, b'N');
                let shape = if t { [k, n] } else { [n, k] };
                let (a, b) = (
                    Foreign::new(a, shape, lda).read_as(t),
                    Foreign::new(b, shape, ldb).read_as(t),
                );
                let half = &a * b.transpose() * *alpha;
                let product = &half + half.transpose();
                Foreign::new(c, [n, n], ldc).update(product, *beta, triangle(is(uplo, b'U')));
            }
        }
    };
}

symbols!(f64: dpotrf_ dpotrs_ dgesdd_ dgesvd_ dsyevr_ dgesv_ dgemm_ dgemv_ dsymv_ dsyrk_ dsyr2k_);
symbols!(f32: spotrf_ spotrs_ sgesdd_ sgesvd_ ssyevr_ sgesv_ sgemm_ sgemv_ ssymv_ ssyrk_ ssyr2k_);

/// Keeps the symbols in the program: a linker may drop an object file that no Rust code refers to.
pub fn keep() {
    core::hint::black_box((dgemm_ as *const (), sgemm_ as *const ()));
}
