//! Local searches for the own parameters of a hypothesis from points of their grid, the fitted parameters projected out.
//!
//! One step of all parameters promises more than a law with several shapes keeps: far from where the shapes lie, their derivatives
//! span much that the law is not. What a search from there reaches tells which point leads to the best optimum.

use crate::diagnose::candidates::score_test::{Base, Enlarged, Linearised, ScoreTests};
use crate::diagnose::fit::candidate::Point;
use crate::stats::likelihood_ratio::BY_CHANCE;
use crate::stats::range::within;
use nalgebra::DVector;
use rayon::prelude::*;

/// Points from which a search begins, of those that promise most, and of those whose sizes alone do.
const FOREMOST: usize = 3;

/// Steps of a search at most.
const STEPS: usize = 6;

/// Shares of a step that are tried.
const SHARES: [f64; 3] = [1.0, 0.25, 0.0625];

/// Searches for the own parameters of one hypothesis.
pub(super) struct ShapeSearch<'a> {
    pub tests: &'a ScoreTests<'a>,
    pub enlarged: &'a Enlarged<'a>,
    pub bases: &'a [Base],
}

/// Where a search is.
struct Place {
    values: DVector<f64>,
    here: Linearised,
}

impl ShapeSearch<'_> {
    /// Where searches from the foremost of some points end, with what they reach, the most first.
    pub fn ends(&self, best_first: &[Point]) -> Vec<Point> {
        let mut by_sizes: Vec<&Point> = best_first.iter().collect();
        by_sizes.sort_by(|a, b| b.of_sizes.total_cmp(&a.of_sizes));
        let mut starts: Vec<&Point> = best_first.iter().take(FOREMOST).collect();
        for point in by_sizes.into_iter().take(FOREMOST) {
            if starts.iter().all(|known| known.at != point.at) {
                starts.push(point);
            }
        }
        let mut ends: Vec<Point> = starts.par_iter().map(|point| self.end(point)).collect();
        ends.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        ends.dedup_by(|later, earlier| earlier.gain - later.gain <= BY_CHANCE);
        ends
    }

    /// The end of the search from a point; its first step is one of the sizes, since a law of the wrong size says nothing of where
    /// its shape lies.
    fn end(&self, point: &Point) -> Point {
        let own = &self.enlarged.own;
        let mut place = self.place(self.bases[point.base].with(own, &point.at));
        for step in 0..STEPS {
            let moves = |k: usize| step > 0 || self.enlarged.is_linear(k);
            let further = self.further(&place, &moves);
            let gained = further
                .as_ref()
                .map_or(0.0, |to| to.here.reached - place.here.reached);
            place = further.unwrap_or(place);
            if step > 0 && gained <= BY_CHANCE {
                break;
            }
        }
        Point {
            gain: place.here.reached,
            at: own.iter().map(|&p| place.values[p]).collect(),
            ..point.clone()
        }
    }

    /// Where a share of a step leads that reaches more.
    fn further(&self, from: &Place, moves: &dyn Fn(usize) -> bool) -> Option<Place> {
        let step = self.enlarged.step(&from.values, &from.here, moves);
        if step.own.iter().all(|step| *step == 0.0) {
            return None;
        }
        let parameters = self.enlarged.model.parameters();
        let mut places = SHARES.iter().map(|share| {
            let mut values = from.values.clone();
            for (&p, step) in self.enlarged.own.iter().zip(&step.own) {
                let value = values[p] + share * step;
                values[p] = within(value, [parameters[p].lower, parameters[p].upper]);
            }
            self.place(values)
        });
        places.find(|to| to.here.reached > from.here.reached)
    }

    fn place(&self, values: DVector<f64>) -> Place {
        let here = self.tests.linearised(self.enlarged, &values);
        Place { values, here }
    }
}
