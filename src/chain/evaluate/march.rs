//! Time integration of linear second-order equations along a motion, for many right-hand sides.
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
pub(super) type Response = [Vec<Vec<f64>>; 3];

/// The largest size; 0 of none.
pub(super) fn largest<'a>(of: impl IntoIterator<Item = &'a f64>) -> f64 {
    of.into_iter().fold(0.0, |most, x| most.max(x.abs()))
}

/// M, V and Q of every sample, members x members, row after row, sample after sample.
#[derive(Debug, Clone)]
pub(super) struct Coefficients {
    pub members: usize,
    pub mass: Vec<f64>,
    pub damping: Vec<f64>,
    pub stiffness: Vec<f64>,
}

impl Coefficients {
    pub fn zeros(members: usize, samples: usize) -> Self {
        let zeros = || vec![0.0; members * members * samples];
        Self {
            members,
            mass: zeros(),
            damping: zeros(),
            stiffness: zeros(),
        }
    }

    pub fn samples(&self) -> usize {
        self.mass.len() / (self.members * self.members).max(1)
    }

    /// Position of an entry of a sample.
    pub fn at(&self, k: usize, f: usize, g: usize) -> usize {
        (k * self.members + f) * self.members + g
    }

    /// `Q + a V + a² M` of a sample.
    fn left(&self, k: usize, a: f64) -> impl Iterator<Item = f64> {
        let size = self.members * self.members;
        let own = k * size..(k + 1) * size;
        own.map(move |at| self.stiffness[at] + a * self.damping[at] + a * a * self.mass[at])
    }
}

/// The instants of a motion: evenly spaced, and the first again after the last where the motion repeats.
#[derive(Debug, Clone, Copy)]
pub(super) struct TimeGrid {
    /// s.
    pub step: f64,
    pub cyclic: bool,
}

/// The equation with everything that does not depend on the right-hand side.
#[derive(Debug)]
pub(super) struct March {
    step: f64,
    coefficients: Coefficients,
    /// Inverse of `Q + a V + a² M`, a = 3/(2h); at rest before a first sample of `Q`.
    inverse: Vec<f64>,
    cycle: Option<Cycle>,
}

/// The responses to what came before, and the inverse of 1 − Φ.
#[derive(Debug)]
struct Cycle {
    responses: Vec<Response>,
    inverse: DMatrix<f64>,
}

/// Values before the first sample: δ₋₁, δ₋₂, δ̇₋₁, δ̇₋₂, members in order.
pub(super) type History = DVector<f64>;

/// Kinds of values in a history.
const KINDS: usize = 4;

impl March {
    /// `None` where the equation has no solution.
    pub fn new(coefficients: Coefficients, grid: TimeGrid) -> Option<Self> {
        let TimeGrid { step, cyclic } = grid;
        let a = 1.5 / step;
        let mut inverse = Vec::with_capacity(coefficients.mass.len());
        for k in 0..coefficients.samples() {
            let a = if k == 0 && !cyclic { 0.0 } else { a };
            push_inverse(&mut inverse, coefficients.left(k, a), coefficients.members)?;
        }
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
        self.coefficients.members
    }

    fn close(&self) -> Option<Cycle> {
        let order = KINDS * self.members();
        let rest = vec![vec![0.0; self.coefficients.samples()]; self.members()];
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
    pub fn solve(&self, source: &[Vec<f64>]) -> Response {
        let Some(cycle) = &self.cycle else {
            return self.pass(source, None);
        };
        let rest = DVector::zeros(KINDS * self.members());
        let mut response = self.pass(source, Some(&rest));
        let start = &cycle.inverse * end(&response);
        for (part, weight) in cycle.responses.iter().zip(start.iter()) {
            let to = response.iter_mut().flatten();
            for (to, from) in to.zip(part.iter().flatten()) {
                for (to, x) in to.iter_mut().zip(from) {
                    *to += weight * x;
                }
            }
        }
        response
    }

    /// One pass from a history, or from rest at the first sample.
    fn pass(&self, source: &[Vec<f64>], history: Option<&History>) -> Response {
        let (count, samples) = (self.members(), self.coefficients.samples());
        let series = || vec![vec![0.0; samples]; count];
        let mut response = [series(), series(), series()];
        let mut rest = [vec![0.0; count], vec![0.0; count]];
        let mut right = vec![0.0; count];
        for k in 0..samples {
            let alone = k == 0 && history.is_none();
            let past = Past {
                response: &response,
                history,
            };
            for (order, rest) in rest.iter_mut().enumerate() {
                for (f, rest) in rest.iter_mut().enumerate() {
                    *rest = past.weighed(order, f, k) / (2.0 * self.step);
                }
            }
            let a = if alone { 0.0 } else { 1.5 / self.step };
            let c = &self.coefficients;
            for f in 0..count {
                right[f] = source[f][k];
                for g in 0..count {
                    let at = c.at(k, f, g);
                    right[f] -=
                        c.damping[at] * rest[0][g] + c.mass[at] * (a * rest[0][g] + rest[1][g]);
                }
            }
            for f in 0..count {
                let value: f64 = (0..count)
                    .map(|g| self.inverse[c.at(k, f, g)] * right[g])
                    .sum();
                let rate = a * value + rest[0][f];
                response[0][f][k] = value;
                response[1][f][k] = rate;
                response[2][f][k] = a * rate + rest[1][f];
            }
        }
        response
    }
}

/// The history that follows a response.
pub(super) fn end(response: &Response) -> History {
    let count = response[0].len();
    DVector::from_fn(KINDS * count, |k, _| {
        let series = &response[k / (2 * count)][k % count];
        series[series.len() - 1 - (k / count) % 2]
    })
}

/// What is known before a sample: the response up to it, and what came before the first, if that was not rest.
#[derive(Clone, Copy)]
pub(super) struct Past<'a> {
    pub response: &'a Response,
    pub history: Option<&'a History>,
}

impl Past<'_> {
    /// `−4 x₋₁ + x₋₂` of δ (order 0) or δ̇ (order 1) of a member before sample k; at rest before a first sample.
    pub fn weighed(self, order: usize, member: usize, k: usize) -> f64 {
        let series = &self.response[order];
        let before = |steps: usize| match (k.checked_sub(steps), self.history) {
            (Some(at), _) => series[member][at],
            (None, Some(h)) => h[(2 * order + steps - k - 1) * series.len() + member],
            (None, None) => series[member][0],
        };
        match k == 0 && self.history.is_none() {
            true => 0.0,
            false => before(2) - 4.0 * before(1),
        }
    }
}

/// Appends the inverse of a small matrix given row after row; `None` where it has none.
fn push_inverse(to: &mut Vec<f64>, entries: impl Iterator<Item = f64>, size: usize) -> Option<()> {
    if size == 1 {
        let inverse: Vec<f64> = entries.map(|x| 1.0 / x).collect();
        to.extend(inverse.iter().filter(|x| x.is_finite()));
        return inverse[0].is_finite().then_some(());
    }
    let inverse = DMatrix::from_row_iterator(size, size, entries).try_inverse()?;
    to.extend(inverse.transpose().iter());
    Some(())
}
