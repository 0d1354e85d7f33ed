//! The iterate of the method: step, cones, and one predictor-corrector step of it.

use crate::problem::solution::{Stop, Trace};
use crate::solve::interior::block::{Cone, ScaledChange, State};
use crate::solve::interior::coordinates::Coordinates;
use crate::solve::interior::newton::Factor;
use crate::solve::interior::program::Program;
use crate::solve::interior::settings::Settings;
use crate::solve::interior::small::{self, Small};
use nalgebra::{DMatrix, DVector};

/// The end of a run.
pub(super) struct Run {
    pub step: DVector<f64>,
    pub measure: Measure,
    pub stop: Stop,
    pub trace: Trace,
    pub multipliers: Vec<Vec<f64>>,
}

/// Share of the way to the boundary that a step goes at most.
const TO_BOUNDARY: f64 = 0.95;

/// A cone that a start misses, or nearly, is given this share of its size as its smallest eigenvalue.
const FIRST_INTERIOR: f64 = 0.1;

/// Complementarity of a weighted cone above this many times its weight is reduced step by step.
const NEAR_WEIGHT: f64 = 10.0;

/// Share of its column by which a coordinate that the squares do not see is held: a proximal term, which moves no
/// solution but keeps directions that nothing determines from being divided by rounding.
const PROXIMAL: f64 = 1e-7;

/// Shortest step that is progress.
const LEAST_STEP: f64 = 1e-10;

/// Share of S, and of the terms that sum up to it, by which S may differ from what the variables say.
const NEAR: f64 = 1e-6;
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Share of ½‖b‖² below which the cost is rounding.
const COST_ROUNDING: f64 = 1e-5;

pub(super) struct Iterate<'a> {
    program: &'a Program,
    /// By which an answer may miss a semidefinite block.
    shortfall: f64,
    /// Coordinates of the step.
    at: DVector<f64>,
    states: Vec<State>,
    measure: Option<Measure>,
    /// The best point strictly inside all cones so far.
    best: Option<(DVector<f64>, Measure)>,
    /// ½ ‖b‖².
    size: f64,
}

/// How far an iterate is from a solution.
#[derive(Debug, Clone, Copy)]
pub(super) struct Measure {
    pub cost: f64,
    pub gap: f64,
    pub stationarity: f64,
    /// S follows from the variables, and is positive definite by more than rounding.
    pub inside: bool,
    /// Cost that counts as one.
    unit: f64,
}

impl Measure {
    pub fn is_optimal(&self, tolerance: f64) -> bool {
        self.inside && self.gap <= tolerance * self.unit && self.stationarity <= tolerance.sqrt()
    }
}

/// A step of the variables, and of S and Z of every cone.
struct Direction {
    step: DVector<f64>,
    changes: Vec<ScaledChange>,
}

impl<'a> Iterate<'a> {
    /// S at the start, pushed inside where it must be, and `S Z = μ·1` with μ of the size of the cost that
    /// there is to gain.
    pub fn start(program: &'a Program, shortfall: f64) -> Option<Self> {
        let at = DVector::zeros(program.linear.len());
        let gradient = program.gradient(&at);
        let seen = &program.coordinates.seen;
        let slope = match seen.amax() > 0.0 {
            true => 0.5 * gradient.component_mul(seen).norm_squared(),
            false => gradient.amax(),
        };
        let degree: usize = program.cones.iter().map(|c| c.order).sum();
        let share = slope / degree.max(1) as f64;
        let mu = if share > 0.0 { share } else { 1.0 };
        let states = program.cones.iter().map(|cone| {
            let mut s = cone.constant;
            let size = (0..cone.order).map(|k| s[(k, k)].abs()).fold(0.0, f64::max);
            let size = if size > 0.0 { size } else { 1.0 };
            let least = exact_least(&s, cone.order);
            if least < FIRST_INTERIOR * FIRST_INTERIOR * size {
                s += small::identity(cone.order) * (FIRST_INTERIOR * size - least.min(0.0));
            }
            let z = inverse(&s, cone.order)? * mu.max(cone.weight);
            Some(State::new(s, z))
        });
        Some(Self {
            states: states.collect::<Option<Vec<_>>>()?,
            size: match seen.amax() > 0.0 {
                true => program.coordinates.squares(&at),
                false => 1.0,
            },
            program,
            shortfall,
            at,
            measure: None,
            best: None,
        })
    }

