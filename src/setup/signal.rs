//! The kind of signal of a problem.

use crate::chain::model;
use crate::problem_file::ProblemFile;
use crate::problem_file::choices::Signal;
use crate::setup::purpose::Purpose;

/// The signal that a problem file speaks of; without recordings, the one that its drives lead to.
pub(super) fn signal(problem: &ProblemFile, purpose: Purpose) -> model::Signal {
    let Some(recordings) = &problem.recordings else {
        let has_constants =
            problem.drive.current_law.is_some() || purpose == Purpose::TorqueConstants;
        return match problem.controller {
            Some(_) => model::Signal::PositionCommand,
            None if has_constants => model::Signal::Current,
            None => model::Signal::Torque,
        };
    };
    match recordings.signal.value {
        Signal::Current => model::Signal::Current,
        Signal::Torque | Signal::MotorTorque => model::Signal::Torque,
        Signal::LinkTorque => model::Signal::LinkTorque,
        Signal::BaseWrench => model::Signal::BaseWrench,
        Signal::Both => model::Signal::Both,
        Signal::PositionCommand => model::Signal::PositionCommand,
    }
}
