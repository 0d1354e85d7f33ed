//! Any text as a problem file, its first line as an override of a key.
#![no_main]

use exid::problem_file::ProblemFile;
use libfuzzer_sys::fuzz_target;
use std::path::Path;

/// A few identifiers that lists of effects may hold.
const EFFECTS: &[&str] = &[
    "coulomb_friction",
    "viscous_friction",
    "stribeck_friction",
    "transmission_efficiency",
    "rotor_inertia",
];

fuzz_target!(|text: &str| {
    let path = Path::new("folder/problem.toml");
    if let Err(fault) = ProblemFile::parse(path, text, &[], EFFECTS) {
        exid_fuzz::describes_itself(&fault);
    }
    let (first, rest) = text.split_once('\n').unwrap_or((text, ""));
    if let Err(fault) = ProblemFile::parse(path, rest, &[first.to_owned()], EFFECTS) {
        exid_fuzz::describes_itself(&fault);
    }
});
