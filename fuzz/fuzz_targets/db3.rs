//! Any bytes as a ROS 2 bag in an SQLite database.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| exid_fuzz::recording::is_sound(".db3", bytes));
