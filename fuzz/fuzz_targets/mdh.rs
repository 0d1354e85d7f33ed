//! Any text as a robot file: a table of Denavit-Hartenberg parameters.
#![no_main]

use exid::robot::mdh;
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|text: &str| exid_fuzz::is_sound(mdh::parse(text, Path::new("robot"))));
