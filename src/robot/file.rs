//! Reads the text of a robot file.

use crate::fault::Place;
use crate::robot::error::{RobotError, RobotErrorKind};
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

/// Largest robot description, bytes: the largest URDF in public use stay below a tenth of it.
const SIZE_LIMIT: u64 = 64 << 20;

/// The whole text of a robot file.
pub(crate) fn text(path: &Path) -> Result<String, RobotError> {
    let fail = |kind| RobotError::new(Place::file(path), kind);
    let unreadable = |e: std::io::Error| match e.kind() {
        ErrorKind::NotFound => fail(RobotErrorKind::NotFound),
        ErrorKind::InvalidData => fail(RobotErrorKind::NotText),
        _ => fail(RobotErrorKind::NotReadable {
            reason: e.to_string(),
        }),
    };
    let metadata = fs::metadata(path).map_err(unreadable)?;
    if metadata.is_dir() {
        return Err(fail(RobotErrorKind::IsDirectory));
    }
    if metadata.len() > SIZE_LIMIT {
        return Err(fail(RobotErrorKind::TooLarge {
            bytes: metadata.len(),
            limit: SIZE_LIMIT,
        }));
    }
    let text = fs::read_to_string(path).map_err(unreadable)?;
    if text.trim().is_empty() {
        return Err(fail(RobotErrorKind::Empty));
    }
    Ok(text)
}
