//! Models with hypotheses in them, fitted: the recordings with their held-out halves, what may be missing, the fits and
//! what a diagnosis keeps of them.

pub mod candidate;
pub mod channel_series;
pub mod context;
pub mod contexts;
pub mod declared;
pub mod derivatives;
pub mod estimation_error;
pub mod fit_cache;
pub mod fitting;
pub mod held_out;
pub mod hypothesis;
pub mod linear_model;
pub mod model_fit;
pub mod recording_parameters;
pub mod start;
pub mod start_grid;
