//! Numbers in few characters: 16-bit steps between the least and the greatest value, or 32-bit floats, in base 64.
//!
//! y ≈ low + step·k with k = 0 .. [`STEPS`] and step = (high − low) / STEPS, so that no value is off by more than step / 2: 8e-6 of
//! the range, a hundredth of a pixel.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;

/// The greatest number of a step; the one above it stands for a value that is not finite.
const STEPS: u16 = u16::MAX - 1;
const ABSENT: u16 = u16::MAX;

/// Values in steps of their range.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Quantised {
    low: f64,
    step: f64,
    /// Little-endian 16-bit numbers in base 64.
    data: String,
}

impl Quantised {
    pub fn of(values: &[f64]) -> Self {
        let finite = || values.iter().copied().filter(|value| value.is_finite());
        let low = finite().fold(f64::INFINITY, f64::min);
        let high = finite().fold(f64::NEG_INFINITY, f64::max);
        let (low, step) = match low < high {
            // Half the range does not overflow where the range does.
            true => (low, (0.5 * high - 0.5 * low) / f64::from(STEPS / 2)),
            false if low.is_finite() => (low, 0.0),
            false => (0.0, 0.0),
        };
        let number = |value: f64| match value.is_finite() {
            true if step > 0.0 => ((value - low) / step).round().min(f64::from(STEPS)) as u16,
            true => 0,
            false => ABSENT,
        };
        let bytes: Vec<u8> = values
            .iter()
            .flat_map(|&value| number(value).to_le_bytes())
            .collect();
        Self {
            low,
            step,
            data: STANDARD.encode(bytes),
        }
    }
}

/// Values as 32-bit floats, little-endian, in base 64.
pub(super) fn floats(values: impl Iterator<Item = f64>) -> String {
    let bytes: Vec<u8> = values.flat_map(|v| (v as f32).to_le_bytes()).collect();
    STANDARD.encode(bytes)
}

/// Shares from −1 to 1 in hundredths, as bytes in base 64.
pub(super) fn hundredths(shares: impl Iterator<Item = f64>) -> String {
    let bytes: Vec<u8> = shares
        .map(|share| (100.0 * share).round() as i8 as u8)
        .collect();
    STANDARD.encode(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(q: &Quantised) -> Vec<f64> {
        let bytes = STANDARD.decode(&q.data).unwrap();
        let numbers = bytes.chunks(2).map(|b| u16::from_le_bytes([b[0], b[1]]));
        numbers
            .map(|k| match k {
                ABSENT => f64::NAN,
                k => q.low + q.step * f64::from(k),
            })
            .collect()
    }

    #[test]
    fn invariant_no_value_is_off_by_more_than_half_a_step() {
        let values: Vec<f64> = (0..1000)
            .map(|k| 7.0 + (0.1 * f64::from(k)).sin())
            .collect();
        let quantised = Quantised::of(&values);
        assert!(quantised.step < 2.0 / 65_000.0);
        for (value, read) in values.iter().zip(decoded(&quantised)) {
            assert!((value - read).abs() <= 0.500_001 * quantised.step);
        }
    }

    #[test]
    fn gaps_constants_and_extremes_survive() {
        let read = decoded(&Quantised::of(&[1.0, f64::NAN, 3.0]));
        assert!((read[0], read[2]) == (1.0, 3.0) && read[1].is_nan());
        assert_eq!(decoded(&Quantised::of(&[2.5, 2.5])), [2.5, 2.5]);
        assert!(decoded(&Quantised::of(&[f64::NAN]))[0].is_nan());
        let wide = Quantised::of(&[-1e308, 1e308]);
        assert!(wide.step.is_finite());
    }
}
