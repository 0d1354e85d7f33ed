//! What a page explores, by recording and joint: lines, clouds, spectra and correlations, as the script reads them.

use serde::Serialize;

use crate::report::explore::encoded::Quantised;
use crate::report::explore::posture::Postures;

/// Most recordings of a page.
pub(in crate::report) const RECORDINGS: usize = 8;

/// One recording, trajectory or window.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Take {
    pub name: String,
    /// Such as `held out`.
    pub kind: String,
    /// s, from which times count.
    pub start: f64,
    /// s since the start, 32-bit floats.
    pub t: String,
    pub channels: Vec<Channel>,
    pub postures: Option<Postures>,
}

/// What belongs to one joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Channel {
    pub name: String,
    pub lines: Vec<Line>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud: Option<Cloud>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spectrum: Option<Spectra>,
}

/// A line over the times of its take.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Line {
    /// The plot in which it stands, such as `residual`.
    pub panel: &'static str,
    /// Whose it is, such as `recorded` or `final`.
    pub role: &'static str,
    pub unit: String,
    pub y: Quantised,
    /// Limits, drawn as levels; empty where there are none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub levels: Vec<f64>,
}

/// Single samples, not in the order of time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Cloud {
    /// The variables that a residual may depend on.
    pub over: Vec<Variable>,
    /// Recorded minus what a model gives, and what the found effects add.
    pub of: Vec<Variable>,
    pub unit: String,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Variable {
    pub name: &'static str,
    pub unit: String,
    pub values: Quantised,
}

/// Amplitude spectral densities on common frequencies.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Spectra {
    /// Hz, 32-bit floats.
    pub f: String,
    pub unit: String,
    pub lines: Vec<Density>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Density {
    pub role: &'static str,
    /// 32-bit floats: the range spans powers of ten.
    pub y: String,
}

/// Correlations of parameters: names, and the rows of the matrix in hundredths.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Correlations {
    pub names: Vec<String>,
    pub rows: String,
}
