//! A number held between two ends.

/// The value, or the end that it lies beyond; a value that is not a number stays one. Unlike `f64::clamp` it has an answer
/// whatever the ends are: one that is not a number is none, and of ends in the wrong order the upper one holds.
pub fn within(value: f64, [lower, upper]: [f64; 2]) -> f64 {
    match value.is_nan() {
        true => value,
        false => value.max(lower).min(upper),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_the_ends_there_is_an_answer() {
        for (value, ends, answer) in [
            (0.5, [0.0, 1.0], 0.5),
            (-0.5, [0.0, 1.0], 0.0),
            (f64::INFINITY, [0.0, 1.0], 1.0),
            (0.5, [0.0, f64::NAN], 0.5),
            (-0.5, [f64::NAN, f64::NAN], -0.5),
            (0.5, [1.0, 0.0], 0.0),
        ] {
            assert_eq!(within(value, ends), answer);
        }
        assert!(within(f64::NAN, [0.0, 1.0]).is_nan());
    }
}
