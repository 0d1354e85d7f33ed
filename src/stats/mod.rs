//! Statistics: distributions, robust scales and weights, models of coloured noise, the test of one model's residuals
//! against another's, likelihood ratios, changes of a mean, groups of a population, ratios, false discoveries.

pub mod autoregression;
pub mod change_point;
pub mod deviation;
pub mod distribution;
pub mod encompassing;
pub mod estimation_error;
pub mod false_discovery;
pub mod likelihood_ratio;
pub mod ljung_box;
pub mod random_effects;
pub mod range;
pub mod ratio;
pub mod robust;
