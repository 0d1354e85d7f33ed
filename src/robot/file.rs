//! Reads the text of a robot file.

use crate::fault::Place;
use crate::robot::error::{RobotError, RobotErrorKind};
use std::fs;
use std::io::{ErrorKind, Read};
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
    let check_size = |bytes: u64| match bytes > SIZE_LIMIT {
        true => Err(fail(RobotErrorKind::TooLarge {
            bytes,
            limit: SIZE_LIMIT,
        })),
        false => Ok(()),
    };
    let metadata = fs::metadata(path).map_err(unreadable)?;
    if metadata.is_dir() {
        return Err(fail(RobotErrorKind::IsDirectory));
    }
    check_size(metadata.len())?;
    let mut text = String::new();
    // A pipe or device states no size: at most the limit is read of it, into memory that is not moved as it grows.
    if !metadata.is_file() {
        text.reserve_exact(SIZE_LIMIT as usize + 1);
    }
    let file = fs::File::open(path).map_err(unreadable)?;
    let mut bounded = file.take(SIZE_LIMIT + 1);
    bounded.read_to_string(&mut text).map_err(unreadable)?;
    check_size(text.len() as u64)?;
    if text.trim().is_empty() {
        return Err(fail(RobotErrorKind::Empty));
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::Fault;

    fn code(path: &Path) -> &'static str {
        text(path).expect_err("not a robot file").describe().code
    }

    #[test]
    fn what_is_no_text_file_is_refused_with_its_code() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, content: &[u8]| {
            let path = folder.path().join(name);
            fs::write(&path, content).unwrap();
            path
        };
        assert_eq!(code(&folder.path().join("none")), "robot-file-not-found");
        assert_eq!(code(folder.path()), "robot-file-is-directory");
        assert_eq!(code(&file("blank", b" \n")), "robot-file-empty");
        assert_eq!(code(&file("binary", &[0xff, 0xfe])), "robot-file-not-text");
        let long = fs::File::create(folder.path().join("long")).unwrap();
        long.set_len(SIZE_LIMIT + 1).unwrap();
        assert_eq!(code(&folder.path().join("long")), "robot-file-too-large");
    }

    #[cfg(unix)]
    #[test]
    fn a_device_without_end_is_refused_at_the_limit() {
        assert_eq!(code(Path::new("/dev/zero")), "robot-file-too-large");
    }
}
