//! Any bytes as a ROS 1 bag.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| exid_fuzz::recording::is_sound(".bag", bytes));
