//! Active bounds of a feasible fit: bodies on the boundary of their cones, unknowns at limits, and what the data ask of each body
//! when its own constraint alone is dropped.

use crate::estimate::derived::pseudo_inertia::{ROWS, scaled_body, svec4};
use crate::estimate::feasible::FeasibleFit;
use crate::estimate::feasible::compressed;
use crate::estimate::feasible::solve::constrained;
use crate::outcome::feasibility::BodyAtBound;
use crate::problem::solution::Control;
use crate::robot::inertia::Inertia;
use nalgebra::{DMatrix, DVector, Matrix4, RowDVector, SymmetricEigen};

/// An eigenvalue of at most this many margins is at its bound.
const AT_BOUND: f64 = 10.0;

/// Distance from a limit, in scales of the variable, that counts as none.
const AT_LIMIT: f64 = 1e-5;

/// Bodies, as positions among those of the fit, and rows of x that the constraints hold fixed.
pub(super) struct ActiveBounds {
    pub bodies: Vec<usize>,
    pub held: DMatrix<f64>,
    /// Unknowns and combinations at a limit, by name.
    pub at_limit: Vec<String>,
}

pub(super) fn find(found: &FeasibleFit<'_>, margin: f64) -> ActiveBounds {
    let x = &found.feasible.x;
    let values = found.standard.values(x);
    let slopes = found.standard.pseudo_inertias().matrix;
    let mut active = ActiveBounds {
        bodies: Vec::new(),
        held: DMatrix::zeros(0, x.len()),
        at_limit: Vec::new(),
    };
    let mut rows: Vec<RowDVector<f64>> = Vec::new();
    for (index, &first) in found.standard.bodies.iter().enumerate() {
        let eigen = SymmetricEigen::new(scaled_body(&values, first));
        let low: Vec<usize> = (0..4)
            .filter(|&k| eigen.eigenvalues[k] <= AT_BOUND * margin)
            .collect();
        if low.is_empty() {
            continue;
        }
        active.bodies.push(index);
        let part = slopes.rows(ROWS * index, ROWS);
        for (a, &i) in low.iter().enumerate() {
            for &j in &low[a..] {
                let (u, v) = (eigen.eigenvectors.column(i), eigen.eigenvectors.column(j));
                let product: Matrix4<f64> = (u * v.transpose() + v * u.transpose()) * 0.5;
                rows.push(RowDVector::from_row_slice(&svec4(&product)) * part);
            }
        }
    }
    for (k, variable) in found.constraints.variables.iter().enumerate() {
        let room = (x[k] - variable.lower).min(variable.upper - x[k]);
        if room <= AT_LIMIT * variable.scale {
            let mut row = RowDVector::zeros(x.len());
            row[k] = 1.0;
            rows.push(row);
            active.at_limit.push(variable.name.clone());
        }
    }
    let first = ROWS * found.standard.bodies.len();
    let whole = &found.constraints.constant + &found.constraints.slopes * x;
    let limits = &found.constraints.blocks[found.standard.bodies.len()..];
    for (k, limit) in limits.iter().enumerate() {
        if whole[first + k] <= AT_LIMIT {
            rows.push(found.constraints.slopes.row(first + k).into_owned());
            active.at_limit.push(limit.name.clone());
        }
    }
    if !rows.is_empty() {
        active.held = DMatrix::from_rows(&rows);
    }
    active
}

/// What the data ask of every body at its bound, the largest share first.
pub(super) fn bodies(
    found: &FeasibleFit<'_>,
    active: &ActiveBounds,
    control: &Control<'_>,
) -> Vec<BodyAtBound> {
    let base = &found.standard.to_base * &found.feasible.x;
    let Ok(residual) = compressed(&found.problem, &base) else {
        return Vec::new();
    };
    let rise = found.feasible.cost - found.feasible.unconstrained;
    let of = |&body: &usize| {
        let fewer = found.constraints.without(body);
        let mut setting = found.setting();
        setting.prior = None;
        let answer = constrained(setting, &fewer, &residual, control).ok()?;
        let x = answer.solution.x;
        let cost = residual.cost(&(&found.standard.to_base * &x));
        let first = found.standard.bodies[body];
        let values = found.standard.values(&x);
        let wanted = SymmetricEigen::new(scaled_body(&values, first))
            .eigenvalues
            .min();
        let name = found.standard.body_name(first);
        let share = if rise > 0.0 {
            ((found.feasible.cost - cost) / rise).clamp(0.0, 1.0)
        } else {
            0.0
        };
        Some(BodyAtBound {
            sentence: sentence(&name, &values, first),
            body: name,
            wanted,
            share,
        })
    };
    let mut bodies: Vec<BodyAtBound> = active.bodies.iter().filter_map(of).collect();
    bodies.sort_by(|a, b| b.share.total_cmp(&a.share));
    bodies
}

/// What is impossible about a body.
fn sentence(name: &str, values: &DVector<f64>, first: usize) -> String {
    let body = Inertia(std::array::from_fn(|k| values[first + k]));
    let mass = body.mass();
    if mass <= 0.0 {
        return format!(
            "without its constraint the data ask for a mass of {mass:.3e} kg of {name}"
        );
    }
    let j = body.pseudo_inertia();
    let h = body.first_moment();
    let central = j.fixed_view::<3, 3>(0, 0).into_owned() - h * h.transpose() / mass;
    let eigen = SymmetricEigen::new(central);
    let (k, least) = eigen.eigenvalues.argmin();
    if least >= 0.0 {
        return format!(
            "{name} is possible without its constraint as well: other bodies push it to its edge"
        );
    }
    let axis = eigen.eigenvectors.column(k);
    format!(
        "without its constraint the data ask for a second moment of {least:.3e} kg·m² of {name} along \
         ({:.2}, {:.2}, {:.2}) about its centre of mass: its inertia breaks the triangle inequality",
        axis[0], axis[1], axis[2]
    )
}
