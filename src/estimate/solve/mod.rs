//! One least-squares solution of one problem: Levenberg-Marquardt, the smoothing method where the model has kinks, and the
//! canonical form of what is found.

pub mod canonical_sines;
pub mod least_squares;
pub mod smoothing_method;
