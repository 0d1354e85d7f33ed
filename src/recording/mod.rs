//! From files to motion and signal: tables, channels, time base, periods, derivatives, noise.

pub mod columns;
pub mod csv;
pub mod error;
pub mod table;
