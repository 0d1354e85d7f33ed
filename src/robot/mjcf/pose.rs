//! Where an element stands: position, and orientation in one of five ways.
//!
//! `quat` (w x y z), `axisangle`, `euler` in the sequence of the compiler, `xyaxes` (y made orthogonal to x), and `zaxis`:
//! the least turn that brings z there.

use crate::robot::error::RobotError;
use crate::robot::mjcf::compiler::Compiler;
use crate::robot::mjcf::settings::Settings;
use crate::robot::mjcf_fault::MjcfFault;
use nalgebra::{
    Isometry3, Matrix3, Quaternion, Rotation3, Translation3, Unit, UnitQuaternion, Vector3,
};

/// The ways of giving an orientation.
const ORIENTATIONS: [&str; 5] = ["quat", "axisangle", "euler", "xyaxes", "zaxis"];

/// Position and orientation of an element in its parent.
pub fn pose(settings: &Settings<'_>, compiler: &Compiler) -> Result<Isometry3<f64>, RobotError> {
    let position = settings.vector("pos")?.unwrap_or_default();
    let turn = orientation(settings, compiler)?.unwrap_or_default();
    Ok(Isometry3::from_parts(Translation3::from(position), turn))
}

/// The orientation of an element, `None` where it gives none.
pub fn orientation(
    settings: &Settings<'_>,
    compiler: &Compiler,
) -> Result<Option<UnitQuaternion<f64>>, RobotError> {
    let Some((_, ways)) = settings.nearest_of(&ORIENTATIONS) else {
        return Ok(None);
    };
    if let [first, second, ..] = ways[..] {
        let attributes = [first, second];
        return settings.fail(MjcfFault::Orientations { attributes });
    }
    let way = ways[0];
    let numbers = |count: usize| Ok(settings.numbers(way, count..=count)?.unwrap_or_default());
    let direction = |v: Vector3<f64>| match Unit::try_new(v, 0.0) {
        Some(unit) => Ok(unit),
        None => settings.fail(MjcfFault::NoDirection {
            attribute: way.to_string(),
        }),
    };
    let turn = match way {
        "quat" => {
            let q = numbers(4)?;
            let q = Quaternion::new(q[0], q[1], q[2], q[3]);
            if q.norm() == 0.0 {
                let attribute = way.to_string();
                return settings.fail(MjcfFault::NoDirection { attribute });
            }
            UnitQuaternion::from_quaternion(q)
        }
        "axisangle" => {
            let v = numbers(4)?;
            let axis = direction(Vector3::new(v[0], v[1], v[2]))?;
            UnitQuaternion::from_axis_angle(&axis, v[3] * compiler.angle)
        }
        "euler" => {
            let angles = numbers(3)?;
            let mut turn = UnitQuaternion::identity();
            for (axis, angle) in compiler.eulerseq.into_iter().zip(angles) {
                let about = match axis.to_ascii_lowercase() {
                    'x' => Vector3::x_axis(),
                    'y' => Vector3::y_axis(),
                    _ => Vector3::z_axis(),
                };
                let next = UnitQuaternion::from_axis_angle(&about, angle * compiler.angle);
                turn = match axis.is_lowercase() {
                    true => turn * next,
                    false => next * turn,
                };
            }
            turn
        }
        "xyaxes" => {
            let v = numbers(6)?;
            let x = direction(Vector3::new(v[0], v[1], v[2]))?.into_inner();
            let y = Vector3::new(v[3], v[4], v[5]);
            let y = direction(y - x * x.dot(&y))?.into_inner();
            let axes = Matrix3::from_columns(&[x, y, x.cross(&y)]);
            UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes))
        }
        _ => {
            let v = numbers(3)?;
            least_turn(&direction(Vector3::new(v[0], v[1], v[2]))?)
        }
    };
    Ok(Some(turn))
}

/// The least turn from z to a direction; about x where it is −z.
pub fn least_turn(to: &Unit<Vector3<f64>>) -> UnitQuaternion<f64> {
    let half = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    UnitQuaternion::rotation_between(&Vector3::z(), to).unwrap_or(half)
}
