//! exid: excite, identify, diagnose.
//!
//! A module uses only modules of lower layers, and `tests/architecture.rs` holds it to this table:
//!
//! | layer | modules |
//! |---|---|
//! | 6 | `cli` |
//! | 5 | `report` |
//! | 4b | `estimate`, `simulate`, `check` |
//! | 4a | `setup` |
//! | 3 | `chain`, `outcome`, `problem_file` |
//! | 2 | `robot`, `recording`, `solve` |
//! | 1 | `problem` |
//! | 0 | `linalg`, `stats` |
//! | every layer uses | `fault` |

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