    /// Scales the cones and measures the iterate; `None` where rounding has the better of it.
    pub fn measure(&mut self) -> Option<Measure> {
        let program = self.program;
        let Coordinates { basis, seen, .. } = &program.coordinates;
        let step = program.coordinates.step(&self.at);
        let cost = program.cost(&self.at);
        let unit = cost.abs().max(COST_ROUNDING * self.size);
        let mut balance = DVector::zeros(step.len());
        let mut sizes = DVector::zeros(step.len());
        let mut gap = 0.0;
        let mut inside = true;
        for (cone, state) in program.cones.iter().zip(&mut self.states) {
            inside &= is_inside(cone, &step, self.shortfall, state);
            state.scale(cone, basis)?;
            cone.add_adjoint(&state.z, &mut balance);
            let size = state.z.norm() + unit / state.s.norm();
            for (&j, slope) in cone.columns.iter().zip(&cone.slopes) {
                sizes[j] += slope.norm() * size;
            }
            gap += state.gap(cone) + state.miss.dot(&state.z).max(0.0);
        }
        let miss = program.gradient(&self.at) - basis.tr_mul(&balance);
        let sizes = basis.abs().tr_mul(&sizes) + seen * (2.0 * unit).sqrt() + program.linear.abs();
        let shares = miss.iter().zip(sizes.iter()).map(|(m, s)| {
            let floor = f64::MIN_POSITIVE;
            m.abs() / s.max(floor)
        });
        let unbalanced: f64 = (0..miss.len())
            .map(|k| unbalanced(miss[k], self.at[k], seen[k]))
            .sum();
        let gap = gap + unbalanced;
        let measure = Measure {
            cost,
            gap,
            stationarity: shares.fold(0.0, f64::max),
            inside,
            unit,
        };
        if !(gap.is_finite() && measure.stationarity.is_finite()) {
            return None;
        }
        let better = |best: &(DVector<f64>, Measure)| gap < best.1.gap;
        if inside && self.best.as_ref().is_none_or(better) {
            self.best = Some((self.at.clone(), measure));
        }
        self.measure = Some(measure);
        Some(measure)
    }

    /// One predictor-corrector step; the length that was taken, `None` where there is none.
    pub fn advance(&mut self) -> Option<f64> {
        let factor = Factor::of(&self.rows())?;
        let none = vec![Small::zeros(); self.states.len()];
        let predicted = self.direction(&factor, 0.0, &none);
        let longest = self.longest_step(&predicted.changes).min(1.0);
        let sigma = (1.0 - longest).powi(2);
        let changes = predicted.changes.iter();
        let corrections: Vec<Small> = changes
            .map(|ScaledChange { s, z }| (s * z + z * s) * 0.5)
            .collect();
        let Direction { step, changes } = self.direction(&factor, sigma, &corrections);
        let length = (TO_BOUNDARY * self.longest_step(&changes)).min(1.0);
        if !(length > LEAST_STEP && step.iter().all(|x| x.is_finite())) {
            return None;
        }
        self.at.axpy(length, &step, 1.0);
        let cones = self.program.cones.iter();
        for ((cone, state), change) in cones.zip(&mut self.states).zip(&changes) {
            state.advance(cone.order, length, change);
        }
        Some(length)
    }

    /// Step of the variables and scaled changes of S and Z, towards complementarity σ μ or the weight.
    fn direction(&self, factor: &Factor, sigma: f64, corrections: &[Small]) -> Direction {
        let cones = &self.program.cones;
        let mu = self.complementarity();
        let wanted: Vec<Small> = cones
            .iter()
            .zip(&self.states)
            .zip(corrections)
            .map(|((cone, state), correction)| {
                let own = state.complementarity(cone.order) / cone.order as f64;
                let target = if cone.weight == 0.0 {
                    sigma * mu
                } else if own > NEAR_WEIGHT * cone.weight {
                    (sigma * own).max(cone.weight)
                } else {
                    cone.weight
                };
                state.wanted(cone.order, target, correction)
            })
            .collect();
        let mut right: Vec<f64> = Vec::new();
        for ((cone, state), wanted) in cones.iter().zip(&self.states).zip(&wanted) {
            right.extend(state.right(cone, wanted).iter().take(cone.rows()));
        }
        let coordinates = &self.program.coordinates;
        right.extend((-coordinates.gradient(&self.at)).iter());
        let step = factor.solve(&DVector::from_vec(right), &self.program.linear);
        let changes = cones.iter().zip(&self.states).zip(&wanted);
        let changes = changes.map(|((cone, state), wanted)| state.directions(cone, wanted, &step));
        let changes = changes.collect();
        Direction { step, changes }
    }

