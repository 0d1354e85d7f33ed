//! The resolution of a channel in its file: decimals, or significant digits.
//!
//! A number x with s digits stands for all numbers within half a unit u = 10^(⌊log₁₀|x|⌋ + 1 − s) of it; with d decimals
//! within half of 10^−d.

/// Numbers of a channel that are looked at: one in fifty with fewer digits than the rest hides none.
const SAMPLE: usize = 300;

/// Digits of a number in double precision; what has as many was rounded by nobody.
const ALL_DIGITS: i32 = 15;

/// Last place of a number in single precision, as a share of it.
const SINGLE: f64 = 1.2e-7;

/// The format of a channel's numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NumberFormat {
    decimals: i32,
    digits: i32,
    single: bool,
}

impl NumberFormat {
    pub fn of(series: &[f64]) -> Self {
        let stride = series.len().div_ceil(SAMPLE).max(1);
        let mut found = Self {
            decimals: 0,
            digits: 0,
            single: true,
        };
        for &x in series.iter().step_by(stride).filter(|x| **x != 0.0) {
            found.single &= f64::from(x as f32) == x;
            let (digits, exponent) = digits_of(x);
            found.digits = found.digits.max(digits);
            found.decimals = found.decimals.max(digits - 1 - exponent);
        }
        found
    }

    /// Unit of the last place of a number, in the unit of the channel.
    pub fn unit(&self, x: f64) -> f64 {
        if self.digits > ALL_DIGITS {
            return if self.single { SINGLE * x.abs() } else { 0.0 };
        }
        let of_digits = match x == 0.0 {
            true => 0.0,
            false => 10f64.powi(x.abs().log10().floor() as i32 + 1 - self.digits),
        };
        of_digits.max(10f64.powi(-self.decimals))
    }
}

/// Digits of the shortest decimal that reads as this number, and the exponent of the first.
fn digits_of(x: f64) -> (i32, i32) {
    let text = format!("{x:e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let digits = mantissa.bytes().filter(u8::is_ascii_digit).count();
    (digits as i32, exponent.parse().unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matches_the_format_that_numbers_were_written_in() {
        let series: Vec<f64> = (1..2000).map(|k| 3.0 * (0.1 * k as f64).sin()).collect();
        let read = |text: String| text.parse::<f64>().unwrap();
        let fixed: Vec<f64> = series.iter().map(|x| read(format!("{x:.4}"))).collect();
        let digits: Vec<f64> = series.iter().map(|x| read(format!("{x:.5e}"))).collect();
        let single: Vec<f64> = series.iter().map(|x| f64::from(*x as f32)).collect();
        assert!((NumberFormat::of(&fixed).unit(0.02) / 1e-4 - 1.0).abs() < 1e-9);
        assert!((NumberFormat::of(&digits).unit(2.5) / 1e-5 - 1.0).abs() < 1e-9);
        assert_eq!(NumberFormat::of(&series).unit(2.0), 0.0);
        assert_eq!(NumberFormat::of(&single).unit(2.0), 2.0 * SINGLE);
    }
}
