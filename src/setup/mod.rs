//! From a problem file to what tasks work on: robot, model, recordings, priors.

pub mod combined_limits;
mod controllers;
pub mod coupling_entry;
pub mod declared;
pub mod error;
pub mod known;
pub mod laws;
pub mod limits;
pub mod loops;
pub mod machine;
pub mod model_spec;
pub mod motor_side;
pub mod names;
pub mod passive_joint_sensors;
mod platform;
pub mod preparation;
mod prior;
mod purpose;
pub mod recording_file;
pub mod recordings;
pub mod robot;
pub mod shared_rows;
pub mod sharing;
mod signal;
pub mod skeleton;
pub mod truth_spec;
pub mod values;
