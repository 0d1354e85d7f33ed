//! Entries of V that values name, `<joint>.<coupling>.<other joint>`, as the matrix of a problem file.

use crate::chain::effect::COUPLING;
use crate::problem_file::{Located, Named, ProblemFile};

/// Declares the entry that a value names, with that value, where it names one; gives the joint of its row. `order` are the
/// joints in the order of the matrix.
pub fn declare(problem: &mut ProblemFile, order: &[String], entry: &Named<f64>) -> Option<String> {
    let n = order.len();
    let pairs = (0..n).flat_map(|row| (0..n).map(move |column| (row, column)));
    let (row, column) = pairs
        .filter(|(row, column)| row != column)
        .find(|&(row, column)| {
            entry.name == format!("{}.{}.{}", order[row], COUPLING.id, order[column])
        })?;
    let identity = || {
        let of = |i: usize| (0..n).map(|j| f64::from(u8::from(i == j))).collect();
        (0..n).map(of).collect()
    };
    let coupling = problem.drive.coupling.get_or_insert_with(|| Located {
        value: identity(),
        place: entry.value.place.clone(),
    });
    let slot = coupling.value.get_mut(row)?.get_mut(column)?;
    *slot = entry.value.value;
    Some(order[row].clone())
}
