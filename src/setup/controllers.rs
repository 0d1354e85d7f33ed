//! Position controllers of a problem file, with the gains of the robot file where it says nothing of them.
//!
//! An actuator of the robot file with gear g, force `kp (g q_c − g q) − kv g q̇`, gives the joint `kp g²` and `kv g²`.

use crate::chain::controller::{Controller, Gain};
use crate::chain::model::{Model, Signal};
use crate::chain::prior::Prior;
use crate::problem_file::controller::{Gain as Declared, Gains};
use crate::problem_file::{Located, ProblemFile};
use crate::robot::description::DeclaredServo;
use crate::setup::error::{Mismatch, SetupError};
use crate::setup::purpose::Purpose;
use crate::setup::robot::Robot;
use nalgebra::{DMatrix, DVector};

/// Where an estimate starts of which nothing is known, in SI units: what does not tell the size of a gain keeps it, and
/// every parameter is then a ratio to the gain.
const UNKNOWN: f64 = 1.0;

/// The controllers of all joints, in the order of the tree; `None` where the signal is not their error.
pub(super) fn of_joints(
    problem: &ProblemFile,
    robot: &Robot,
    signal: Signal,
    purpose: Purpose,
) -> Result<Option<Vec<Controller>>, SetupError> {
    if signal != Signal::PositionCommand {
        return Ok(None);
    }
    if robot.mechanism.is_some() {
        let place = match (&problem.recordings, &problem.controller) {
            (Some(recordings), _) => recordings.signal.place.clone(),
            (None, Some(controller)) => controller.place.clone(),
            (None, None) => crate::fault::Place::file(&problem.path),
        };
        let what = "a position command as the signal of a mechanism with closed loops".to_string();
        let instead = "give currents or torques".to_string();
        return Err(SetupError::mismatch(
            &place,
            Mismatch::NotYet { what, instead },
        ));
    }
    let gains = declared(problem, robot)?;
    let gain = |declared: Declared| match declared {
        Declared::Known(value) => Gain::known(value),
        Declared::Uncertain { value, .. } if purpose == Purpose::Simulation => Gain::known(value),
        Declared::Uncertain { value, .. } => Gain::free(value),
        Declared::Estimate => Gain::free(UNKNOWN),
    };
    let of = |gains: &JointGains| Controller {
        kp: gain(gains.kp),
        kd: match gains.kd {
            Declared::Estimate => Gain::free(0.0),
            declared => gain(declared),
        },
    };
    Ok(Some(gains.iter().map(of).collect()))
}

/// What is known of the gains of a joint.
#[derive(Debug, Clone, Copy)]
pub(super) struct JointGains {
    kp: Declared,
    kd: Declared,
}

/// What problem file and robot file say of the gains of every joint.
pub(super) fn declared(
    problem: &ProblemFile,
    robot: &Robot,
) -> Result<Vec<JointGains>, SetupError> {
    let table = problem.controller.as_ref().map(|table| &table.value);
    let listed = |gains: Option<&Located<Gains>>| -> Result<Option<Vec<Declared>>, SetupError> {
        let listed = gains.map(|gains| gains.expand(&robot.order)).transpose()?;
        Ok(listed.map(|listed| robot.to_tree(&listed)))
    };
    let kp = listed(table.and_then(|table| table.kp.as_ref()))?;
    let kd = listed(table.and_then(|table| table.kd.as_ref()))?;
    let of = |joint: usize| {
        let servo = robot.description.drives.get(joint).and_then(|d| d.servo);
        let servo = servo.filter(|servo: &DeclaredServo| servo.kp > 0.0);
        let from_file = |own: fn(&DeclaredServo) -> f64| {
            servo.map_or(Declared::Estimate, |servo| {
                Declared::Known(own(&servo) * servo.gear * servo.gear)
            })
        };
        JointGains {
            kp: kp
                .as_ref()
                .map_or_else(|| from_file(|s| s.kp), |all| all[joint]),
            kd: kd
                .as_ref()
                .map_or_else(|| from_file(|s| s.kv), |all| all[joint]),
        }
    };
    Ok((0..robot.tree.len()).map(of).collect())
}

/// What `[controller]` says of gains that it does not call known.
pub(super) fn prior(gains: &[JointGains], model: &Model) -> Prior {
    let count = model.parameters().len();
    let mut known: Vec<(usize, f64, f64)> = Vec::new();
    if model.signal() == Signal::PositionCommand {
        for (joint, gains) in model.joints().iter().zip(gains) {
            let Some(kp) = joint.controller else { continue };
            for (parameter, gain) in [(kp, gains.kp), (kp + 1, gains.kd)] {
                if let Declared::Uncertain { value, std_dev } = gain {
                    known.push((parameter, value, std_dev));
                }
            }
        }
    }
    let size = known.len();
    let rows = DMatrix::from_fn(size, count, |k, p| f64::from(u8::from(known[k].0 == p)));
    let mean = DVector::from_fn(size, |k, _| known[k].1);
    let covariance = DMatrix::from_fn(size, size, |i, j| match i == j {
        true => known[i].2.powi(2),
        false => 0.0,
    });
    Prior::new(&rows, &mean, &covariance)
}
