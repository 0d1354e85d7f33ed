//! The iterate of the method: step, cones, and one predictor-corrector step of it.

use crate::problem::solution::{Stop, Trace};
use crate::solve::interior::block::{Cone, State};
use crate::solve::interior::normal::{Factor, gram};
use crate::solve::interior::program::Program;
use crate::solve::interior::small::{self, Small};
use crate::solve::interior::{Run, Settings};
use nalgebra::{DMatrix, DVector};

/// Share of the way to the boundary that a step goes at most.
const TO_BOUNDARY: f64 = 0.95;

/// A cone that a start misses, or nearly, is given this share of its size as its smallest eigenvalue.
const FIRST_INTERIOR: f64 = 0.1;

/// Complementarity of a weighted cone above this many times its weight is reduced step by step.
const NEAR_WEIGHT: f64 = 10.0;

/// Shortest step that is progress.
const LEAST_STEP: f64 = 1e-10;

/// Share of S, and of the terms that sum up to it, by which S may differ from what the variables say.
const NEAR: f64 = 1e-6;
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Share of ½‖b‖² below which the cost is rounding.
const COST_ROUNDING: f64 = 1e-5;

pub(super) struct Iterate<'a> {
    program: &'a Program,
    gram: DMatrix<f64>,
    step: DVector<f64>,
    states: Vec<State>,
    /// Gradient of the smooth part less Σ Aᵀ Z.
    dual_miss: DVector<f64>,
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

impl<'a> Iterate<'a> {
    /// S at the start, pushed inside where it must be, and `S Z = μ·1` with μ of the size of the cost that
    /// there is to gain.
    pub fn start(program: &'a Program) -> Option<Self> {
        let step = DVector::zeros(program.linear.len());
        let gram = match &program.root {
            Some((matrix, _)) => gram(matrix),
            None => DMatrix::zeros(step.len(), step.len()),
        };
        let gradient = program.gradient(&step);
        let slope = match &program.root {
            Some(_) => 0.5 * gradient.dot(&Factor::of(gram.clone())?.solve(&gradient)),
            None => gradient.amax(),
        };
        let degree: usize = program.cones.iter().map(|c| c.order).sum();
        let share = slope / degree.max(1) as f64;
        let mu = if share > 0.0 { share } else { 1.0 };
        let states = program.cones.iter().map(|cone| {
            let mut s = cone.at(&step);
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
            size: program
                .root
                .as_ref()
                .map_or(1.0, |(_, r)| 0.5 * r.norm_squared()),
            program,
            gram,
            dual_miss: DVector::zeros(step.len()),
            step,
            measure: None,
            best: None,
        })
    }

    /// Scales the cones and measures the iterate; `None` where rounding has the better of it.
    pub fn measure(&mut self) -> Option<Measure> {
        let program = self.program;
        let gradient = program.gradient(&self.step);
        let cost = program.cost(&self.step);
        let unit = cost.abs().max(COST_ROUNDING * self.size);
        let mut miss = gradient;
        let mut sizes =
            self.gram.diagonal().map(|g| (2.0 * unit * g).sqrt()) + program.linear.abs();
        let mut gap = 0.0;
        let mut inside = true;
        for (cone, state) in program.cones.iter().zip(&mut self.states) {
            inside &= is_inside(cone, &self.step, state);
            state.scale(cone)?;
            cone.subtract_adjoint(&state.z, &mut miss);
            for (&j, slope) in cone.columns.iter().zip(&cone.slopes) {
                sizes[j] += slope.norm() * (state.z.norm() + unit / state.s.norm());
            }
            gap += state.gap(cone);
        }
        let shares = miss.iter().zip(sizes.iter()).map(|(m, s)| {
            let floor = f64::MIN_POSITIVE;
            m.abs() / s.max(floor)
        });
        // What the balance misses counts over the way that the variables have gone.
        let unbalanced: f64 = miss
            .iter()
            .zip(self.step.iter())
            .map(|(m, d)| (m * d).abs())
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
        self.dual_miss = miss;
        let better = |best: &(DVector<f64>, Measure)| gap < best.1.gap;
        if inside && self.best.as_ref().is_none_or(better) {
            self.best = Some((self.step.clone(), measure));
        }
        self.measure = Some(measure);
        Some(measure)
    }

