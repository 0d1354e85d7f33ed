//! Channels of a robot in SI units, from the columns of a table: which column holds which channel, in which unit, and what
//! is missing.

pub mod column_map;
pub mod column_names;
pub mod columns;
mod command;
pub mod lost;
pub mod missing;
pub mod samples;
pub mod survey;
