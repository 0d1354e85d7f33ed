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
//! | the task | `task`, `prepare`; `steady` and `strokes` for motions at constant velocity |
//! | the motion | `series` (Fourier), `motion`, `closing` where loops are closed |
//! | the information | `columns`, `laws`, `observation`, `target` |
//! | the criterion | `criterion/`, or `rivals` and `contenders` where models are to be told apart |
//! | the constraints | `limits` (linear rows), `torque`, `workspace`, `shapes` |
//! | the optimum | `problem`, `start`, `search`, `hold` (limits between samples), `verify` |
//! | what is reported | `expected`, `coverage`, `compare`, `validation`, `output`, `report` |

pub mod closing;
pub mod columns;
pub mod compare;
pub mod contenders;
pub mod coverage;
pub mod criterion;
pub mod designed;
pub mod earlier;
pub mod error;
pub mod expected;
pub mod hold;
pub mod laws;
pub mod limits;
pub mod motion;
pub mod observation;
pub mod output;
pub mod prepare;
pub mod problem;
pub mod report;
pub mod rivals;
pub mod search;
pub mod series;
pub mod shapes;
pub mod start;
pub mod steady;
pub mod strokes;
pub mod target;
pub mod task;
pub mod torque;
pub mod validation;
pub mod verify;
pub mod workspace;

#[cfg(test)]
mod tests;
