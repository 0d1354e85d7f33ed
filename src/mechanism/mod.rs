//! Mechanisms: trees of links whose loops are closed.
//!
//! ```text
//! g(q) = 0,   q = (q_a, q_p)                     q_a: joints with motors, q_p: joints without
//! G q̇ = 0,    G = ∂g/∂q = (G_a, G_p)             q̇_p = P q̇_a,  P = −G_p⁺ G_a
//! G q̈ + Ġ q̇ = 0                                  q̈_p = P q̈_a − G_p⁺ Ġ q̇
//! τ_a = Jᵀ τ(q, q̇, q̈),   J = (1, P)               forces that close a loop do no work
//! ```
//!
//! τ are the torques of the open tree, so that regressors of a mechanism are those of its tree times Jᵀ. A
//! [`Condition`](condition::Condition) knows its gap g, its rows of G and Ġ q̇; everything else is
//! [`Mechanism`](loops::Mechanism). [`h4`] makes one from the lengths of the parallel robot H4.

pub mod condition;
pub mod error;
pub mod h4;
pub mod loops;
mod motion;

#[cfg(test)]
mod tests;
