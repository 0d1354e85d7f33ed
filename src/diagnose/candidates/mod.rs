//! Candidates: the hypotheses worth fitting, ranked by score tests, and their initial values.

pub mod grid_search;
pub mod motions;
pub mod score_test;
pub mod screening;
pub mod screening_reuse;
mod shape_search;
pub mod signal_path;
