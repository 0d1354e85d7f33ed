//! The range of some numbers.

/// Lowest and highest of some values; (∞, −∞) of none.
pub(super) fn extent(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let ends = |(low, high): (f64, f64), x: f64| (low.min(x), high.max(x));
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    values.into_iter().fold(none, ends)
}
