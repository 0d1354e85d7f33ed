//! Matrices and flags in the memory of a Fortran caller.

#![allow(unsafe_code, reason = "Clarabel calls LAPACK by raw pointers")]

use core::ffi::{c_char, c_int};

use nalgebra::{DMatrix, RealField};

/// A column-major matrix in foreign memory.
#[derive(Clone, Copy)]
pub(super) struct Foreign<T> {
    first: *mut T,
    pub(super) rows: usize,
    pub(super) columns: usize,
    /// Entries from one column to the next.
    stride: usize,
}

impl<T: RealField + Copy> Foreign<T> {
    pub(super) unsafe fn new(
        first: *const T,
        [rows, columns]: [*const c_int; 2],
        stride: *const c_int,
    ) -> Self {
        unsafe {
            Self {
                first: first.cast_mut(),
                rows: size(rows),
                columns: size(columns),
                stride: size(stride),
            }
        }
    }

    /// A vector as the row of a matrix whose stride is the increment.
    pub(super) unsafe fn row(first: *const T, length: usize, increment: *const c_int) -> Self {
        unsafe {
            Self {
                first: first.cast_mut(),
                rows: 1,
                columns: length,
                stride: size(increment),
            }
        }
    }

    pub(super) unsafe fn read(self) -> DMatrix<T> {
        DMatrix::from_fn(self.rows, self.columns, |i, j| unsafe {
            *self.first.add(i + j * self.stride)
        })
    }

    pub(super) unsafe fn read_as(self, transposed: bool) -> DMatrix<T> {
        let matrix = unsafe { self.read() };
        if transposed {
            matrix.transpose()
        } else {
            matrix
        }
    }

    /// The whole symmetric matrix of which one triangle is stored.
    pub(super) unsafe fn read_symmetric(self, upper: bool) -> DMatrix<T> {
        DMatrix::from_fn(self.rows, self.columns, |i, j| {
            let (i, j) = if (i <= j) == upper { (i, j) } else { (j, i) };
            unsafe { *self.first.add(i + j * self.stride) }
        })
    }

    pub(super) unsafe fn write(self, matrix: &DMatrix<T>) {
        unsafe { self.write_where(matrix, |_, _| true) }
    }

    pub(super) unsafe fn write_where(
        self,
        matrix: &DMatrix<T>,
        chosen: impl Fn(usize, usize) -> bool,
    ) {
        for j in 0..self.columns.min(matrix.ncols()) {
            for i in 0..self.rows.min(matrix.nrows()) {
                if chosen(i, j) {
                    unsafe { *self.first.add(i + j * self.stride) = matrix[(i, j)] }
                }
            }
        }
    }

    /// C = product + beta C at the chosen entries; C is not read where beta is zero.
    pub(super) unsafe fn update(
        self,
        product: DMatrix<T>,
        beta: T,
        chosen: impl Fn(usize, usize) -> bool,
    ) {
        unsafe {
            let sum = if beta == T::zero() {
                product
            } else {
                product + self.read() * beta
            };
            self.write_where(&sum, chosen);
        }
    }
}

unsafe fn size(value: *const c_int) -> usize {
    usize::try_from(unsafe { *value }).unwrap_or(0)
}

/// Whether a flag is the given letter, in either case.
pub(super) unsafe fn is(flag: *const c_char, letter: u8) -> bool {
    unsafe { (*flag as u8).eq_ignore_ascii_case(&letter) }
}

/// The entries of one triangle, with the diagonal.
pub(super) fn triangle(upper: bool) -> impl Fn(usize, usize) -> bool {
    move |i, j| if upper { i <= j } else { i >= j }
}
