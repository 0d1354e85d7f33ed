//! What a fitted model leaves: over which variables it lies, what of it is noise, what of it matters, and the test of
//! one model's residuals against another's.

pub mod additive_model;
pub mod clear_band;
pub mod covariates;
pub mod effect_size;
pub mod folds;
pub mod hats;
pub mod location;
pub mod noise_level;
pub mod period_changes;
pub mod pooled;
pub mod prediction_error;
pub mod quantity;
pub mod reversal_mask;
pub mod smooth_fit;
