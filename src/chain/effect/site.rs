//! The joint at which a trial conceals an effect, with the figures that sizes are shares of.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// A joint of a robot, N·m (N), rad (m), rad/s (m/s), kg·m² (kg).
#[derive(Debug, Clone, Copy)]
pub struct Site {
    /// Size of the effect as a share of the usual torque.
    pub share: f64,
    /// What the joint usually bears.
    pub usual_torque: f64,
    /// Of the declared dry friction.
    pub dry_friction: f64,
    /// The joint's greatest speed.
    pub fastest: f64,
    /// Of the range of positions.
    pub middle: f64,
    /// Half of the range of positions.
    pub half_range: f64,
    /// What the motor moves, at joint scale.
    pub inertia: f64,
    /// Mass of the joint's link, kg.
    pub link_mass: f64,
    /// N·m/A (N/A).
    pub torque_constant: f64,
    /// Of a recording, s.
    pub duration: f64,
}

impl Site {
    /// Torque of the effect.
    pub fn torque(&self) -> f64 {
        self.share * self.usual_torque
    }
}

/// 1 or −1, either as likely.
pub fn either_sign(rng: &mut ChaCha8Rng) -> f64 {
    if rng.random::<bool>() { 1.0 } else { -1.0 }
}
