//! The residual e = ŝ(θ) − s: rows of the recordings, their weights W, their noise, and the triangular factor of `[W J, W e]`.

pub mod compress;
pub mod noise;
pub mod rows;
pub mod standstill;
pub mod weights;
