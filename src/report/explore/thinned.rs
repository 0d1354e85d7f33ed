//! Lines over one common axis of time, with as many points as a page holds and every extreme kept.

/// Which rows stand for all: of each of `points / 2` equal stretches two, at which every line shows its least and its greatest value there.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Thinning {
    rows: usize,
    /// First row of each stretch; none where all rows are kept.
    stretches: Vec<usize>,
}

impl Thinning {
    /// Of `rows` to at most `points`.
    pub fn new(rows: usize, points: usize) -> Self {
        let count = (points / 2).max(1);
        let stretches = match rows <= points {
            true => Vec::new(),
            false => (0..count).map(|k| k * rows / count).collect(),
        };
        Self { rows, stretches }
    }

    fn bounds(&self) -> impl Iterator<Item = (usize, usize)> {
        let ends = self.stretches.iter().skip(1).copied().chain([self.rows]);
        self.stretches.iter().copied().zip(ends)
    }

    /// Times of the points: the first row and the middle one of each stretch.
    pub fn times(&self, t: &[f64]) -> Vec<f64> {
        if self.stretches.is_empty() {
            return t.to_vec();
        }
        self.bounds()
            .flat_map(|(start, end)| [t[start], t[start + (end - start) / 2]])
            .collect()
    }

    /// A line at these points: least and greatest of each stretch in the order in which they stand.
    pub fn line(&self, y: &[f64]) -> Vec<f64> {
        if self.stretches.is_empty() {
            return y.to_vec();
        }
        self.bounds()
            .flat_map(|(start, end)| extremes(&y[start..end]))
            .collect()
    }
}

/// Least and greatest of the finite values in the order in which they stand; not numbers where there are none.
fn extremes(y: &[f64]) -> [f64; 2] {
    let mut finite = y.iter().enumerate().filter(|(_, v)| v.is_finite());
    let Some(first) = finite.next() else {
        return [f64::NAN; 2];
    };
    let (mut low, mut high) = (first, first);
    for point in finite {
        if point.1 < low.1 {
            low = point;
        }
        if point.1 > high.1 {
            high = point;
        }
    }
    match low.0 <= high.0 {
        true => [*low.1, *high.1],
        false => [*high.1, *low.1],
    }
}

/// Rows at equal distances, at most `most` of them.
pub(super) fn every_nth(rows: usize, most: usize) -> impl Iterator<Item = usize> {
    (0..rows).step_by(rows.div_ceil(most.max(1)).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invariant_extremes_and_the_order_of_time_are_kept() {
        let rows = 100_003;
        let t: Vec<f64> = (0..rows).map(|k| 0.01 * k as f64).collect();
        let mut y: Vec<f64> = t.iter().map(|t| (37.0 * t).sin()).collect();
        (y[31_415], y[92_653], y[500]) = (7.0, -9.0, f64::NAN);
        let thinning = Thinning::new(rows, 1000);
        let (times, line) = (thinning.times(&t), thinning.line(&y));
        assert_eq!((times.len(), line.len()), (1000, 1000));
        assert!(times.windows(2).all(|pair| pair[0] < pair[1]));
        assert!(line.contains(&7.0) && line.contains(&-9.0));
    }

    #[test]
    fn short_series_stay_and_gaps_stay_gaps() {
        let y = [1.0, f64::NAN, 3.0];
        assert_eq!(Thinning::new(3, 4).line(&y)[2], 3.0);
        assert!(Thinning::new(6, 2).line(&[f64::NAN; 6])[0].is_nan());
        assert_eq!(every_nth(10, 3).collect::<Vec<_>>(), [0, 4, 8]);
    }
}
