//! Statistics: distributions, robust scales and weights, models of coloured noise, and the test of one model's residuals
//! against another's.

pub mod autoregression;
pub mod deviation;
pub mod distribution;
pub mod encompassing;
pub mod ljung_box;
pub mod range;
pub mod robust;
