//! Entries of V that values name, `<joint>.<coupling>.<other joint>`.

use crate::chain::effect::COUPLING;

/// Row and column of the entry that a name stands for, if it is one's; `order` are the joints in the order of the matrix.
pub fn named(name: &str, order: &[String]) -> Option<[usize; 2]> {
    let n = order.len();
    let pairs = (0..n).flat_map(|row| (0..n).map(move |column| [row, column]));
    pairs
        .filter(|[row, column]| row != column)
        .find(|&[row, column]| name == format!("{}.{}.{}", order[row], COUPLING.id, order[column]))
}
