//! Contact of an elastic gear with play: the torque that it transmits over its twist.
//!
//! ```text
//! c = K (δ ∓ gap/2) + D δ̇  where |δ| > gap/2, else 0
//! ```
//!
//! δ is the way by which the link lags behind the motor.

use crate::chain::effect::flank;
use crate::chain::model::JointModel;
use nalgebra::DVector;

/// The flanks of a gear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flank {
    /// N·m/rad (N/m).
    pub stiffness: f64,
    /// N·m·s/rad (N·s/m).
    pub damping: f64,
    /// Half of the play, rad (m).
    pub half_gap: f64,
}

/// c and its derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// c, N·m (N).
    pub torque: f64,
    /// ∂c/∂δ, N·m/rad (N/m).
    pub by_lag: f64,
    /// ∂c/∂δ̇, N·m·s/rad (N·s/m).
    pub by_rate: f64,
    /// ∂c/∂K, ∂c/∂D, ∂c/∂gap.
    pub by_parameters: [f64; 3],
}

impl Flank {
    /// Of a joint at parameter values; `None` where its link does not lag.
    pub fn of_joint(joint: &JointModel, values: &DVector<f64>) -> Option<Self> {
        let elastic = joint.elasticity.map(|at| [values[at], values[at + 1]]);
        let gap = joint.play.map(|at| values[at]);
        if elastic.is_none() && gap.is_none() {
            return None;
        }
        let [stiffness, damping] = elastic.unwrap_or([flank::STIFFNESS, flank::DAMPING]);
        Some(Self {
            stiffness,
            damping,
            half_gap: 0.5 * gap.unwrap_or(0.0),
        })
    }

    /// `c = K z + D z′ δ̇` with the smooth dead zone
    /// `z = ½(δ − g + s₋) − ½(−δ − g + s₊)`, `s∓ = √((δ ∓ g)² + ε²)`, g half the play: δ itself for g = 0.
    pub fn contact(&self, lag: f64, rate: f64) -> Contact {
        let g = self.half_gap;
        let (near, far) = (lag - g, lag + g);
        let root = |x: f64| (x * x + flank::WIDTH * flank::WIDTH).sqrt();
        let (s, r) = (root(near), root(far));
        let (near_share, far_share) = (near / s, far / r);
        let (near_bend, far_bend) = (
            flank::WIDTH.powi(2) / s.powi(3),
            flank::WIDTH.powi(2) / r.powi(3),
        );
        let stretch = 0.5 * (near + s) + 0.5 * (far - r);
        let slope = 1.0 + 0.5 * (near_share - far_share);
        let bend = 0.5 * (near_bend - far_bend);
        let by_half_gap = -0.5 * (near_share + far_share);
        let slope_by_half_gap = -0.5 * (near_bend + far_bend);
        Contact {
            torque: self.stiffness * stretch + self.damping * slope * rate,
            by_lag: self.stiffness * slope + self.damping * bend * rate,
            by_rate: self.damping * slope,
            by_parameters: [
                stretch,
                slope * rate,
                0.5 * (self.stiffness * by_half_gap + self.damping * slope_by_half_gap * rate),
            ],
        }
    }
}
