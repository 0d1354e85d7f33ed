//! What position controllers are told.

/// What a position controller is told.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Told {
    /// Position of the motor at joint scale, rad (m).
    pub position: f64,
    /// Its speed, rad/s (m/s).
    pub velocity: f64,
    /// Torque that is fed forward, N·m (N).
    pub feed_forward: f64,
}
