//! Many recordings of many robots: every item fitted or diagnosed once, and which robots have changed.
//!
//! ```text
//! manifest -> items (one result each, kept by the hash of all that it depends on) -> table -> what changed
//! ```
//!
//! Items are independent of each other and their results do not depend on the order in which they are made, on how many
//! threads or processes make them, and on how often these are killed: the table is a function of manifest and inputs.
//! What changed is said by a model of each parameter of each type,
//!
//! ```text
//! x_rk = θ_r + δ_r·[k ≥ c_r] + b_rk + e_rk,   θ_r ~ N(μ, τ²),  b_rk ~ N(0, ω²),  e_rk ~ N(0, s_rk²)
//! ```
//!
//! for robot r on night k: s is the standard deviation that the fit gives, ω what nights differ by beyond it, τ what robots
//! differ by. ω and τ are robust to robots that change.

mod attempt;
mod change;
mod driver;
pub mod error;
mod history;
mod item;
pub mod key;
pub mod kind;
pub mod manifest;
mod scratch;
mod settings;
pub mod shard;
pub mod store;
mod summary;
mod table;
pub mod task;
mod time;

#[cfg(test)]
mod tests;
