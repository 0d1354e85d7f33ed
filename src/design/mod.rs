//! Excitation: motions from which the parameters asked for come out well, within the robot's limits.
//!
//! The Fourier coefficients x of the joints minimise a criterion of the information matrix
//! `M(x) = W(x)ᵀ W(x)` of the observation matrix W, the derivatives of the signal with respect to the
//! parameters, in units of the noise.
//!
//! # Files in the order of the work
//!
//! | step | files |
//! |---|---|
//! | the task | `task`; `constant_velocity/` where friction and drive constants are read off constant speeds |
//! | the motion | `trajectory/`: Fourier series and closed loops |
//! | the information | `information/`: the observation matrix |
//! | the criterion | `criterion/`: D-, A- and E-optimality, condition number, and T-optimality of rival models |
//! | the constraints | `constraints/`: joints, torques, loops, workspace |
//! | the inputs | `inputs/`: what the problem file states |
//! | the optimum | `problem`, with its `context`; `verify` on a dense grid of instants; `search/` from many starts |
//! | the results | `results/`: expected deviations, coverage, comparison, report |
//!
//! Imports follow this order upwards: a room uses those before `problem`, `search/` uses `verify`, `results/` uses both.

pub mod constant_velocity;
pub mod constraints;
pub mod context;
pub mod criterion;
pub mod error;
pub mod information;
pub mod inputs;
pub mod problem;
pub mod results;
pub mod search;
pub mod task;
pub mod trajectory;
pub mod verify;

#[cfg(test)]
mod tests;
