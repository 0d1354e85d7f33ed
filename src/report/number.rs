//! Numbers as a reader wants them: four significant digits, exponents only where needed.

/// What stands where there is no number.
pub(super) const ABSENT: &str = "–";

/// Significant digits after the first one.
const FURTHER_DIGITS: i32 = 3;

/// Decimal exponents outside of which a number is written with its exponent: five digits before
/// the point, or three zeros after it, are the most that are read at a glance.
const PLAIN_EXPONENTS: std::ops::Range<i32> = -4..5;

/// Four significant digits: `0.01234`, `12.30`, `1.235e-7`.
pub(super) fn significant(value: f64) -> String {
    if value == 0.0 {
        return "0".to_string();
    }
    if !value.is_finite() {
        return ABSENT.to_string();
    }
    let scientific = format!("{:.*e}", FURTHER_DIGITS as usize, value);
    match scientific.split_once('e').and_then(|(_, e)| e.parse().ok()) {
        Some(exponent) if PLAIN_EXPONENTS.contains(&exponent) => {
            let decimals = (FURTHER_DIGITS - exponent).max(0) as usize;
            format!("{value:.decimals$}")
        }
        _ => scientific,
    }
}

/// As [`significant`], or the sign for an absent number.
pub(super) fn optional(value: Option<f64>) -> String {
    value.map_or_else(|| ABSENT.to_string(), significant)
}

/// A value with its standard deviation, which has two significant digits: `5.012 ± 0.012`, `1.235e-7 ± 2.1e-9`.
pub(super) fn with_deviation(value: f64, std_dev: f64) -> String {
    if !(value.is_finite() && std_dev.abs().log10().is_finite()) {
        return significant(value);
    }
    match decimals(value, std_dev) {
        Some(decimals) => format!("{value:.decimals$} ± {std_dev:.decimals$}"),
        None => format!("{} ± {std_dev:.1e}", significant(value)),
    }
}

/// Both ends of an interval, as exact as the standard deviation behind it: `4.989 to 5.036`.
pub(super) fn interval(ends: [f64; 2], std_dev: f64) -> String {
    let [low, high] = ends.map(|end| match decimals(end, std_dev) {
        Some(decimals) if end.is_finite() => format!("{end:.decimals$}"),
        _ => significant(end),
    });
    format!("{low} to {high}")
}

/// Decimals to which a value is known; absent where it is written with its exponent.
fn decimals(value: f64, std_dev: f64) -> Option<usize> {
    let exponent = std_dev.abs().log10().floor();
    let decimals = (1 - exponent as i32).max(0);
    let plain = |x: f64| x == 0.0 || PLAIN_EXPONENTS.contains(&(x.abs().log10().floor() as i32));
    (plain(value) && decimals <= MOST_DECIMALS).then_some(decimals as usize)
}

/// Decimals that are written out.
const MOST_DECIMALS: i32 = 7;

/// Ticks this much smaller than the range of their axis are zero up to rounding.
const ZERO_OF_RANGE: f64 = 1e-9;

/// For the ticks of an axis over `range`: `0.5`, `-20`, `1e-7`, without trailing zeros.
pub(super) fn tick(value: f64, range: (f64, f64)) -> String {
    if value.abs() <= ZERO_OF_RANGE * (range.1 - range.0) {
        return "0".to_string();
    }
    let text = significant(value);
    let (digits, exponent) = match text.split_once('e') {
        Some((digits, exponent)) => (digits, Some(exponent)),
        None => (text.as_str(), None),
    };
    let digits = if digits.contains('.') {
        digits.trim_end_matches('0').trim_end_matches('.')
    } else {
        digits
    };
    match exponent {
        Some(exponent) => format!("{digits}e{exponent}"),
        None => digits.to_string(),
    }
}

/// Per cent below which a share is next to nothing.
const LEAST_PERCENT: f64 = 0.01;

/// Per cent beyond which a share says no more than that it is beyond.
const MOST_PERCENT: f64 = 1e4;

/// A share as per cent, three significant digits at most: `6.25 %`, `0.04 %`, `140 %`, `under 0.01 %`, `over 10000 %`.
pub(super) fn percent(share: f64) -> String {
    let value = 100.0 * share;
    if !value.is_finite() {
        return ABSENT.to_string();
    }
    if value > MOST_PERCENT {
        return format!("over {MOST_PERCENT} %");
    }
    if value > 0.0 && value < LEAST_PERCENT {
        return format!("under {LEAST_PERCENT} %");
    }
    let decimals = match value.abs() {
        size if size < 10.0 => 2,
        size if size < 100.0 => 1,
        _ => 0,
    };
    format!("{value:.decimals$} %")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_has_the_decimals_of_its_deviation() {
        for (value, std_dev, text) in [
            (5.01234, 0.0123, "5.012 ± 0.012"),
            (310.0, 2.5, "310.0 ± 2.5"),
            (310.4, 25.0, "310 ± 25"),
            (1.2345e-7, 2.1e-9, "1.235e-7 ± 2.1e-9"),
            (0.0, 0.03, "0.000 ± 0.030"),
            (12345.6, 321.0, "12346 ± 321"),
        ] {
            assert_eq!(with_deviation(value, std_dev), text);
        }
    }

    #[test]
    fn keeps_four_significant_digits_at_every_scale() {
        for (value, text) in [
            (0.0, "0"),
            (0.0123449, "0.01234"),
            (-12.3, "-12.30"),
            (9.99996, "10.00"),
            (12345.6, "12346"),
            (99999.4, "1.000e5"),
            (123456.0, "1.235e5"),
            (0.0001, "0.0001000"),
            (0.00001234, "1.234e-5"),
            (f64::NAN, "–"),
            (f64::INFINITY, "–"),
        ] {
            assert_eq!(significant(value), text);
        }
    }

    #[test]
    fn ticks_have_no_trailing_zeros() {
        for (value, text) in [
            (0.30000000000000004, "0.3"),
            (20.0, "20"),
            (-1e-7, "-1e-7"),
            (2.5e6, "2.5e6"),
            (500.0, "500"),
        ] {
            assert_eq!(tick(value, (0.0, value)), text);
        }
        assert_eq!(tick(5.551e-17, (-0.4, 0.4)), "0");
    }

    #[test]
    fn shares_are_per_cent() {
        for (share, text) in [
            (0.0, "0.00 %"),
            (6e-120, "under 0.01 %"),
            (0.0001, "0.01 %"),
            (0.0625, "6.25 %"),
            (0.4567, "45.7 %"),
            (1.4, "140 %"),
            (1e12, "over 10000 %"),
        ] {
            assert_eq!(percent(share), text);
        }
    }
}
