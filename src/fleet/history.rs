//! One parameter of one robot over its nights.

use crate::stats::change_point::Observation;

/// The value of one night.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Night {
    pub item: u64,
    /// Place of the value among those of its item.
    pub place: u32,
    pub time: f64,
    pub value: f64,
    pub std: f64,
    /// The part of `std` that is other from night to night.
    pub noise: f64,
}

/// What nights of one robot differ by beyond the noise of a fit, ω², and how well that is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BetweenNights {
    pub variance: f64,
    /// Degrees of freedom.
    pub freedom: f64,
}

impl BetweenNights {
    /// A robot's nights with the variance that they have without a change.
    pub fn observations(&self, nights: &[Night]) -> Vec<Observation> {
        let observation = |night: &Night| Observation {
            value: night.value,
            variance: night.noise.powi(2) + self.variance,
        };
        nights.iter().map(observation).collect()
    }
}
