//! Errors and notes of the reader, each with its place in the file.

use crate::fault::{Description as Words, Place};
use crate::robot::description::{Note, Weight};
use crate::robot::error::{RobotError, RobotErrorKind};
use crate::robot::mjcf_fault::MjcfFault;

/// An error of the file at a place.
pub(super) fn fail<T>(place: Place, fault: MjcfFault) -> Result<T, RobotError> {
    Err(RobotError::new(place, RobotErrorKind::Mjcf(fault)))
}

/// A note on physics that a joint or the model leaves out.
pub(super) fn note(place: Place, weight: Weight, message: String, remedy: &str) -> Note {
    let code = match weight {
        Weight::Remark => "joint-held-still",
        Weight::LeftOut => "mjcf-left-out",
    };
    Note {
        place,
        words: Words::new(code, message, remedy),
        weight,
    }
}
