//! Dates in the place of time stamps.

use chrono::{DateTime, NaiveDateTime};

/// Seconds since 1970 of a date with a time (ISO 8601), which is that of Greenwich where it names no zone. A blank may stand for the
/// T, and a comma for the decimal point.
pub(super) fn seconds(field: &str) -> Option<f64> {
    let is_date = field.as_bytes().get(4) == Some(&b'-') && field.contains(':');
    let field = is_date.then(|| field.replacen(' ', "T", 1).replacen(',', ".", 1))?;
    let zoned = DateTime::parse_from_rfc3339(&field).map(|at| at.to_utc());
    let plain = || field.parse::<NaiveDateTime>().map(|at| at.and_utc());
    let at = zoned.or_else(|_| plain()).ok()?;
    Some(at.timestamp() as f64 + 1e-9 * f64::from(at.timestamp_subsec_nanos()))
}
