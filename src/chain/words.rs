//! Numbers and lists as parts of a sentence.

/// `joint1`, `joint1 and joint2`, `joint1, joint2 and joint3`.
pub fn list(names: &[String]) -> String {
    match names {
        [] => "the robot".to_string(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// `1 joint`, `6 joints`.
pub fn count(number: usize, noun: &str) -> String {
    match number {
        1 => format!("1 {noun}"),
        _ => format!("{number} {noun}s"),
    }
}

/// Sizes below this, in any unit of a finding, are rounding and nothing else.
const ROUNDING: f64 = 1e-12;

/// Decimal exponents outside of which a number is written with its exponent.
const PLAIN_EXPONENTS: std::ops::Range<i32> = -6..7;

/// Three significant digits: `0.0123`, `-18.9`, `2.50e7`; `0` for what is rounding.
pub fn short(value: f64) -> String {
    if value.abs() < ROUNDING || !value.is_finite() {
        return format!("{}", if value.is_finite() { 0.0 } else { value });
    }
    let exponent = value.abs().log10().floor() as i32;
    if !PLAIN_EXPONENTS.contains(&exponent) {
        return format!("{value:.2e}");
    }
    let digits = (2 - exponent).max(0) as usize;
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_told_in_the_singular() {
        assert_eq!(
            [0, 1, 2].map(|n| count(n, "start")),
            ["0 starts", "1 start", "2 starts"]
        );
    }

    #[test]
    fn numbers_of_sentences_have_three_digits_and_no_endless_zeros() {
        for (value, text) in [
            (0.0, "0"),
            (6e-120, "0"),
            (-6e-120, "0"),
            (0.0123, "0.0123"),
            (-18.91, "-18.9"),
            (1234.5, "1234"),
            (3.0e-8, "3.00e-8"),
            (2.5e7, "2.50e7"),
        ] {
            assert_eq!(short(value), text);
        }
    }
}
