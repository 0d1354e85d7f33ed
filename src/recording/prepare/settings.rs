//! What a caller may say about a recording: its rate, its period, and how to differentiate it.

use crate::fault::Place;
use crate::recording::channels::samples::Recording;
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::time_base::timing::Timing;

/// How the position gives velocity and acceleration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Fourier series of the period average.
    Fourier,
    /// Fixed-interval smoother, whose bandwidth follows from the noise and the motion.
    Smoother,
    /// Zero-phase low-pass of the motion, then central differences.
    Lowpass,
}

/// Settings of the differentiation.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Differentiation {
    /// None: Fourier where there is a period, else the smoother.
    pub method: Option<Method>,
    /// Hz; None: chosen from the data.
    pub cutoff_hz: Option<f64>,
    /// Hz; a low-pass on the signal and on every column of the model.
    pub parallel_hz: Option<f64>,
    /// What the data of all recordings together choose.
    pub in_common: InCommon,
}

/// What smoothers of all recordings of a robot have in common.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct InCommon {
    /// Hz; in the place of the bandwidth that one recording shows.
    pub cutoff_hz: Option<f64>,
    /// About reversals.
    pub width: Width,
}

/// How wide the band of a smoother is about reversals.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Width {
    /// As elsewhere.
    #[default]
    Even,
    /// Wider, where positions show it.
    WiderAboutReversals,
}

/// What is known of a recording besides its file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Preparation {
    /// Hz; needed where the file has no time stamps.
    pub rate: Option<f64>,
    /// s; None: found in the motion, if it repeats and the method is not the low-pass.
    pub period: Option<f64>,
    /// How positions give velocities and accelerations.
    pub differentiation: Differentiation,
}

impl Preparation {
    /// Checks every setting against the time base found.
    pub(super) fn validate(
        &self,
        recording: &Recording,
        timing: &Timing,
    ) -> Result<(), RecordingError> {
        let place = || Place::file(&recording.file);
        let nyquist = 0.5 * timing.rate_hz;
        let settings = &self.differentiation;
        let limits = [
            ("period", self.period, f64::INFINITY, "s"),
            ("cutoff_hz", settings.cutoff_hz, nyquist, "Hz"),
            ("parallel_hz", settings.parallel_hz, nyquist, "Hz"),
        ];
        for (key, value, limit, unit) in limits {
            if let Some(value) = value.filter(|value| !(*value > 0.0 && *value < limit)) {
                let requirement = format!("above 0 and below {limit:.6} {unit}");
                let kind = RecordingErrorKind::InvalidSetting { value, requirement };
                return Err(RecordingError::new(place().key(key), kind));
            }
        }
        Ok(())
    }
}
