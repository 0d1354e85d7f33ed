//! Statistics of errors over windows.

use crate::outcome::rollout::Spread;

/// The spread of errors; one that is not finite is of a window that is lost.
pub fn spread(errors: &[f64]) -> Spread {
    let mut sizes: Vec<f64> = errors
        .iter()
        .map(|e| {
            if e.is_finite() {
                e.abs()
            } else {
                f64::INFINITY
            }
        })
        .collect();
    sizes.sort_by(f64::total_cmp);
    let kept = sizes.partition_point(|size| size.is_finite());
    let squares: f64 = sizes[..kept].iter().map(|size| size * size).sum();
    Spread {
        windows: sizes.len(),
        lost: sizes.len() - kept,
        rms: (kept > 0).then(|| (squares / kept as f64).sqrt()),
        lower_quartile: quantile(&sizes, 0.25),
        median: quantile(&sizes, 0.5),
        upper_quartile: quantile(&sizes, 0.75),
    }
}

/// Between the two sizes about a share of them (Hyndman and Fan 1996, definition 7); `None` where it has no limit.
fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let at = share * sorted.len().checked_sub(1)? as f64;
    let (below, weight) = (at.floor() as usize, at.fract());
    let low = sorted[below];
    let high = if weight > 0.0 { sorted[below + 1] } else { low };
    let value = low + weight * (high - low);
    value.is_finite().then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `numpy.quantile([0.1, 0.2, 0.4, 0.5, 0.9], [0.25, 0.5, 0.75])` is 0.2, 0.4, 0.5, of four values 0.175, 0.3, 0.425.
    #[test]
    fn matches_numpy_quantiles() {
        let five = spread(&[0.5, -0.1, 0.9, -0.2, 0.4]);
        let quantiles = [five.lower_quartile, five.median, five.upper_quartile];
        assert_eq!(quantiles, [Some(0.2), Some(0.4), Some(0.5)]);
        let four = spread(&[0.5, -0.1, -0.2, 0.4]);
        for (found, expected) in [
            (four.lower_quartile, 0.175),
            (four.median, 0.3),
            (four.upper_quartile, 0.425),
        ] {
            assert!((found.unwrap() - expected).abs() < 1e-15);
        }
    }

    #[test]
    fn a_window_that_is_lost_counts_as_larger_than_any() {
        let some = spread(&[f64::NAN, 0.3, 0.4, f64::INFINITY]);
        assert_eq!((some.windows, some.lost), (4, 2));
        assert_eq!(some.upper_quartile, None);
        assert_eq!(some.median, None);
        assert!((some.rms.unwrap() - (0.125_f64).sqrt()).abs() < 1e-15);
        assert_eq!(spread(&[]).rms, None);
    }
}
