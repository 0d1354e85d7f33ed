//! Motor constants from motions of one joint at constant speed, with the inertials known:
//!
//! ```text
//! k_ct·i = G(q) + C(q, q̇)q̇ + Fc·sign(q̇) + Fv·q̇
//! ```
//!
//! i: current, A; k_ct: torque constant at the joint side, N·m/A. At one speed only the sum of the
//! friction terms acts, so that the first stage gives k_ct and the friction torque for each speed, and the
//! second the friction coefficients over the speeds. Source: "ROS-based toolbox for motor parameter
//! identification of robotic manipulators", eqs. 3, 7 and 9; eq. 9 as printed lacks 1/k_ct on the friction
//! torque, without which currents would be added to torques.

pub mod compare;
pub mod constants;
pub mod error;
pub mod figures;
mod joint_fit;
pub mod outcome;
pub mod segments;
pub mod simplex;
pub mod task;

#[cfg(test)]
mod tests;
