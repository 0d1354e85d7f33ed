//! The measurement chain of a robot: motion → rigid body → transmission → motor → signal.
//!
//! ```text
//! q = V m + offset                       m: motor positions at joint scale
//! τ = Y(q, q̇, q̈) π  (+ payload)         joint torque;  τ_M = Vᵀ τ
//! τ_mot = τ_M + Σ laws(m, ṁ, m̈)         rotor inertia, friction, offsets
//! s = τ_mot / (k · gain)                 current (k: torque constant) or torque (k = 1)
//! s_i = s_i + Σ x_ij s_j                 crosstalk of the channels of motors
//! s = (τ_mot / gain + kd (ṁ − v_c) − u) / kp     error of a position controller, see [`controller`]
//! ```
//!
//! A [`model::Model`] lists every parameter with its name, unit and state; [`evaluate`] predicts the
//! signal and its derivatives with respect to any of them; [`forward`] turns the chain round, from the
//! signal to the motion; [`effect`] is the table of the physics.
//!
//! # Files in the order of the work
//!
//! | step | files |
//! |---|---|
//! | what a model is made of | `settings`, `effect/`, `platform`, `controller`, `crosstalk` |
//! | the model with its parameters | `model` (by `assemble`), `joint_model`, `parameter`, `effect_parameter`, `sharing`, `channel`, `transition_limits` |
//! | what the signal depends on | `base_parameters` |
//! | recordings, and what is known before them | `dataset`, `prior` |
//! | from motion to signal, with derivatives | `evaluate/` |
//! | from signal to motion | `forward/`, `flank` |

pub mod assemble;
pub mod base_parameters;
mod channel;
pub mod controller;
pub mod crosstalk;
pub mod dataset;
pub mod effect;
pub mod effect_parameter;
pub mod error;
pub mod evaluate;
pub mod flank;
pub mod forward;
pub mod illustration;
mod joint_model;
pub mod model;
pub mod parameter;
pub mod platform;
pub mod prior;
pub mod rigid_bodies_only;
mod settings;
pub mod sharing;
pub mod signal;
pub mod transition_limits;
pub mod words;

#[cfg(test)]
mod tests;
