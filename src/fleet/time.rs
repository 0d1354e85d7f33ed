//! Instants of a manifest: numbers as they are, dates as seconds since 1970-01-01T00:00:00Z.

use toml::value::Datetime;

/// A number, or a date or instant of RFC 3339; without an offset it is UTC. `None` for anything else.
pub fn parse(text: &str) -> Option<f64> {
    let text = text.trim();
    if let Ok(number) = text.parse::<f64>() {
        return Some(number).filter(|n| n.is_finite());
    }
    text.parse().ok().and_then(seconds)
}

/// Seconds since 1970.
pub fn seconds(instant: Datetime) -> Option<f64> {
    let date = instant.date?;
    let days = days_since_1970(
        i64::from(date.year),
        i64::from(date.month),
        i64::from(date.day),
    );
    let mut seconds = 86_400.0 * days as f64;
    if let Some(time) = instant.time {
        seconds += 3600.0 * f64::from(time.hour) + 60.0 * f64::from(time.minute);
        seconds += f64::from(time.second.unwrap_or(0));
        seconds += 1e-9 * f64::from(time.nanosecond.unwrap_or(0));
    }
    if let Some(toml::value::Offset::Custom { minutes }) = instant.offset {
        seconds -= 60.0 * f64::from(minutes);
    }
    Some(seconds)
}

/// Days of the Gregorian calendar, years counted from March on so that the day of a leap year is the last.
fn days_since_1970(year: i64, month: i64, day: i64) -> i64 {
    let shifted = year * 12 + month - 3;
    let (year, month) = (shifted.div_euclid(12), shifted.rem_euclid(12));
    let of_years = 365 * year + year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400);
    of_years + (153 * month + 2) / 5 + day - 1 - 719_468
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of `date -u -d @SECONDS +%FT%TZ` (GNU coreutils).
    #[test]
    fn matches_another_program_s_calendar() {
        for (text, expected) in [
            ("1970-01-01", 0.0),
            ("2000-02-28T23:59:59Z", 951_782_399.0),
            ("2000-02-29T01:00:00+01:00", 951_782_400.0),
            ("2024-02-29 23:59:59.5", 1_709_251_199.5),
            ("2100-03-01T00:00:00Z", 4_107_542_400.0),
            (" 17.5 ", 17.5),
        ] {
            assert_eq!(parse(text), Some(expected), "{text}");
        }
        for text in ["", "yesterday", "2024-13-01", "nan", "12:00:00"] {
            assert_eq!(parse(text), None, "{text}");
        }
    }
}
