//! exid: excite, identify, diagnose.
//!
//! A module uses only modules of lower layers, and `tests/architecture` holds it to this table; inside a module no
//! files use each other in a circle:
//!
//! | layer | modules |
//! |---|---|
//! | 6 | `cli` |
//! | 5b | `verb` |
//! | 5a | `report`, `export` |
//! | 4d | `trials`, `rollout`, `fleet` |
//! | 4c | `diagnose`, `init` |
//! | 4b | `design`, `estimate`, `motors`, `simulate`, `check` |
//! | 4a | `setup` |
//! | 3 | `chain`, `outcome`, `problem_file` |
//! | 2b | `mechanism` |
//! | 2a | `robot`, `recording`, `solve` |
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

pub mod mechanism;

pub mod chain;
pub mod outcome;
pub mod problem_file;

pub mod setup;

pub mod check;
pub mod design;
pub mod estimate;
pub mod motors;
pub mod simulate;

pub mod diagnose;
pub mod init;

pub mod fleet;
pub mod rollout;
pub mod trials;

pub mod export;
pub mod report;

pub mod verb;

pub mod cli;
