//! Experiments at constant velocity: one joint after the other moves to and fro at speeds from slow to fast.

pub mod plan;
pub mod task;
