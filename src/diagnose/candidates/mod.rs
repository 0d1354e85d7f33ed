//! Which hypotheses are worth fitting, and from where: the score test of each of them.

pub mod grid_search;
pub mod score_test;
pub mod screening_reuse;
pub mod signal_path;
