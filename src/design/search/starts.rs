//! Initial values of a search: random motions, and perturbations of the best one, inside all limits.

use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::PI;

use crate::design::problem::{Excitation, Experiment};
use crate::problem::Problem;
use crate::problem::linear_rows::LinearRows;
use crate::robot::random::symmetric;

/// Share of the tightest linear limit that a random motion uses.
const SHARE: f64 = 0.7;

/// Share up to which a disturbed motion is drawn back.
const INSIDE: f64 = 0.98;

/// Singular values of equations below this are zero.
const RANK: f64 = 1e-12;

/// Distance of a motion from its limits that is rounding.
const ON_LIMIT: f64 = 1e-6;

/// One step of drawing a motion towards standstill, and the most steps.
const SHRINK: f64 = 0.8;
const MOST_STEPS: usize = 12;

/// Positions of standstill that are tried where the middle of the ranges breaks a limit.
const POSTURES: usize = 200;

/// Starts of one problem.
pub struct Starts<'a> {
    problem: &'a Excitation<'a>,
    rows: &'a LinearRows,
    /// Coefficients of each joint; the first is its mean position.
    width: usize,
    /// The same for every joint of every trajectory: middle and half range of positions.
    ranges: Vec<(f64, f64)>,
}

impl<'a> Starts<'a> {
    /// Starts of a problem of an experiment.
    pub fn of(
        experiment: &Experiment<'_>,
        problem: &'a Excitation<'a>,
        rows: &'a LinearRows,
    ) -> Self {
        let joints = &experiment.joints;
        let range = |j: &usize| {
            let limits = &experiment.bounds[*j];
            (limits.middle(), limits.half_range())
        };
        let one: Vec<(f64, f64)> = joints.moving.iter().map(range).collect();
        Self {
            problem,
            rows,
            width: joints.series.width(),
            ranges: one.repeat(joints.trajectories),
        }
    }

    /// Standstill in the middle of the ranges.
    pub fn middle(&self) -> DVector<f64> {
        self.standstill(|(middle, _)| middle)
    }

    fn standstill(&self, mut position: impl FnMut((f64, f64)) -> f64) -> DVector<f64> {
        let mut x = DVector::zeros(self.width * self.ranges.len());
        for (k, range) in self.ranges.iter().enumerate() {
            x[k * self.width] = position(*range);
        }
        x
    }

    /// A random motion.
    pub fn random(&self, rng: &mut ChaCha8Rng) -> DVector<f64> {
        let mut x = DVector::from_fn(self.width * self.ranges.len(), |_, _| {
            StandardNormal.sample(rng)
        });
        let middle = self.middle();
        for k in 0..self.ranges.len() {
            let own = k * self.width;
            x[own] = middle[own];
        }
        self.fit_joints(&mut x, &middle);
        self.admissible(x, rng)
    }

    /// The best motion so far, every coefficient disturbed by `size` times a change that matters.
    pub fn disturbed(&self, best: &DVector<f64>, size: f64, rng: &mut ChaCha8Rng) -> DVector<f64> {
        let mut x = best.clone();
        for (value, variable) in x.iter_mut().zip(&self.problem.form().variables) {
            let normal: f64 = StandardNormal.sample(rng);
            *value += size * variable.scale * normal;
        }
        let middle = self.middle();
        self.keep_equations(&mut x);
        let step = &x - &middle;
        let longest = self.rows.longest_step(&middle, &step);
        self.admissible(&middle + step * longest.min(1.0) * INSIDE, rng)
    }

    /// The best motion so far with the motion of some joints drawn again.
    pub fn redrawn(
        &self,
        best: &DVector<f64>,
        joints: usize,
        rng: &mut ChaCha8Rng,
    ) -> DVector<f64> {
        let drawn = self.random(rng);
        let mut x = best.clone();
        for _ in 0..joints {
            let first = self.width * rng.random_range(0..self.ranges.len());
            let own = drawn.rows(first, self.width);
            x.rows_mut(first, self.width).copy_from(&own);
        }
        self.given(&x, rng)
    }

    /// The best motion so far with one joint a part of the period earlier or later: it keeps its speeds and its limits
    /// and meets other motions of the rest.
    pub fn shifted(&self, best: &DVector<f64>, rng: &mut ChaCha8Rng) -> DVector<f64> {
        let mut x = best.clone();
        let harmonics = (self.width - 1) / 2;
        let first = self.width * rng.random_range(0..self.ranges.len());
        let phase = symmetric(rng, PI);
        for l in 1..=harmonics {
            let (sine, cosine) = (l as f64 * phase).sin_cos();
            let (a, b) = (x[first + l], x[first + harmonics + l]);
            x[first + l] = a * cosine + b * sine;
            x[first + harmonics + l] = b * cosine - a * sine;
        }
        self.given(&x, rng)
    }