    /// Rows of the least squares problem whose solution is the step: those of the cones, then of the squares.
    fn rows(&self) -> DMatrix<f64> {
        let n = self.at.len();
        let count: usize = self.program.cones.iter().map(Cone::rows).sum();
        let mut rows = DMatrix::zeros(count + n, n);
        let mut first = 0;
        for state in &self.states {
            let own = &state.slopes;
            rows.rows_mut(first, own.nrows()).copy_from(own);
            first += own.nrows();
        }
        for (k, seen) in self.program.coordinates.seen.iter().enumerate() {
            let size = rows.column(k).amax();
            let proximal = PROXIMAL * if size > 0.0 { size } else { 1.0 };
            rows[(count + k, k)] = if *seen > 0.0 { *seen } else { proximal };
        }
        rows
    }

    /// μ: mean of S Z over the cones without a weight.
    fn complementarity(&self) -> f64 {
        let degree = self.program.degree().max(1) as f64;
        let states = self.program.cones.iter().zip(&self.states);
        let free = states.filter(|(cone, _)| cone.weight == 0.0);
        free.map(|(cone, state)| state.complementarity(cone.order))
            .sum::<f64>()
            / degree
    }

    /// Longest step that keeps every S and Z inside.
    fn longest_step(&self, changes: &[ScaledChange]) -> f64 {
        let cones = self.program.cones.iter().zip(&self.states).zip(changes);
        cones.fold(f64::INFINITY, |reach, ((cone, state), change)| {
            let own = state
                .longest(cone.order, &change.s)
                .min(state.longest(cone.order, &change.z));
            reach.min(own)
        })
    }

    /// The last iterate, or the best one inside the cones where the last has not converged.
    pub fn finish(self, stop: Stop, trace: Trace, settings: &Settings) -> Run {
        let multipliers = self.program.cones.iter().zip(&self.states);
        let multipliers = multipliers
            .map(|(cone, state)| {
                let rows = cone.order * (cone.order + 1) / 2;
                small::svec(&state.z, cone.order)[..rows].to_vec()
            })
            .collect();
        let none = Measure {
            cost: f64::NAN,
            gap: f64::INFINITY,
            stationarity: f64::INFINITY,
            inside: false,
            unit: 1.0,
        };
        let last = (self.at, self.measure.unwrap_or(none));
        let (at, measure) = match self.best {
            Some(best) if stop != Stop::Optimal => best,
            _ => last,
        };
        // Rounding kept the method from coming closer, or further iterates out of the cones.
        let near = measure.is_optimal(settings.reduced_tolerance);
        let stop = match stop {
            Stop::Stalled if !measure.inside => Stop::Infeasible,
            Stop::Stalled | Stop::IterationLimit if near => Stop::Optimal,
            other => other,
        };
        Run {
            step: self.program.coordinates.step(&at),
            measure,
            stop,
            trace,
            multipliers,
        }
    }
}

/// How far the Lagrangian falls below its value where its slope along a coordinate is the miss and its curvature one or
/// zero, over no longer a way than the coordinate has gone: Z bounds the cost from below by its least.
fn unbalanced(miss: f64, way: f64, curvature: f64) -> f64 {
    let (miss, way) = (miss.abs(), way.abs());
    if miss < curvature * way {
        0.5 * miss * miss / curvature
    } else {
        way * (miss - 0.5 * curvature * way)
    }
}

/// Whether S is inside by more than rounding. A cone is given the S that follows from the variables where that is
/// inside; one that is still missed keeps its own.
fn is_inside(cone: &Cone, step: &DVector<f64>, shortfall: f64, state: &mut State) -> bool {
    let exact = cone.at(step);
    let rounding = ROUNDING * cone.size(step);
    let room = (NEAR * state.s.amax()).max(rounding);
    let near = (exact - state.s).amax() <= room;
    let allowed = if cone.order > 1 { shortfall } else { 0.0 };
    let within = exact + small::identity(cone.order) * (allowed - rounding);
    let inside = near && small::cholesky(&within, cone.order).is_some();
    if near && small::cholesky(&exact, cone.order).is_some() {
        state.s = exact;
        state.miss = Small::zeros();
    } else {
        state.miss = exact - state.s;
    }
    inside
}

fn exact_least(matrix: &Small, order: usize) -> f64 {
    let mut padded = *matrix;
    for k in order..small::LARGEST {
        padded[(k, k)] = f64::MAX.sqrt();
    }
    small::least_eigenvalue(&padded, order)
}

fn inverse(matrix: &Small, order: usize) -> Option<Small> {
    let mut padded = *matrix;
    for k in order..small::LARGEST {
        padded[(k, k)] = 1.0;
    }
    let mut inverse = padded.try_inverse()?;
    for k in order..small::LARGEST {
        inverse[(k, k)] = 0.0;
    }
    Some((inverse + inverse.transpose()) * 0.5)
}
