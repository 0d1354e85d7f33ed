//! Eight numbers that are computed with at once.

use crate::linalg::lanes::scalar::Scalar;

/// Numbers in one value.
pub const LANES: usize = 8;

/// Eight numbers that are computed with at once.
pub trait Lanes: Scalar {
    fn from_array(values: [f64; LANES]) -> Self;
    fn to_array(self) -> [f64; LANES];
    /// Sum of the eight.
    fn sum(self) -> f64;

    /// Eight consecutive values of a series from `start`; a short end repeats its last value.
    #[inline(always)]
    fn load(series: &[f64], start: usize) -> Self {
        if let Some(Ok(whole)) = series
            .get(start..start + LANES)
            .map(<[f64; LANES]>::try_from)
        {
            return Self::from_array(whole);
        }
        let mut values = [0.0; LANES];
        for (lane, value) in values.iter_mut().enumerate() {
            *value = series[(start + lane).min(series.len() - 1)];
        }
        Self::from_array(values)
    }

    /// Writes the eight values to a series from `start`.
    #[inline(always)]
    fn store(self, series: &mut [f64], start: usize) {
        series[start..start + LANES].copy_from_slice(&self.to_array());
    }
}
