//! Grid search: points of a grid in the order of the variance that they explain.

use crate::diagnose::fit::candidate::Point;
use crate::estimate::gap_search::{HALVINGS, halfway};
use rayon::prelude::*;

/// Rising values that are tried at the same time, some of them perhaps beyond the first that is far too large.
const AT_ONCE: usize = 4;

/// Points by what they gain, the most first; of rising values those before the first that is `hopeless`.
pub fn best_first(
    points: Vec<Vec<f64>>,
    hopeless: Option<f64>,
    gain: &(dyn Fn(Vec<f64>) -> Point + Sync),
) -> Vec<Point> {
    let mut seen: Vec<Point> = match hopeless {
        Some(hopeless) => {
            let at_once = points.chunks(AT_ONCE);
            let seen = at_once
                .flat_map(|some| -> Vec<Point> { some.par_iter().cloned().map(gain).collect() });
            seen.take_while(|point| point.gain > hopeless).collect()
        }
        None => points.into_par_iter().map(gain).collect(),
    };
    seen.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    seen
}

/// Points with steps about the best halved again and again.
pub fn halved(
    mut points: Vec<Point>,
    best_first: &dyn Fn(Vec<Vec<f64>>) -> Vec<Point>,
) -> Vec<Point> {
    for _ in 0..HALVINGS {
        points.extend(best_first(beside_best(&points)));
        points.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    }
    points
}

/// Half the way from the best of some points, which come first, to those next to it.
fn beside_best(points: &[Point]) -> Vec<Vec<f64>> {
    let Some(best) = points.first() else {
        return Vec::new();
    };
    let others: Vec<f64> = points.iter().map(|point| point.at[0]).collect();
    let halfway = halfway(best.at[0], &others).into_iter();
    halfway.map(|value| vec![value]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(at: f64) -> Point {
        Point {
            gain: -(at - 3.1).powi(2),
            of_sizes: 0.0,
            base: 0,
            at: vec![at],
        }
    }

    #[test]
    fn steps_are_halved_about_the_best_point() {
        let tried = |points: Vec<Vec<f64>>| -> Vec<Point> {
            points.into_iter().map(|at| point(at[0])).collect()
        };
        let rising = [1.0, 2.0, 4.0, 8.0, 16.0].map(|at| vec![at]).to_vec();
        let points = best_first(rising, None, &|at| point(at[0]));
        assert_eq!(points[0].at, [4.0]);
        assert_eq!(beside_best(&points), [vec![3.0], vec![6.0]]);
        // Then about 3, between 2 and 4.
        let halved = halved(points, &tried);
        let at: Vec<f64> = halved.iter().map(|point| point.at[0]).collect();
        assert_eq!(at, [3.0, 3.5, 2.5, 4.0, 2.0, 1.0, 6.0, 8.0, 16.0]);
        assert!(beside_best(&[]).is_empty());
    }

    /// Rising values end before the first that is hopeless.
    #[test]
    fn values_beyond_one_that_is_far_too_large_are_not_listed() {
        let rising = [2.0, 5.0, 9.0, 3.0].map(|at| vec![at]).to_vec();
        let points = best_first(rising, Some(-10.0), &|at| point(at[0]));
        let at: Vec<f64> = points.iter().map(|point| point.at[0]).collect();
        assert_eq!(at, [2.0, 5.0]);
    }
}
