//! Linear second-order equations along a course, solved for many right-hand sides.
//!
//! ```text
//! M(t) δ̈ + V(t) δ̇ + Q(t) δ = s(t)
//! δ̇ = (3 δ − 4 δ₋₁ + δ₋₂)/(2h), δ̈ from δ̇ alike
//! ```
//!
//! The backward difference formula of second order is L-stable: stiff gears and the flanks of teeth do
//! not ring. Along a motion that repeats the solution repeats: with x the last two values of δ and of δ̇
//! and Φ what one period makes of them, x = (1 − Φ)⁻¹ e, e what a period makes of rest.

use nalgebra::{DMatrix, DVector};

/// δ, δ̇, δ̈ of every member: `[order][member][sample]`.
pub(super) type Course = [Vec<Vec<f64>>; 3];

/// M, V and Q of one sample.
#[derive(Debug, Clone)]
pub(super) struct Coefficients {
    pub mass: DMatrix<f64>,
    pub damping: DMatrix<f64>,
    pub stiffness: DMatrix<f64>,
}

/// The equation with everything that does not depend on the right-hand side.
#[derive(Debug)]
pub(super) struct March {
    step: f64,
    coefficients: Vec<Coefficients>,
    /// Inverse of `Q + a V + a² M`, a = 3/(2h); at rest before a first sample of `Q`.
    inverse: Vec<DMatrix<f64>>,
    cycle: Option<Cycle>,
}

/// The responses to what came before, and the inverse of 1 − Φ.
#[derive(Debug)]
struct Cycle {
    responses: Vec<Course>,
    inverse: DMatrix<f64>,
}

/// Values before the first sample: δ₋₁, δ₋₂, δ̇₋₁, δ̇₋₂, members in order.
type History = DVector<f64>;

/// Kinds of values in a history.
const KINDS: usize = 4;

impl March {
    /// `None` where the equation has no solution.
    pub fn new(coefficients: Vec<Coefficients>, step: f64, cyclic: bool) -> Option<Self> {
        let a = 1.5 / step;
        let inverse = coefficients
            .iter()
            .enumerate()
            .map(|(k, c)| {
                let whole = match k == 0 && !cyclic {
                    true => c.stiffness.clone(),
                    false => &c.stiffness + &c.damping * a + &c.mass * (a * a),
                };
                whole.try_inverse()
            })
            .collect::<Option<Vec<_>>>()?;
        let mut march = Self {
            step,
            coefficients,
            inverse,
            cycle: None,
        };
        if cyclic {
            march.cycle = Some(march.close()?);
        }
        Some(march)
    }

    fn members(&self) -> usize {
        self.coefficients.first().map_or(0, |c| c.mass.nrows())
    }

    fn close(&self) -> Option<Cycle> {
        let order = KINDS * self.members();
        let rest = vec![vec![0.0; self.coefficients.len()]; self.members()];
        let mut transition = DMatrix::zeros(order, order);
        let mut responses = Vec::with_capacity(order);
        for k in 0..order {
            let mut history = DVector::zeros(order);
            history[k] = 1.0;
            let response = self.pass(&rest, Some(&history));
            transition.set_column(k, &end(&response));
            responses.push(response);
        }
        let inverse = (DMatrix::identity(order, order) - transition).try_inverse()?;
        Some(Cycle { responses, inverse })
    }

    /// δ, δ̇ and δ̈ for a right-hand side `[member][sample]`.
    pub fn solve(&self, source: &[Vec<f64>]) -> Course {
        let Some(cycle) = &self.cycle else {
            return self.pass(source, None);
        };
        let rest = DVector::zeros(KINDS * self.members());
        let mut course = self.pass(source, Some(&rest));
        let start = &cycle.inverse * end(&course);
        for (response, weight) in cycle.responses.iter().zip(start.iter()) {
            let to = course.iter_mut().flatten();
            for (to, from) in to.zip(response.iter().flatten()) {
                for (to, x) in to.iter_mut().zip(from) {
                    *to += weight * x;
                }
            }
        }
        course
    }

    /// One pass from a history, or from rest at the first sample.
    fn pass(&self, source: &[Vec<f64>], history: Option<&History>) -> Course {
        let (count, samples) = (self.members(), self.coefficients.len());
        let series = || vec![vec![0.0; samples]; count];
        let mut course = [series(), series(), series()];
        let mut rest = [vec![0.0; count], vec![0.0; count]];
        let mut right = vec![0.0; count];
        for k in 0..samples {
            let alone = k == 0 && history.is_none();
            for (order, rest) in rest.iter_mut().enumerate() {
                for (f, rest) in rest.iter_mut().enumerate() {
                    *rest = past((&course, history), (order, f), k) / (2.0 * self.step);
                }
            }
            let a = if alone { 0.0 } else { 1.5 / self.step };
            let c = &self.coefficients[k];
            for f in 0..count {
                right[f] = source[f][k];
                for g in 0..count {
                    right[f] -= c.damping[(f, g)] * rest[0][g]
                        + c.mass[(f, g)] * (a * rest[0][g] + rest[1][g]);
                }
            }
            for f in 0..count {
                let value: f64 = (0..count).map(|g| self.inverse[k][(f, g)] * right[g]).sum();
                let rate = a * value + rest[0][f];
                course[0][f][k] = value;
                course[1][f][k] = rate;
                course[2][f][k] = a * rate + rest[1][f];
            }
        }
        course
    }
}

