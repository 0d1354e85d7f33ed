//! Low-passes of given cut-offs, with errors that name the setting.

use std::path::Path;

use crate::fault::Place;
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::prepare::settings::Preparation;
use crate::recording::series::zero_phase::ZeroPhase;

/// The parallel filter asked for.
pub(super) fn parallel(
    file: &Path,
    preparation: &Preparation,
    rate_hz: f64,
) -> Result<Option<ZeroPhase>, RecordingError> {
    match preparation.differentiation.parallel_hz {
        Some(cutoff) => filter(file, cutoff, rate_hz, "parallel_hz").map(Some),
        None => Ok(None),
    }
}

/// A low-pass whose cut-off is the setting `key`.
pub(in crate::recording) fn filter(
    file: &Path,
    cutoff_hz: f64,
    rate_hz: f64,
    key: &str,
) -> Result<ZeroPhase, RecordingError> {
    ZeroPhase::new(cutoff_hz, rate_hz).map_err(|wrong| {
        let kind = RecordingErrorKind::InvalidSetting {
            value: wrong.cutoff_hz,
            requirement: format!("above 0 and below {:.6} Hz", 0.5 * wrong.rate_hz),
        };
        RecordingError::new(Place::file(file).key(key), kind)
    })
}
