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
//! leaves, or that is the shadow of another joint, is withdrawn. All this chooses by one half of the rows that were not
//! fitted; what it has chosen is tested by the other half.

pub mod bench;
pub mod benches;
pub mod clear;
pub mod conclude;
pub mod corrections;
pub mod drift;
pub mod error;
pub mod evidence;
pub mod explain;
pub mod floor;
pub mod forecast;
pub mod grid;
pub mod holdout;
pub mod hypothesis;
pub mod judge;
pub mod lead;
pub mod locate;
pub mod memory;
pub mod next;
pub mod outweighed;
pub mod own;
pub mod passage;
pub mod passing;
pub mod periods;
pub mod points;
pub mod probability;
pub mod refit;
pub mod regime;
pub mod relief;
pub mod rest;
pub mod reuse;
pub mod rivals;
pub mod rows;
pub mod screen;
pub mod search;
pub mod shadow;
pub mod smooth;
pub mod speeds;
pub mod summary;
pub mod task;
pub mod uncertainty;
pub mod underway;
