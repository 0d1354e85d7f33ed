//! Any text as a robot file: URDF.
#![no_main]

use exid::robot::urdf;
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|text: &str| exid_fuzz::is_sound(urdf::parse(text, Path::new("robot"))));
