//! Which rows enter the quadratic programme: those near their bound, of each run of neighbours the nearest and
//! one to either side, between which a peak moves.

use nalgebra::DVector;

use crate::problem::Linearization;
use crate::problem::form::{Form, Set};
use crate::problem::linear_rows::LinearRows;

/// A row farther from its bound than this share of its scale stays out until a step violates it.
const NEAR: f64 = 0.15;

/// Rows between the nearest of a run and those beside it that enter with it.
const BESIDE: usize = 3;

/// A violation below this share of a row's scale is left to the length of the step.
const NEGLIGIBLE: f64 = 1e-5;

/// One side of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Side {
    pub row: usize,
    pub upper: bool,
}

/// Slacks of both sides of the constant rows: distance to the bound as a share of the row's scale.
pub(super) fn slacks(rows: &LinearRows, values: &[f64], upper: bool) -> Vec<f64> {
    let of = |(row, value): (&crate::problem::linear_rows::LinearRow, &f64)| {
        let slack = if upper {
            row.upper - value
        } else {
            value - row.lower
        };
        slack / row.scale()
    };
    rows.rows.iter().zip(values).map(of).collect()
}

/// Positions of the local minima of a series that lie below a level.
fn dips(slacks: &[f64], level: f64) -> impl Iterator<Item = usize> + '_ {
    let before = |k: usize| if k == 0 { f64::INFINITY } else { slacks[k - 1] };
    let after = move |k: usize| slacks.get(k + 1).copied().unwrap_or(f64::INFINITY);
    (0..slacks.len())
        .filter(move |&k| slacks[k] < level && slacks[k] <= before(k) && slacks[k] <= after(k))
}

/// Constant rows near a bound at values A x; equations are not among them.
pub(super) fn near(rows: &LinearRows, values: &[f64]) -> Vec<Side> {
    pick(rows, values, NEAR)
}

/// Constant rows that values A (x + d) violate.
pub(super) fn violated(rows: &LinearRows, values: &[f64]) -> Vec<Side> {
    pick(rows, values, -NEGLIGIBLE)
}

fn pick(rows: &LinearRows, values: &[f64], level: f64) -> Vec<Side> {
    let mut sides = Vec::new();
    let kin = |a: usize, b: usize| {
        let (a, b) = (&rows.rows[a], &rows.rows[b]);
        a.first == b.first && a.lower == b.lower && a.upper == b.upper
    };
    for upper in [false, true] {
        let slacks = slacks(rows, values, upper);
        for row in dips(&slacks, level).filter(|&row| !rows.rows[row].is_equation()) {
            let beside = [row.checked_sub(BESIDE), Some(row), Some(row + BESIDE)];
            let near = beside
                .into_iter()
                .flatten()
                .filter(|&other| other < slacks.len() && kin(other, row));
            sides.extend(near.map(|row| Side { row, upper }));
        }
    }
    sides.sort_unstable();
    sides.dedup();
    sides
}

/// A row of the problem as `sign · g >= 0`: an equation gives two.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Smooth {
    pub row: usize,
    pub sign: f64,
}

/// The rows of a problem's own constraints, equations as pairs of inequalities.
pub(super) fn signed_rows(form: &Form) -> Vec<Smooth> {
    let mut all = Vec::new();
    let mut row = 0;
    for constraint in &form.constraints {
        for _ in 0..constraint.rows {
            all.push(Smooth { row, sign: 1.0 });
            if constraint.set == Set::Zero {
                all.push(Smooth { row, sign: -1.0 });
            }
            row += 1;
        }
    }
    all
}

/// Σ max(0, −sign·g).
pub(super) fn infeasibility(rows: &[Smooth], g: &DVector<f64>) -> f64 {
    rows.iter().map(|r| (-r.sign * g[r.row]).max(0.0)).sum()
}

/// Rows of the problem whose linearisation comes below `level` for the step d.
pub(super) fn smooth_below(
    rows: &[Smooth],
    model: &Linearization,
    d: &DVector<f64>,
    level: f64,
) -> Vec<usize> {
    if rows.is_empty() {
        return Vec::new();
    }
    let moved = &model.constraints + &model.jacobian * d;
    (0..rows.len())
        .filter(|&k| rows[k].sign * moved[rows[k].row] < level)
        .collect()
}
