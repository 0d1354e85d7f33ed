//! Any bytes as a MATLAB file.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| exid_fuzz::recording::is_sound(".mat", bytes));
