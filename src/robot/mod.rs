//! Robots: kinematic trees, inertial parameters, inverse and forward dynamics, regressors.

pub mod batch;
pub mod derivatives;
pub mod forward_dynamics;
pub mod inertia;
mod motion;
pub mod newton_euler;
pub mod random;
pub mod regressor;
pub mod regressor_gradient;
pub mod scalar;
pub mod tree;
mod vector;

#[cfg(test)]
mod tests;
