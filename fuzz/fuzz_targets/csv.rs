//! Any bytes as a recording: comma-separated text, read and made ready for a model.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| exid_fuzz::recording::is_sound(".csv", bytes));
