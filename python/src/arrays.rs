//! NumPy arrays as recordings in memory: the reader works on the memory that NumPy holds.

use exid::recording::memory::{self, NamedArray, Numbers, Order};
use numpy::{PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::sync::Arc;

/// An array of NumPy that is kept alive, and its numbers.
struct Held {
    first: *const f64,
    count: usize,
    _owner: Py<PyAny>,
}

// SAFETY: the memory belongs to the owner, which lives as long; it is only read.
unsafe impl Send for Held {}
unsafe impl Sync for Held {}

impl AsRef<[f64]> for Held {
    fn as_ref(&self) -> &[f64] {
        // SAFETY: `first` and `count` are of an array in one piece, which `_owner` keeps alive.
        unsafe { std::slice::from_raw_parts(self.first, self.count) }
    }
}

/// The arrays of one recording by their names.
///
/// Arrays of float64 in one piece stay where they are; they must not be changed while a run is under way.
#[pyclass(frozen, module = "exid._core")]
pub struct Arrays {
    names: Vec<String>,
    addresses: Vec<usize>,
    pub arrays: memory::Arrays,
}

#[pymethods]
impl Arrays {
    #[new]
    fn new(named: Vec<(String, Bound<'_, PyArrayDyn<f64>>)>) -> PyResult<Self> {
        let mut held = Vec::with_capacity(named.len());
        let mut addresses = Vec::with_capacity(named.len());
        let mut names = Vec::with_capacity(named.len());
        for (name, array) in named {
            let order = if array.is_c_contiguous() {
                Order::RowMajor
            } else if array.is_fortran_contiguous() {
                Order::ColumnMajor
            } else {
                return Err(PyValueError::new_err(format!(
                    "the array {name:?} is not in one piece"
                )));
            };
            let numbers: Numbers = Arc::new(Held {
                first: array.data(),
                count: array.len(),
                _owner: array.clone().into_any().unbind(),
            });
            addresses.push(numbers.as_ref().as_ref().as_ptr() as usize);
            names.push(name.clone());
            held.push(NamedArray {
                name,
                shape: array.shape().to_vec(),
                order,
                numbers,
            });
        }
        Ok(Self {
            names,
            addresses,
            arrays: memory::Arrays::new(held),
        })
    }

    /// Where the numbers are that the reader reads, by the names of the arrays.
    fn addresses(&self) -> std::collections::BTreeMap<String, usize> {
        let addresses = self.addresses.iter().copied();
        self.names.iter().cloned().zip(addresses).collect()
    }
}