    /// One predictor-corrector step; the length that was taken, `None` where there is none.
    pub fn advance(&mut self) -> Option<f64> {
        let mut normal = self.gram.clone();
        for (cone, state) in self.program.cones.iter().zip(&self.states) {
            state.add_curvature(cone, &mut normal);
        }
        let factor = Factor::of(normal)?;
        let none = vec![Small::zeros(); self.states.len()];
        let predicted = self.direction(&factor, (0.0, &none));
        let reach = self.reach(&predicted.1).min(1.0);
        let sigma = (1.0 - reach).powi(2);
        let corrections: Vec<Small> = predicted
            .1
            .iter()
            .map(|(ds, dz)| (ds * dz + dz * ds) * 0.5)
            .collect();
        let (step, changes) = self.direction(&factor, (sigma, &corrections));
        let length = (TO_BOUNDARY * self.reach(&changes)).min(1.0);
        if !(length > LEAST_STEP && step.iter().all(|x| x.is_finite())) {
            return None;
        }
        self.step.axpy(length, &step, 1.0);
        let cones = self.program.cones.iter();
        for ((cone, state), change) in cones.zip(&mut self.states).zip(&changes) {
            state.advance(cone.order, length, change);
        }
        Some(length)
    }

    /// Step of the variables and scaled changes of S and Z, towards complementarity σ μ or the weight.
    fn direction(
        &self,
        factor: &Factor,
        (sigma, corrections): (f64, &[Small]),
    ) -> (DVector<f64>, Vec<(Small, Small)>) {
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
        let mut right = -&self.dual_miss;
        for ((cone, state), wanted) in cones.iter().zip(&self.states).zip(&wanted) {
            state.add_right(cone, wanted, &mut right);
        }
        let step = factor.solve(&right);
        let changes = cones.iter().zip(&self.states).zip(&wanted);
        let changes = changes.map(|((cone, state), wanted)| state.directions(cone, wanted, &step));
        let changes = changes.collect();
        (step, changes)
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
    fn reach(&self, changes: &[(Small, Small)]) -> f64 {
        let cones = self.program.cones.iter().zip(&self.states).zip(changes);
        cones.fold(f64::INFINITY, |reach, ((cone, state), (ds, dz))| {
            let own = state
                .longest(cone.order, ds)
                .min(state.longest(cone.order, dz));
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
        let last = (self.step, self.measure.unwrap_or(none));
        let (step, measure) = match self.best {
            Some(best) if stop != Stop::Optimal => best,
            _ => last,
        };
        // Rounding stopped the method close enough.
        let near = measure.is_optimal(settings.reduced_tolerance);
        let stop = match stop {
            Stop::Stalled if !measure.inside => Stop::Infeasible,
            Stop::Stalled if near => Stop::Optimal,
            other => other,
        };
        Run {
            step,
            measure,
            stop,
            trace,
            multipliers,
        }
    }
}

/// Gives a cone the S that follows from the variables where that is inside; a cone that is still missed keeps its own.
/// Whether S is inside by more than rounding.
fn is_inside(cone: &Cone, step: &DVector<f64>, state: &mut State) -> bool {
    let exact = cone.at(step);
    let rounding = ROUNDING * cone.size(step);
    let room = (NEAR * state.s.amax()).max(rounding);
    let near = (exact - state.s).amax() <= room;
    if !near || small::cholesky(&exact, cone.order).is_none() {
        state.miss = exact - state.s;
        return false;
    }
    state.s = exact;
    state.miss = Small::zeros();
    let within = exact - small::identity(cone.order) * rounding;
    small::cholesky(&within, cone.order).is_some()
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
