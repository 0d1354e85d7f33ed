//! `exid design` from outside: several motions at once and one to validate with, time limits and interrupts, going
//! on from an earlier design, clearance of collision shapes, and what it says where no motion is feasible.

mod bench;
mod clearance;
#[path = "../common/mod.rs"]
mod common;
mod ends;
mod several;