/// The history that follows a course.
fn end(course: &Course) -> History {
    let count = course[0].len();
    DVector::from_fn(KINDS * count, |k, _| {
        let series = &course[k / (2 * count)][k % count];
        series[series.len() - 1 - (k / count) % 2]
    })
}

/// `−4 x₋₁ + x₋₂` of δ (order 0) or δ̇ (order 1) of a member before sample k; at rest before a first sample.
fn past(
    (course, history): (&Course, Option<&History>),
    (order, member): (usize, usize),
    k: usize,
) -> f64 {
    let count = course[0].len();
    let before = |steps: usize| match (k.checked_sub(steps), history) {
        (Some(at), _) => course[order][member][at],
        (None, Some(h)) => h[(2 * order + steps - k - 1) * count + member],
        (None, None) => course[order][member][0],
    };
    match k == 0 && history.is_none() {
        true => 0.0,
        false => before(2) - 4.0 * before(1),
    }
}

/// A torque that resists δ of a member: itself and its derivatives by δ and δ̇.
pub(super) type Resistance<'a> = &'a dyn Fn(usize, f64, f64) -> [f64; 3];

/// Passes over a period until it repeats.
const PERIODS: usize = 40;

/// A period repeats when its end differs from its start by less than this share.
const REPEATS: f64 = 1e-13;

/// Newton steps at a sample.
const STEPS: usize = 60;

/// Halvings of a Newton step that does not come closer.
const HALVINGS: usize = 30;

/// `M δ̈ + V δ̇ + Q δ + c(δ, δ̇) = s` with a resistance c that is far from linear: sample after sample, each by
/// Newton's method, because a flank that is reached at one sample decides what the next one meets.
pub(super) fn solve_with(
    (coefficients, step, cyclic): (&[Coefficients], f64, bool),
    source: &[Vec<f64>],
    resistance: Resistance<'_>,
    first: &Course,
) -> Course {
    let mut course = first.clone();
    let mut history = cyclic.then(|| end(first));
    for _ in 0..PERIODS {
        for k in 0..coefficients.len() {
            let at = Sample {
                coefficients: &coefficients[k],
                source,
                k,
                slope: match k == 0 && history.is_none() {
                    true => 0.0,
                    false => 1.5 / step,
                },
            };
            at.settle((&mut course, history.as_ref()), step, resistance);
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

struct Sample<'a> {
    coefficients: &'a Coefficients,
    source: &'a [Vec<f64>],
    k: usize,
    /// ∂δ̇/∂δ.
    slope: f64,
}

impl Sample<'_> {
    fn settle(
        &self,
        (course, history): (&mut Course, Option<&History>),
        step: f64,
        resistance: Resistance<'_>,
    ) {
        let count = self.source.len();
        let past = [0, 1].map(|order| {
            DVector::from_fn(count, |f, _| {
                past((course, history), (order, f), self.k) / (2.0 * step)
            })
        });
        let mut value = DVector::from_fn(count, |f, _| {
            course[0][f][self
                .k
                .saturating_sub(usize::from(history.is_none() || self.k > 0))]
        });
        let mut miss = self.miss(&value, &past, resistance);
        for _ in 0..STEPS {
            let Some(change) = miss.1.clone().lu().solve(&miss.0) else {
                break;
            };
            let mut share = 1.0;
            let next = loop {
                let moved = &value - &change * share;
                let next = self.miss(&moved, &past, resistance);
                if next.0.norm() < miss.0.norm() {
                    break Some((moved, next));
                }
                share *= 0.5;
                if share < 0.5_f64.powi(HALVINGS as i32) {
                    break None;
                }
            };
            let Some((moved, next)) = next else { break };
            (value, miss) = (moved, next);
        }
        for f in 0..count {
            let rate = self.slope * value[f] + past[0][f];
            course[0][f][self.k] = value[f];
            course[1][f][self.k] = rate;
            course[2][f][self.k] = self.slope * rate + past[1][f];
        }
    }

    /// Left side less right side, and its derivatives by δ.
    fn miss(
        &self,
        value: &DVector<f64>,
        past: &[DVector<f64>; 2],
        resistance: Resistance<'_>,
    ) -> (DVector<f64>, DMatrix<f64>) {
        let (a, c) = (self.slope, self.coefficients);
        let rate = value * a + &past[0];
        let second = &rate * a + &past[1];
        let mut miss = &c.mass * second + &c.damping * &rate + &c.stiffness * value;
        let mut slope = &c.mass * (a * a) + &c.damping * a + &c.stiffness;
        for f in 0..value.len() {
            let [torque, by_value, by_rate] = resistance(f, value[f], rate[f]);
            miss[f] += torque - self.source[f][self.k];
            slope[(f, f)] += by_value + a * by_rate;
        }
        (miss, slope)
    }
}
