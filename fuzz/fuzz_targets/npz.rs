//! Any bytes as a NumPy archive.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| exid_fuzz::recording::is_sound(".npz", bytes));
