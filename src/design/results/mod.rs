//! Results of a design: expected standard deviations, coverage of the effects, comparison with a reference motion, report.

pub mod comparison;
pub mod coverage;
pub mod designed;
pub mod expected_deviations;
pub mod report;
