//! Where model and recordings differ, what physics is missing, and the model with it.
//!
//! ```text
//! e = ŝ(θ) − s                       residual of the declared model, all parameters free
//! e_h = ŝ_h(θ_h) − s                 residual of the model with hypothesis h, all parameters fitted again
//! e = b (e − e_h) + ε,  H0: b = 0    on recordings that were not fitted: does h forecast the residual?
//! ```
//!
//! Hypotheses are screened by what they would take from the residual beyond what all other parameters can
//! take (Frisch and Waugh 1933, Lovell 1963), the leading ones are fitted exactly, the best that passes the
//! test of forecast encompassing (Chong and Hendry 1986; Harvey, Leybourne and Newbold 1998) joins the
//! model, and so on until none does; then each is dropped on trial, and a name that explains less than it
//! leaves, or is superfluous beside a smooth correction or a formula of another joint's motion, is withdrawn. All this
//! chooses by one half of the rows that were not fitted; what it has chosen is tested by the other half.
//!
//! # Files in the order of the work
//!
//! `task` reads and checks; `search` leads from the declared model to a report, and within it `fit/` fits the declared model;
//! `residuals/` looks at what it leaves; `candidates/` screens effects by score tests; `selection/` fits, tests and compares them;
//! `formula/` seeks laws for what has no name; `conclusion/` withdraws and confirms; `findings/` says what they mean. `simulator/` compares
//! a robot with its simulator.

pub mod candidates;
pub mod conclusion;
pub mod error;
pub mod findings;
pub mod fit;
pub(crate) mod formula;
pub mod residuals;
mod search;
pub mod selection;
pub mod simulator;
pub mod stage;
pub mod task;
