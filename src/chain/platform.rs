//! A force platform under the base: what its sensor reads of the reaction of the base on the robot.
//!
//! ```text
//! s = T (Y_b(q, q̇, q̈) π + Σ rotors d/dt (J r ṁ R a)) + tare
//! ```
//!
//! T takes force and moment about the origin of the base frame to the axes and origin of the sensor's frame;
//! J is a rotor's own inertia, r its turns per joint turn, R a its axis, which its carrier turns (Raucent,
//! Campion, Bastin, Samin and Willems 1992, section 4: the term n·q̈·J^m of the R-model). A carrier's mass and inertia contain the rotor at rest.

use crate::robot::batch::Trajectory;
use crate::robot::tree::{JointKind, Tree};
use nalgebra::{Isometry3, Matrix3, Matrix6, Rotation3, Vector3};
use std::ops::Range;

/// A motor's spinning part, fixed to a link but for its spin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rotor {
    /// The motor, by its joint.
    pub joint: usize,
    /// The joint whose link carries it; `None` for the base.
    pub carrier: Option<usize>,
    /// Unit vector in the carrier's frame.
    pub axis: Vector3<f64>,
    /// J·r, kg·m²: angular momentum per joint-scale speed of the motor.
    pub momentum: f64,
}

/// Sensor and rotors; the default reads in the base frame and knows no rotors.
#[derive(Debug, Clone, PartialEq)]
pub struct Platform {
    /// T.
    pub transfer: Matrix6<f64>,
    /// What spins on the links, and adds its angular momentum to the base wrench.
    pub rotors: Vec<Rotor>,
    /// Standard deviation of a sample as share of each channel's root mean square, if the sensor's maker
    /// states it.
    pub accuracy: Option<f64>,
}

impl Default for Platform {
    fn default() -> Self {
        Self {
            transfer: Matrix6::identity(),
            rotors: Vec::new(),
            accuracy: None,
        }
    }
}

impl Platform {
    /// T of a sensor whose frame stands at `frame` in the base frame.
    pub fn transfer_to(frame: &Isometry3<f64>) -> Matrix6<f64> {
        let turn: Matrix3<f64> = frame.rotation.to_rotation_matrix().matrix().transpose();
        let shift = frame.translation.vector.cross_matrix();
        let mut transfer = Matrix6::zeros();
        transfer.fixed_view_mut::<3, 3>(0, 0).copy_from(&turn);
        transfer.fixed_view_mut::<3, 3>(3, 3).copy_from(&turn);
        transfer
            .fixed_view_mut::<3, 3>(3, 0)
            .copy_from(&(-turn * shift));
        transfer
    }

    /// Adds the moments of the spinning rotors, base frame, to the last three series of `wrench`: over a range of the
    /// motors' samples, the first of which is the joints' first.
    pub fn add_rotors(
        &self,
        tree: &Tree,
        motors: Trajectory<'_>,
        joints: Trajectory<'_>,
        range: Range<usize>,
        wrench: &mut [Vec<f64>],
    ) {
        for (sample, at) in range.enumerate() {
            let links = turning(tree, joints, sample);
            for rotor in &self.rotors {
                let rest = (Rotation3::identity(), Vector3::zeros());
                let (rotation, spin) = rotor.carrier.map_or(rest, |k| links[k]);
                let axis = rotation * rotor.axis;
                let (speed, rate) = (motors.dq[rotor.joint][at], motors.ddq[rotor.joint][at]);
                let moment = (axis * rate + spin.cross(&axis) * speed) * rotor.momentum;
                for (series, component) in wrench[3..].iter_mut().zip(moment.iter()) {
                    series[sample] += component;
                }
            }
        }
    }
}

/// Rotation and angular velocity of every link in the base frame.
fn turning(
    tree: &Tree,
    joints: Trajectory<'_>,
    sample: usize,
) -> Vec<(Rotation3<f64>, Vector3<f64>)> {
    let mut links: Vec<(Rotation3<f64>, Vector3<f64>)> = Vec::with_capacity(tree.len());
    for (k, joint) in tree.joints().iter().enumerate() {
        let rest = (Rotation3::identity(), Vector3::zeros());
        let (rotation, spin) = joint.parent.map_or(rest, |p| links[p]);
        let fixed = rotation * joint.rotation;
        links.push(match joint.kind {
            JointKind::Prismatic => (fixed, spin),
            JointKind::Revolute => {
                let turned = fixed * Rotation3::new(joint.axis * joints.q[k][sample]);
                (turned, spin + turned * joint.axis * joints.dq[k][sample])
            }
        });
    }
    links
}
