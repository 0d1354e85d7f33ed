//! Second-order equations along a course with a resistance that is far from linear.
//!
//! ```text
//! M(t) δ̈ + V(t) δ̇ + Q(t) δ + c(δ, δ̇) = s(t)
//! ```
//!
//! with the differences of [`march`](super::march), sample after sample, each by Newton's method, because a flank
//! that is reached at one sample decides what the next one meets.

use crate::chain::evaluate::march::{Coefficients, Course, History, end, past};
use nalgebra::{DMatrix, DVector};

/// A torque that resists δ of a member: itself and its derivatives by δ and δ̇.
pub(super) type Resistance<'a> = &'a dyn Fn(usize, f64, f64) -> [f64; 3];

/// Passes over a period until it repeats.
const PERIODS: usize = 40;

/// A period repeats when its end differs from its start by less than this share.
const REPEATS: f64 = 1e-13;

/// Newton steps at a sample.
const STEPS: usize = 60;

/// Halvings of a Newton step that does not come closer.
const HALVINGS: i32 = 30;

/// A miss of less than this share of its terms is rounding.
const ROUNDING: f64 = 2.0 * f64::EPSILON;

/// A Newton step that moves δ by less than this share of it is the last one.
const SETTLED: f64 = 1e-14;

/// δ, δ̇ and δ̈ for a right-hand side `[member][sample]`, from a course to begin with.
pub(super) fn solve_with(
    (coefficients, step, cyclic): (&Coefficients, f64, bool),
    source: &[Vec<f64>],
    resistance: Resistance<'_>,
    first: &Course,
) -> Course {
    let mut course = first.clone();
    let mut history = cyclic.then(|| end(first));
    let count = coefficients.members;
    let mut newton = Newton {
        coefficients,
        source,
        resistance,
        step,
        sample: 0,
        slope: 0.0,
        past: [vec![0.0; count], vec![0.0; count]],
        value: vec![0.0; count],
        moved: vec![0.0; count],
        miss: Miss::new(count),
        tried: Miss::new(count),
    };
    for _ in 0..PERIODS {
        for k in 0..coefficients.samples() {
            newton.settle((&mut course, history.as_ref()), k);
        }
        let reached = end(&course);
        let repeats = history
            .as_ref()
            .is_some_and(|h| (h - &reached).amax() <= REPEATS * reached.amax());
        if !cyclic || repeats {
            break;
        }
        history = Some(reached);
    }
    course
}

/// Left side less right side, and its derivatives by δ, row after row.
struct Miss {
    value: Vec<f64>,
    slope: Vec<f64>,
    /// Sum of the sizes of the terms, of which rounding takes its share.
    terms: f64,
}

impl Miss {
    fn new(count: usize) -> Self {
        Self {
            value: vec![0.0; count],
            slope: vec![0.0; count * count],
            terms: 0.0,
        }
    }

    fn size(&self) -> f64 {
        self.value.iter().map(|x| x * x).sum::<f64>().sqrt()
    }

    /// The step that would make it vanish were it linear; `None` where none does.
    fn step(&self) -> Option<Vec<f64>> {
        let count = self.value.len();
        if count == 1 {
            let step = self.value[0] / self.slope[0];
            return step.is_finite().then(|| vec![step]);
        }
        let slope = DMatrix::from_row_slice(count, count, &self.slope);
        let step = slope.lu().solve(&DVector::from_column_slice(&self.value))?;
        Some(step.as_slice().to_vec())
    }
}

/// The equation at one sample.
struct Newton<'a> {
    coefficients: &'a Coefficients,
    source: &'a [Vec<f64>],
    resistance: Resistance<'a>,
    step: f64,
    sample: usize,
    /// ∂δ̇/∂δ.
    slope: f64,
    /// What δ̇ and δ̈ have from the samples before.
    past: [Vec<f64>; 2],
    value: Vec<f64>,
    moved: Vec<f64>,
    miss: Miss,
    tried: Miss,
}

impl Newton<'_> {
    fn settle(&mut self, (course, history): (&mut Course, Option<&History>), k: usize) {
        let alone = k == 0 && history.is_none();
        let count = self.value.len();
        self.sample = k;
        self.slope = if alone { 0.0 } else { 1.5 / self.step };
        for (order, series) in self.past.iter_mut().enumerate() {
            for (f, to) in series.iter_mut().enumerate() {
                *to = past((course, history), (order, f), k) / (2.0 * self.step);
            }
        }
        let before = k.saturating_sub(usize::from(history.is_none() || k > 0));
        for f in 0..count {
            self.value[f] = course[0][f][before];
        }
        self.find();
        for f in 0..count {
            let rate = self.slope * self.value[f] + self.past[0][f];
            course[0][f][k] = self.value[f];
            course[1][f][k] = rate;
            course[2][f][k] = self.slope * rate + self.past[1][f];
        }
    }

    fn find(&mut self) {
        self.moved.clone_from(&self.value);
        self.miss_at_moved();
        std::mem::swap(&mut self.miss, &mut self.tried);
        for _ in 0..STEPS {
            if self.miss.size() <= ROUNDING * self.miss.terms {
                break;
            }
            let Some(change) = self.miss.step() else {
                break;
            };
            let largest = |of: &[f64]| of.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            let last = largest(&change) <= SETTLED * largest(&self.value);
            if !self.descend(&change) || last {
                break;
            }
        }
    }

    /// Moves along a step as far as it comes closer; whether it does.
    fn descend(&mut self, change: &[f64]) -> bool {
        let size = self.miss.size();
        for halving in 0..HALVINGS {
            let share = 0.5_f64.powi(halving);
            for (to, (from, by)) in self.moved.iter_mut().zip(self.value.iter().zip(change)) {
                *to = from - share * by;
            }
            self.miss_at_moved();
            if self.tried.size() < size {
                std::mem::swap(&mut self.miss, &mut self.tried);
                self.value.clone_from(&self.moved);
                return true;
            }
        }
        false
    }

    fn miss_at_moved(&mut self) {
        let (a, c, k) = (self.slope, self.coefficients, self.sample);
        let [first, second] = &self.past;
        self.tried.terms = 0.0;
        for f in 0..self.moved.len() {
            let mut miss = -self.source[f][k];
            for g in 0..self.moved.len() {
                let at = c.at(k, (f, g));
                let rate = a * self.moved[g] + first[g];
                let [mass, damping, stiffness] = [
                    c.mass[at] * (a * rate + second[g]),
                    c.damping[at] * rate,
                    c.stiffness[at] * self.moved[g],
                ];
                miss += mass + damping + stiffness;
                self.tried.terms += mass.abs() + damping.abs() + stiffness.abs();
                self.tried.slope[f * self.moved.len() + g] =
                    c.mass[at] * a * a + c.damping[at] * a + c.stiffness[at];
            }
            let rate = a * self.moved[f] + first[f];
            let [torque, by_value, by_rate] = (self.resistance)(f, self.moved[f], rate);
            let turned = (by_value * self.moved[f]).abs() + (by_rate * rate).abs();
            self.tried.terms += self.source[f][k].abs() + turned;
            self.tried.value[f] = miss + torque;
            self.tried.slope[f * self.moved.len() + f] += by_value + a * by_rate;
        }
    }
}
