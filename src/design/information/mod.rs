//! The Fisher information `M = WᵀW` of a motion: columns of the observation matrix W, laws of the motors, and gradients.

pub mod columns;
pub mod observation_matrix;
pub mod torque_laws;
