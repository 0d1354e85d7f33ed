//! A finding about a file, or about one channel or element of it.

use crate::fault::{Description, Place};
use crate::outcome::check::{Mistake, Severity};

/// A finding about a file, or about one channel or element of it.
pub(super) fn finding(severity: Severity, place: Place, description: Description) -> Mistake {
    let Description {
        code,
        message,
        remedy,
    } = description;
    Mistake {
        code: code.to_string(),
        severity,
        file: Some(place.file.display().to_string()),
        channel: place.key,
        message,
        remedy,
        line: place.line,
    }
}
