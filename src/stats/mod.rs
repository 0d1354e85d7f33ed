//! Statistics: distributions, robust scales and weights, and models of coloured noise.

pub mod autoregression;
pub mod distribution;
pub mod ljung_box;
pub mod robust;
