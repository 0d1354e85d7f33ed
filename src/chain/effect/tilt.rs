//! Gravity in a base frame that is turned by roll and pitch.

use nalgebra::{Rotation3, Vector3};

/// Gravity in the tilted base frame.
pub fn tilted(declared: &Vector3<f64>, [roll, pitch]: [f64; 2]) -> Vector3<f64> {
    turn(1, pitch, turn(0, roll, Rotation3::identity())).inverse() * declared
}

/// Derivatives of [`tilted`] with respect to roll and pitch.
pub fn tilted_by_angles(declared: &Vector3<f64>, [roll, pitch]: [f64; 2]) -> [Vector3<f64>; 2] {
    // d(R_xᵀ)/d(roll) = −[x]× R_xᵀ: both factors commute.
    let level = turn(1, pitch, Rotation3::identity()).inverse() * declared;
    let roll_back = turn(0, roll, Rotation3::identity()).inverse();
    let by_roll = -Vector3::x().cross(&(roll_back * level));
    let by_pitch = roll_back * -Vector3::y().cross(&level);
    [by_roll, by_pitch]
}

pub(super) fn turn(axis: usize, angle: f64, first: Rotation3<f64>) -> Rotation3<f64> {
    let axis = match axis {
        0 => Vector3::x_axis(),
        _ => Vector3::y_axis(),
    };
    Rotation3::from_axis_angle(&axis, angle) * first
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matches_differences_in_both_angles() {
        let declared = Vector3::new(0.3, -0.5, -9.7);
        let (at, h) = ([0.2, -0.4], 1e-6);
        let exact = tilted_by_angles(&declared, at);
        for k in 0..2 {
            let moved = |step: f64| {
                let mut angles = at;
                angles[k] += step;
                tilted(&declared, angles)
            };
            let difference = (moved(h) - moved(-h)) / (2.0 * h);
            assert!((difference - exact[k]).norm() < 1e-8);
        }
    }
}
