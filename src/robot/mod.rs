//! Robots: kinematic trees, inertial parameters, inverse and forward dynamics, regressors.

mod assemble;
pub mod batch;
mod dependents;
pub mod derivative_batch;
pub mod derivatives;
pub mod description;
pub mod error;
mod file;
pub mod forward_dynamics;
pub mod inertia;
pub mod mdh;
pub mod mjcf;
mod mjcf_fault;
mod motion;
pub mod newton_euler;
pub mod random;
pub mod regressor;
pub mod regressor_gradient;
pub mod sample_regressor;
pub mod tree;
pub mod urdf;
mod vector;

#[cfg(test)]
mod tests;
