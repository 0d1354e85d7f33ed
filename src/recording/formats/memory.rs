//! Arrays in memory that stand in the place of files, read as the arrays of a NumPy archive are: a vector `t` is the column
//! `t`, a matrix `q` the columns `q1`, `q2`, ..., samples along the longer side.
//!
//! The arrays stay where they are, and their owner keeps them. What is computed with has one copy: `Arrays::read` takes
//! the columns that a problem wants into the table that is filtered and scaled afterwards.

use std::borrow::Cow;
use std::collections::HashMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use sha2::{Digest, Sha256};

use crate::recording::error::RecordingError;
use crate::recording::formats::arrays::{Layout, Storage, assemble, column_names};
use crate::recording::formats::table::Table;

/// Which side of a matrix varies fastest in memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// Rows one after the other, as NumPy has it by default.
    RowMajor,
    /// Columns one after the other, as Fortran has it.
    ColumnMajor,
}

/// Numbers that their owner keeps while anybody reads them.
pub type Numbers = Arc<dyn AsRef<[f64]> + Send + Sync>;

/// An array with its name: so many numbers as its sides multiply to.
#[derive(Clone)]
pub struct NamedArray {
    /// Name of the column, or of columns that are numbered.
    pub name: String,
    /// Lengths of its sides.
    pub shape: Vec<usize>,
    /// In which order the numbers lie.
    pub order: Order,
    /// All of them, one after the other in that order.
    pub numbers: Numbers,
}

/// The arrays of one recording.
#[derive(Clone, Default)]
pub struct Arrays {
    layouts: Vec<Layout>,
    numbers: Vec<Numbers>,
}

impl Arrays {
    /// Those of the arrays that can hold channels: no scalars, nothing empty, at most two sides.
    pub fn new(arrays: Vec<NamedArray>) -> Self {
        let mut kept = Self::default();
        for array in arrays {
            let storage = match array.order {
                Order::RowMajor => Storage::RowMajor,
                Order::ColumnMajor => Storage::ColumnMajor,
            };
            let count = array.shape.iter().product::<usize>();
            let whole = array.numbers.as_ref().as_ref().len() == count;
            match Layout::new(&array.name, &array.shape, storage) {
                Some(layout) if whole => {
                    kept.layouts.push(layout);
                    kept.numbers.push(array.numbers);
                }
                _ => {}
            }
        }
        kept
    }

    /// Names of all columns.
    pub(in crate::recording) fn columns(&self) -> Vec<String> {
        column_names(&self.layouts)
    }

    /// The wanted columns. Errors: columns of one name or unequal length, too few rows.
    pub(in crate::recording) fn read(
        &self,
        path: &Path,
        wanted: &[String],
    ) -> Result<Table, RecordingError> {
        assemble(path, &self.layouts, wanted, |at| {
            Ok(Cow::Borrowed(self.numbers[at].as_ref().as_ref()))
        })
    }

    /// SHA-256 of names, sides and numbers, 64 hexadecimal digits in lower case.
    pub fn sha256(&self) -> String {
        let mut hash = Sha256::new();
        for (layout, numbers) in self.layouts.iter().zip(&self.numbers) {
            hash.update(format!("{layout:?}\n"));
            for number in numbers.as_ref().as_ref() {
                hash.update(number.to_le_bytes());
            }
        }
        let digits = hash.finalize();
        digits.iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

impl fmt::Debug for Arrays {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(&self.layouts).finish()
    }
}

/// Recordings in memory by the path under which a problem names them.
#[derive(Debug, Clone, Default)]
pub struct ArraysInMemory {
    by_path: HashMap<PathBuf, Arrays>,
}

impl ArraysInMemory {
    /// Puts a recording under a path, whether or not there is a file.
    pub fn insert(&mut self, path: PathBuf, arrays: Arrays) {
        self.by_path.insert(path, arrays);
    }

    /// The recording under a path.
    pub fn at(&self, path: &Path) -> Option<&Arrays> {
        self.by_path.get(path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::formats::format::{columns_at, read_at};
    use crate::recording::formats::reading::Reading;

    fn reading(arrays: Vec<NamedArray>) -> Reading {
        let mut reading = Reading::default();
        reading.memory.insert("run".into(), Arrays::new(arrays));
        reading
    }

    fn array(name: &str, shape: &[usize], order: Order, numbers: Vec<f64>) -> NamedArray {
        NamedArray {
            name: name.into(),
            shape: shape.to_vec(),
            order,
            numbers: Arc::new(numbers),
        }
    }

    #[test]
    fn both_orders_of_a_matrix_give_the_columns_of_its_longer_side() {
        let rows = 30;
        let value = |row: usize, joint: usize| (10 * row + joint) as f64;
        let by_rows = (0..rows).flat_map(|r| [value(r, 1), value(r, 2)]);
        let by_columns = [1, 2].map(|j| (0..rows).map(move |r| value(r, j)));
        let time: Vec<f64> = (0..rows).map(|row| row as f64).collect();
        let reading = reading(vec![
            array("t", &[rows], Order::RowMajor, time.clone()),
            array("q", &[rows, 2], Order::RowMajor, by_rows.collect()),
            array(
                "tau",
                &[rows, 2],
                Order::ColumnMajor,
                by_columns.into_iter().flatten().collect(),
            ),
            array("short", &[3], Order::RowMajor, vec![0.0; 2]),
        ]);
        let path = Path::new("run");
        let names = columns_at(path, &reading).unwrap();
        assert_eq!(names, ["t", "q1", "q2", "tau1", "tau2"]);
        let wanted: Vec<String> = ["tau2", "q1", "t"].map(String::from).to_vec();
        let table = read_at(path, &wanted, &reading).unwrap();
        let joint = |j| (0..rows).map(|row| value(row, j)).collect::<Vec<f64>>();
        assert_eq!(table.data, [joint(2), joint(1), time]);
    }

    #[test]
    fn one_number_more_or_less_is_another_recording() {
        let of = |numbers: Vec<f64>| {
            let shape = [numbers.len()];
            Arrays::new(vec![array("t", &shape, Order::RowMajor, numbers)]).sha256()
        };
        assert_eq!(of(vec![1.0, 2.0]), of(vec![1.0, 2.0]));
        assert_ne!(of(vec![1.0, 2.0]), of(vec![1.0, 2.0, 2.0]));
        assert_ne!(of(vec![1.0, 2.0]), of(vec![2.0, 1.0]));
    }
}
