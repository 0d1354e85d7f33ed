//! Usual column names where the problem file gives none: `{joint}` stands for the name of a joint, `{n}` for
//! its number from 1. Earlier ones win.

pub(in crate::recording) const TIME: &[&str] = &["t", "time"];
pub(in crate::recording) const POSITION: &[&str] = &[
    "q_{joint}",
    "{joint}_position",
    "position_{joint}",
    "{joint}_q",
    "q{n}",
    "q_{n}",
    "position{n}",
    "position_{n}",
];
pub(in crate::recording) const VELOCITY: &[&str] = &[
    "dq_{joint}",
    "{joint}_velocity",
    "velocity_{joint}",
    "dq{n}",
    "dq_{n}",
    "velocity{n}",
    "velocity_{n}",
];
pub(in crate::recording) const ACCELERATION: &[&str] = &[
    "ddq_{joint}",
    "{joint}_acceleration",
    "acceleration_{joint}",
    "ddq{n}",
    "ddq_{n}",
    "acceleration{n}",
    "acceleration_{n}",
];
pub(in crate::recording) const CURRENT: &[&str] = &[
    "i_{joint}",
    "{joint}_current",
    "current_{joint}",
    "i{n}",
    "i_{n}",
    "current{n}",
    "current_{n}",
    // Joint states have one field for both: the signal of the problem says which it is.
    "effort_{joint}",
];
pub(in crate::recording) const TORQUE: &[&str] = &[
    "tau_{joint}",
    "{joint}_torque",
    "torque_{joint}",
    "{joint}_effort",
    "effort_{joint}",
    "tau{n}",
    "tau_{n}",
    "torque{n}",
    "torque_{n}",
];
pub(in crate::recording) const COMMAND: &[&str] = &[
    "command_{joint}",
    "{joint}_command",
    "q_cmd_{joint}",
    "q_command_{joint}",
    "command{n}",
    "command_{n}",
    "q_cmd{n}",
    "q_cmd_{n}",
];
pub(in crate::recording) const VELOCITY_COMMAND: &[&str] = &[
    "velocity_command_{joint}",
    "{joint}_velocity_command",
    "dq_cmd_{joint}",
    "dq_cmd{n}",
    "dq_cmd_{n}",
];
pub(in crate::recording) const FEED_FORWARD: &[&str] = &[
    "feed_forward_{joint}",
    "{joint}_feed_forward",
    "tau_ff_{joint}",
    "tau_ff{n}",
    "tau_ff_{n}",
];
pub(in crate::recording) const TEMPERATURE: &[&str] = &[
    "temp_{joint}",
    "{joint}_temperature",
    "temperature_{joint}",
    "temp{n}",
    "temp_{n}",
    "temperature{n}",
];
pub(super) const WRENCH: [&str; 6] = ["fx", "fy", "fz", "mx", "my", "mz"];
