//! Time integration of second-order equations along a motion with a strongly nonlinear contact torque.
//!
//! ```text
//! M(t) δ̈ + V(t) δ̇ + Q(t) δ + c(t, δ, δ̇) = s(t)
//! ```
//!
//! with the differences of [`march`](super::march), sample after sample, each by Newton's method, because a flank
//! that is reached at one sample, or a link that comes to rest, decides what the next one meets.

use crate::chain::evaluate::march::{
    Coefficients, History, Past, Response, TimeGrid, end, largest,
};
use nalgebra::{DMatrix, DVector};

/// A place on the response: a member at a sample, with δ and δ̇.
#[derive(Debug, Clone, Copy)]
pub(super) struct Twist {
    pub member: usize,
    pub sample: usize,
    pub lag: f64,
    pub rate: f64,
}

/// A torque that resists δ of a member: itself and its derivatives by δ and δ̇.
pub(super) type Resistance<'a> = &'a dyn Fn(Twist) -> [f64; 3];

/// Passes over a period until it repeats.
const PERIODS: usize = 40;

/// A period repeats from where two samples in a row, all that later ones know of the past, differ from those of the
/// period before by less than this share of the largest: rounding alone keeps them further apart than digits go.
const REPEATS: f64 = 1e-11;

/// Newton steps at a sample.
const STEPS: usize = 60;

/// Halvings of a Newton step that does not come closer.
const HALVINGS: i32 = 30;

/// A miss of less than this share of its terms is rounding.
const ROUNDING: f64 = 2.0 * f64::EPSILON;

/// A Newton step that moves δ by less than this share of it is the last one.
const SETTLED: f64 = 1e-14;

/// δ, δ̇ and δ̈ for a right-hand side `[member][sample]`, from a response to begin with.
pub(super) fn solve_with(
    coefficients: &Coefficients,
    grid: TimeGrid,
    source: &[Vec<f64>],
    resistance: Resistance<'_>,
    first: &Response,
) -> Response {
    let TimeGrid { step, cyclic } = grid;
    let mut response = first.clone();
    let mut history = cyclic.then(|| end(first));
    let mut tolerance: Option<[f64; 2]> = None;
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
        miss: Imbalance::new(count),
        tried: Imbalance::new(count),
    };
    for _ in 0..PERIODS {
        let mut alike = 0;
        for k in 0..coefficients.samples() {
            let moved = newton.settle(&mut response, history.as_ref(), k);
            alike = match tolerance {
                Some([lag, rate]) if moved[0] <= lag && moved[1] <= rate => alike + 1,
                _ => 0,
            };
            if alike == 2 {
                return response;
            }
        }
        if !cyclic {
            break;
        }
        history = Some(end(&response));
        tolerance =
            Some([0, 1].map(|order: usize| REPEATS * largest(response[order].iter().flatten())));
    }
    response
}

/// Left side less right side, and its derivatives by δ, row after row.
struct Imbalance {
    value: Vec<f64>,
    slope: Vec<f64>,
    /// Sum of the sizes of the terms, of which rounding takes its share.
    terms: f64,
}

impl Imbalance {
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
    miss: Imbalance,
    tried: Imbalance,
}

impl Newton<'_> {
    /// Solves a sample of a response; by how much δ and δ̇ moved.
    fn settle(&mut self, response: &mut Response, history: Option<&History>, k: usize) -> [f64; 2] {
        let alone = k == 0 && history.is_none();
        let count = self.value.len();
        self.sample = k;
        self.slope = if alone { 0.0 } else { 1.5 / self.step };
        let past = Past { response, history };
        for (order, series) in self.past.iter_mut().enumerate() {
            for (f, to) in series.iter_mut().enumerate() {
                *to = past.weighed(order, f, k) / (2.0 * self.step);
            }
        }
        let before = k.saturating_sub(usize::from(history.is_none() || k > 0));
        self.begin(&response[0], [before, k]);
        self.find();
        let mut moved = [0.0_f64; 2];
        for f in 0..count {
            let rate = self.slope * self.value[f] + self.past[0][f];
            moved[0] = moved[0].max((self.value[f] - response[0][f][k]).abs());
            moved[1] = moved[1].max((rate - response[1][f][k]).abs());
            response[0][f][k] = self.value[f];
            response[1][f][k] = rate;
            response[2][f][k] = self.slope * rate + self.past[1][f];
        }
        moved
    }

    /// Begins at the sample before or where the response had this one, whichever misses less.
    fn begin(&mut self, lags: &[Vec<f64>], samples: [usize; 2]) {
        for (attempt, at) in samples.into_iter().enumerate() {
            for (to, series) in self.moved.iter_mut().zip(lags) {
                *to = series[at];
            }
            self.miss_at_moved();
            if attempt == 0 || self.tried.size() < self.miss.size() {
                std::mem::swap(&mut self.miss, &mut self.tried);
                self.value.clone_from(&self.moved);
            }
        }
    }

    fn find(&mut self) {
        for _ in 0..STEPS {
            if self.miss.size() <= ROUNDING * self.miss.terms {
                break;
            }
            let Some(change) = self.miss.step() else {
                break;
            };
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
                let at = c.at(k, f, g);
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
            let [torque, by_value, by_rate] = (self.resistance)(Twist {
                member: f,
                sample: k,
                lag: self.moved[f],
                rate,
            });
            let turned = (by_value * self.moved[f]).abs() + (by_rate * rate).abs();
            self.tried.terms += self.source[f][k].abs() + turned;
            self.tried.value[f] = miss + torque;
            self.tried.slope[f * self.moved.len() + f] += by_value + a * by_rate;
        }
    }
}
