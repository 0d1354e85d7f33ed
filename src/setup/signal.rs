//! The kind of signal of a problem.

use crate::chain::model;
use crate::problem_file::ProblemFile;
use crate::problem_file::choices::Signal;
use crate::setup::error::SetupError;

pub(super) fn signal(problem: &ProblemFile) -> Result<model::Signal, SetupError> {
    let Some(recordings) = &problem.recordings else {
        return Ok(match problem.drive.current_law {
            _ if problem.controller.is_some() => model::Signal::PositionCommand,
            Some(_) => model::Signal::Current,
            None => model::Signal::Torque,
        });
    };
    Ok(match recordings.signal.value {
        Signal::Current => model::Signal::Current,
        Signal::Torque | Signal::MotorTorque => model::Signal::Torque,
        Signal::LinkTorque => model::Signal::LinkTorque,
        Signal::BaseWrench => model::Signal::BaseWrench,
        Signal::Both => model::Signal::Both,
        Signal::PositionCommand => model::Signal::PositionCommand,
    })
}
