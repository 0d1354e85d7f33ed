//! The restoring torque of a link that lags its motor by δ: the spring of an elastic gear, and the flanks of teeth with backlash.
//!
//! ```text
//! c = K z + D z′ δ̇,   z = ½(δ − g + s₋) − ½(−δ − g + s₊),   s∓ = √((δ ∓ g)² + ε²)
//! ```
//!
//! with g half the play: a smooth dead zone, δ itself for g = 0.

use crate::chain::effect::expression::{Expression, Function, Variable};

/// Stiffness of the flanks where only play is in the model, N·m/rad or N/m: links of robots swing on it
/// above 20 Hz, and a usual load bends it by less than a tenth of a usual play.
pub const STIFFNESS: f64 = 1e6;

/// Damping of the flanks, N·m·s/rad or N·s/m: about critical for a link of 1 kg·m².
pub const DAMPING: f64 = 1e3;

/// Width ε over which a flank comes into contact, rad or m: a small part of any play that matters.
pub const WIDTH: f64 = 1e-4;

/// c, with K, D and g as the parameters 0, 1 and 2.
pub fn torque() -> Expression {
    let [stiffness, damping, half_gap] = [0, 1, 2].map(Expression::parameter);
    let lag = || Expression::from(Variable::Lag);
    let (near, far) = (lag() - half_gap.clone(), lag() + half_gap);
    let root = |x: &Expression| (x.clone().squared() + WIDTH * WIDTH).call(Function::SquareRoot);
    let (s, r) = (root(&near), root(&far));
    let stretch = (near.clone() + s.clone()) * 0.5 + (far.clone() - r.clone()) * 0.5;
    let slope = (near / s - far / r) * 0.5 + 1.0;
    stiffness * stretch + damping * slope * Variable::LagRate
}
