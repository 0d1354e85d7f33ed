//! Interpolation over masked samples, so that filters have an even series: linear, or cubic, which goes on as a motion does and
//! has no kink.

/// What lies beyond the ends of a series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::recording) enum Ends {
    /// The nearest valid sample is held.
    Held,
    /// The series is one period: its end is followed by its start.
    Joined,
}

/// Replaces the samples whose mask is false by linear interpolation between valid neighbours.
pub(in crate::recording) fn fill(series: &mut [f64], mask: &[bool], ends: Ends) {
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

/// Samples from one point of a slope to the next: the noise of single samples is small in it.
const SLOPE_SPAN: usize = 4;

/// Replaces the samples whose mask is false by cubics with the values and slopes of both neighbours, at the ends by the
/// nearest valid sample.
pub(in crate::recording) fn fill_motion(series: &mut [f64], mask: &[bool]) {
    fill(series, mask, Ends::Held);
    let mut end = 0;
    for run in mask.chunk_by(|a, b| a == b) {
        let start = end;
        end += run.len();
        if run[0] || start == 0 || end == series.len() {
            continue;
        }
        let (before, after) = (start - 1, end);
        let length = (after - before) as f64;
        let straight = (series[after] - series[before]) / length;
        let behind = (0..=before).rev().take_while(|&k| mask[k]).count() - 1;
        let ahead = (after..series.len()).take_while(|&k| mask[k]).count() - 1;
        let leaving = slope(|k| series[before - k], behind).map_or(straight, |slope| -slope);
        let arriving = slope(|k| series[after + k], ahead).unwrap_or(straight);
        let (a, b) = (series[before], series[after]);
        for k in start..end {
            let u = (k - before) as f64 / length;
            let v = 1.0 - u;
            let bend = length * u * v * (v * (leaving - straight) - u * (arriving - straight));
            series[k] = v * a + u * b + bend;
        }
    }
}

/// Slope at the first of so many further samples, `(4 x(h) − 3 x(0) − x(2h)) / 2h`; None of too few.
fn slope(x: impl Fn(usize) -> f64, further: usize) -> Option<f64> {
    let h = (further / 2).min(SLOPE_SPAN);
    (h > 0).then(|| (4.0 * x(h) - 3.0 * x(0) - x(2 * h)) / (2 * h) as f64)
}

/// A time between two successive knots.
#[derive(Debug, Clone, Copy)]
pub(in crate::recording) struct Bracket {
    /// The number of the knot at or before it.
    pub before: usize,
    /// The share of the way from there to the next.
    pub share: f64,
}

/// Where increasing times lie among knots.
pub(in crate::recording) fn brackets(knots: &[f64], times: &[f64]) -> Vec<Bracket> {
    let mut k = 0;
    let bracket = |&t: &f64| {
        while k + 2 < knots.len() && knots[k + 1] <= t {
            k += 1;
        }
        let share = (t - knots[k]) / (knots[k + 1] - knots[k]);
        Bracket {
            before: k,
            share: share.clamp(0.0, 1.0),
        }
    };
    times.iter().map(bracket).collect()
}

/// A series on straight lines at the bracketed times.
pub(in crate::recording) fn on_lines(series: &[f64], brackets: &[Bracket]) -> Vec<f64> {
    let between = |at: &Bracket| {
        let (from, to) = (series[at.before], series[at.before + 1]);
        from + at.share * (to - from)
    };
    brackets.iter().map(between).collect()
}

/// Four successive samples with weights: the cubic through them at one time (Lagrange), or the line between the middle two.
#[derive(Debug, Clone, Copy)]
pub(in crate::recording) struct Stencil {
    first: usize,
    weights: [f64; 4],
}

/// Weights of a cubic whose sizes add up to more than this make noise larger than any line does that is as long: samples that
/// come in bursts.
const MOST_WEIGHT: f64 = 2.0;

impl Stencil {
    /// At a time between knots, of which there are four or more.
    pub fn at(knots: &[f64], Bracket { before, share }: Bracket) -> Self {
        let first = before.saturating_sub(1).min(knots.len() - 4);
        let four = &knots[first..first + 4];
        let t = knots[before] + share * (knots[before + 1] - knots[before]);
        let weight = |i: usize| -> f64 {
            let others = (0..4).filter(|&m| m != i);
            others
                .map(|m| (t - four[m]) / (four[i] - four[m]))
                .product()
        };
        let mut weights = [0, 1, 2, 3].map(weight);
        if weights.iter().map(|w| w.abs()).sum::<f64>() > MOST_WEIGHT {
            weights = [0.0; 4];
            weights[before - first] = 1.0 - share;
            weights[before + 1 - first] = share;
        }
        Self { first, weights }
    }

    /// The value of a series there.
    pub fn of(&self, series: &[f64]) -> f64 {
        let values = &series[self.first..self.first + 4];
        self.weights.iter().zip(values).map(|(w, x)| w * x).sum()
    }

    /// The variance that white noise of one has there.
    pub fn variance(&self) -> f64 {
        self.weights.iter().map(|w| w * w).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(found: &[f64], exact: &[f64]) {
        let mut pairs = found.iter().zip(exact);
        assert!(pairs.all(|(a, b)| (a - b).abs() < 1e-14), "{found:?}");
    }

    /// A cubic through values and slopes is off by L⁴ q''''/384, and slopes of second order by h² q'''/3 each, of which
    /// L/8 counts; q = sin(ω k).
    #[test]
    fn a_motion_goes_on_through_a_gap() {
        let (omega, length) = (0.02_f64, 50.0_f64);
        let exact: Vec<f64> = (0..400).map(|k| (omega * k as f64).sin()).collect();
        let mask: Vec<bool> = (0..400).map(|k| !(150..199).contains(&k)).collect();
        let mut filled = exact.clone();
        filled[150..199].fill(9.0);
        fill_motion(&mut filled, &mask);
        let errors = filled.iter().zip(&exact).map(|(a, b)| (a - b).abs());
        let slopes = 2.0 * (SLOPE_SPAN as f64).powi(2) * omega.powi(3) / 3.0;
        let bound = (omega * length).powi(4) / 384.0 + slopes * length / 8.0;
        assert!(errors.fold(0.0, f64::max) <= bound);
        // Without neighbours enough for a slope it is a straight line.
        let mut few = [0.0, 9.0, 2.0];
        fill_motion(&mut few, &[true, false, true]);
        assert_near(&few, &[0.0, 1.0, 2.0]);
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