    /// A given start, drawn inside.
    pub fn given(&self, x: &DVector<f64>, rng: &mut ChaCha8Rng) -> DVector<f64> {
        let mut x = x.clone();
        self.keep_equations(&mut x);
        let middle = self.middle();
        let step = &x - &middle;
        let longest = self.rows.longest_step(&middle, &step);
        // A motion that an earlier search left on its limits stays there.
        let inside = if longest < 1.0 - ON_LIMIT {
            longest * INSIDE
        } else {
            longest.min(1.0)
        };
        self.admissible(&middle + step * inside, rng)
    }

    /// Scales the amplitudes of each joint to its own tightest limit.
    fn fit_joints(&self, x: &mut DVector<f64>, middle: &DVector<f64>) {
        self.keep_equations(x);
        let (values, at_rest) = (self.rows.values(x), self.rows.values(middle));
        let mut factors = vec![f64::INFINITY; self.ranges.len()];
        for ((row, value), rest) in self.rows.rows.iter().zip(values).zip(at_rest) {
            let change = value - rest;
            if row.is_equation() || change == 0.0 {
                continue;
            }
            let bound = if change > 0.0 { row.upper } else { row.lower };
            let factor = &mut factors[row.first / self.width];
            *factor = factor.min((bound - rest) / change);
        }
        for (k, factor) in factors.into_iter().enumerate() {
            let factor = if factor.is_finite() { factor } else { 1.0 };
            for c in 1..self.width {
                x[k * self.width + c] *= SHARE * factor;
            }
        }
    }

    /// The nearest coefficients that satisfy the equations: `x + Aᵀ (A Aᵀ)⁻¹ (b − A x)`, joint by joint.
    fn keep_equations(&self, x: &mut DVector<f64>) {
        let all = &self.rows.rows;
        let equations: Vec<usize> = (0..all.len()).filter(|&k| all[k].is_equation()).collect();
        for group in equations.chunk_by(|a, b| all[*a].first == all[*b].first) {
            let (first, width) = (all[group[0]].first, all[group[0]].width);
            let a = DMatrix::from_fn(group.len(), width, |i, j| self.rows.numbers(group[i])[j]);
            let right = DVector::from_fn(group.len(), |i, _| all[group[i]].upper);
            let missing = right - &a * x.rows(first, width);
            // Equations that repeat each other, as of a joint with one harmonic at rest, have many solutions.
            let Ok(inverse) = (&a * a.transpose()).pseudo_inverse(RANK) else {
                continue;
            };
            let step = a.transpose() * (inverse * missing);
            let mut own = x.rows_mut(first, width);
            own += step;
        }
    }

    /// Σ max(0, −g); infinite outside the domain.
    fn infeasibility(&self, x: &DVector<f64>) -> f64 {
        let g = self.problem.constraints(x);
        g.iter().map(|g| (-g).max(0.0)).sum()
    }

    /// The motion drawn towards standstill until torques and workspace keep their limits; where
    /// standstill in the middle does not, towards the best of many postures.
    fn admissible(&self, x: DVector<f64>, rng: &mut ChaCha8Rng) -> DVector<f64> {
        if self.problem.form().constraints.is_empty() || self.infeasibility(&x) == 0.0 {
            return x;
        }
        let mut rest = self.middle();
        let mut least = self.infeasibility(&rest);
        for _ in 0..POSTURES {
            if least == 0.0 {
                break;
            }
            let posture = self.standstill(|(middle, half)| middle + SHARE * symmetric(rng, half));
            let found = self.infeasibility(&posture);
            if found < least {
                (rest, least) = (posture, found);
            }
        }
        // The same amplitudes about the posture, inside the linear limits.
        let mut moved = x;
        for k in 0..self.ranges.len() {
            moved[k * self.width] = rest[k * self.width];
        }
        let step = &moved - &rest;
        let longest = self.rows.longest_step(&rest, &step);
        let mut factor = longest;
        for _ in 0..MOST_STEPS {
            let trial = &rest + &step * factor;
            if self.infeasibility(&trial) <= least {
                return trial;
            }
            factor *= SHRINK;
        }
        &rest + &step * factor
    }
}
