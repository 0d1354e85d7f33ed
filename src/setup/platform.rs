//! The force platform and the rotors of a problem file.

use crate::chain::model::Model;
use crate::chain::platform::{Platform, Rotor};
use crate::problem_file::drive::RotorTable;
use crate::problem_file::{Named, ProblemFile};
use crate::setup::error::{Mismatch, SetupError, unknown};
use crate::setup::robot::Robot;
use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion, Vector3};

/// A platform, and whether its tare is unknown.
#[derive(Debug, Clone)]
pub(super) struct PlatformSpec {
    platform: Platform,
    tare: bool,
}

impl PlatformSpec {
    /// The platform of a problem file.
    ///
    /// # Errors
    /// A rotor of an unknown joint or on an unknown link, or without `drive.ratio`.
    pub(super) fn of(problem: &ProblemFile, robot: &Robot) -> Result<Self, SetupError> {
        let mut platform = Platform::default();
        for rotor in &problem.drive.rotors {
            platform.rotors.push(spinning(rotor, robot)?);
        }
        let table = problem
            .recordings
            .as_ref()
            .and_then(|r| r.platform.as_ref());
        if let Some(table) = table {
            let [roll, pitch, yaw] = table.rotation;
            let turn = Rotation3::from_euler_angles(roll, pitch, yaw);
            let frame = Isometry3::from_parts(
                Translation3::from(Vector3::from(table.translation)),
                UnitQuaternion::from_rotation_matrix(&turn),
            );
            platform.transfer = Platform::transfer_to(&frame);
            platform.accuracy = table.accuracy;
        }
        Ok(Self {
            platform,
            tare: table.is_some_and(|table| table.tare),
        })
    }

    /// Gives a model the platform, and the tare as unknowns if it asks for them.
    pub(super) fn apply(&self, model: &mut Model) {
        model.stand_on(self.platform.clone());
        if self.tare {
            model.add_tare();
        }
    }
}

fn spinning(entry: &Named<RotorTable>, robot: &Robot) -> Result<Rotor, SetupError> {
    let (table, place) = (&entry.value.value, &entry.value.place);
    let Some(joint) = robot.tree.joint_index(&entry.name) else {
        return Err(unknown(place, &entry.name, &robot.order));
    };
    let Some(ratio) = &robot.ratio else {
        return Err(SetupError::mismatch(place, Mismatch::NeedsRatio));
    };
    let Some((carrier, frame)) = robot.tree.frame(&table.link) else {
        return Err(SetupError::mismatch(
            place,
            Mismatch::UnknownFrame {
                found: table.link.clone(),
                known: robot.frame_names(),
            },
        ));
    };
    let axis = Vector3::from(table.axis);
    Ok(Rotor {
        joint,
        carrier,
        axis: frame.rotation * (axis / axis.norm()),
        momentum: table.inertia * ratio[joint],
    })
}
