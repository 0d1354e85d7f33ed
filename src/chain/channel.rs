//! Channels of a model: motors' signals and components of a wrench.

/// One measured series.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Name of the joint, or of the component of the wrench.
    pub name: String,
    /// Unit of the signal: A, N·m or N.
    pub unit: &'static str,
    /// Joint of a torque or current; `None` for a component of the wrench.
    pub joint: Option<usize>,
    /// Locked joints and their motors are not predicted.
    pub active: bool,
}

/// Names and units of the components of a wrench.
pub(super) const WRENCH: [(&str, &str); 6] = [
    ("fx", "N"),
    ("fy", "N"),
    ("fz", "N"),
    ("mx", "N·m"),
    ("my", "N·m"),
    ("mz", "N·m"),
];
