//! The rounded-off sign of a speed, `sign(v) = v/(|v| + w)`, w the transition speed of a joint.

/// `sign(v) = v/(|v| + w)`, 0 at standstill; with w = 0 the sign of v.
#[inline]
pub fn sign(velocity: f64, width: f64) -> f64 {
    if velocity == 0.0 {
        0.0
    } else {
        velocity / (velocity.abs() + width)
    }
}

/// `∂sign/∂w = −v/(|v| + w)²`.
#[inline]
pub fn sign_by_width(velocity: f64, width: f64) -> f64 {
    if velocity == 0.0 {
        0.0
    } else {
        -velocity / (velocity.abs() + width).powi(2)
    }
}

/// `∂sign/∂v = w/(|v| + w)²`; 0 where the sign jumps.
#[inline]
pub fn sign_by_velocity(velocity: f64, width: f64) -> f64 {
    let beyond = velocity.abs() + width;
    if beyond == 0.0 {
        0.0
    } else {
        width / (beyond * beyond)
    }
}
