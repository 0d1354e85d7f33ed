//! exid: excite, identify, diagnose.

pub mod fault;

pub mod linalg;
pub mod stats;

pub mod problem;

pub mod recording;
pub mod robot;
pub mod solve;

pub mod chain;
pub mod outcome;
pub mod problem_file;

pub mod setup;

pub mod check;
pub mod estimate;
pub mod simulate;

pub mod report;

pub mod cli;
