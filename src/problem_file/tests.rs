//! Tests of the problem file as a whole: a complete one, broken ones, and overrides.

mod broken;
mod built;
mod complete;
mod overridden;
mod unreadable;

use std::path::Path;

use crate::problem_file::{ProblemFile, ProblemFileError};

/// Identifiers that the tests' lists of effects may hold.
const EFFECTS: &[&str] = &[
    "coulomb_friction",
    "viscous_friction",
    "stribeck_friction",
    "transmission_efficiency",
    "rotor_inertia",
    "time_delay",
    "base_tilt",
];

const FULL: &str = include_str!("tests/full.toml");

fn parse(text: &str, overrides: &[&str]) -> Result<ProblemFile, ProblemFileError> {
    let overrides: Vec<String> = overrides.iter().map(|o| (*o).to_owned()).collect();
    ProblemFile::parse(Path::new("folder/p.toml"), text, &overrides, EFFECTS)
}
