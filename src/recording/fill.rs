//! Straight lines over the samples that a mask leaves out, so that filters have an even series.

/// What lies beyond the ends of a series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ends {
    /// The nearest valid sample is held.
    Held,
    /// The series is one period: its end is followed by its start.
    Joined,
}

/// Replaces the samples whose mask is false by linear interpolation between valid neighbours.
pub(super) fn fill(series: &mut [f64], mask: &[bool], ends: Ends) {
    let n = series.len();
    let Some(first) = mask.iter().position(|&valid| valid) else {
        return;
    };
    let mut before = first;
    // One turn from the first valid sample on; `first + n` is that sample again.
    for k in first + 1..=first + n {
        if !mask[k % n] {
            continue;
        }
        let wraps = k >= n;
        for gap in before + 1..k {
            let weight = (gap - before) as f64 / (k - before) as f64;
            let line = (1.0 - weight) * series[before % n] + weight * series[k % n];
            series[gap % n] = match ends {
                Ends::Held if wraps && gap < n => series[before % n],
                Ends::Held if wraps => series[k % n],
                _ => line,
            };
        }
        before = k;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(found: &[f64], exact: &[f64]) {
        let mut pairs = found.iter().zip(exact);
        assert!(pairs.all(|(a, b)| (a - b).abs() < 1e-14), "{found:?}");
    }

    #[test]
    fn fills_inside_and_at_the_ends() {
        let mask = [false, true, false, false, true, false];
        let mut held = [9.0, 1.0, 9.0, 9.0, 4.0, 9.0];
        fill(&mut held, &mask, Ends::Held);
        assert_near(&held, &[1.0, 1.0, 2.0, 3.0, 4.0, 4.0]);
        let mut joined = [9.0, 1.0, 9.0, 9.0, 4.0, 9.0];
        fill(&mut joined, &mask, Ends::Joined);
        assert_near(&joined, &[2.0, 1.0, 2.0, 3.0, 4.0, 3.0]);
    }
}
