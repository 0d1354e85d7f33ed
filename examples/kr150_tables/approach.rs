//! The three approaches, and the load that each gives.

use crate::Outcome;
use crate::experiment::open;
use exid::chain::parameter::Role;
use exid::estimate::fit::Fitted;
use exid::estimate::task;
use exid::outcome::parameter::Parameter;
use exid::problem::solution::Control;
use exid::robot::inertia::{Inertia, PER_LINK};
use exid::setup;
use nalgebra::{Cholesky, DMatrix, DVector};
use serde::Serialize;
use std::path::Path;

/// The reported parameters of a load.
pub const NAMES: [&str; PER_LINK] = [
    "mass",
    "com_x",
    "com_y",
    "com_z",
    "inertia_xx",
    "inertia_yy",
    "inertia_zz",
    "inertia_xy",
    "inertia_xz",
    "inertia_yz",
];

/// Values of [`NAMES`]: kg, m, kg·m².
pub type Load = [f64; PER_LINK];

/// Knowing what, and estimating what.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Approach {
    Linear,
    WithoutEfficiency,
    WithEfficiency,
}

impl Approach {
    pub const ALL: [Self; 3] = [Self::Linear, Self::WithoutEfficiency, Self::WithEfficiency];

    fn overrides(self) -> Vec<String> {
        let lines: &[&str] = match self {
            Self::Linear => &[
                "robot.inertials=estimate",
                "drive.effects=[\"coulomb_friction\", \"viscous_friction\", \"rotor_inertia\"]",
                "fit.estimator=wls",
            ],
            Self::WithoutEfficiency => {
                &["drive.effects=[\"coulomb_friction\", \"viscous_friction\"]"]
            }
            Self::WithEfficiency => &[],
        };
        lines.iter().map(|line| (*line).to_string()).collect()
    }
}

/// What an approach gives.
#[derive(Debug, Serialize)]
pub struct Result {
    pub load: Load,
    /// Root mean square torque error of axes 3 to 6, of the average over the periods, N·m.
    pub torque_error: Vec<f64>,
    pub iterations: u64,
    pub rank: usize,
    pub unknowns: usize,
}

/// The load of a recording by one approach.
pub fn estimate(problem: &Path, overrides: &[String], approach: Approach) -> Outcome<Result> {
    let mut problem = open(problem, overrides, &approach.overrides())?;
    let known = setup::robot::open(&problem)?.tree.parameters();
    if approach == Approach::Linear {
        // The load is a part of the last link, whose parameters are unknown like those of the others.
        problem.robot.payload = None;
    }
    let fitted = task::run(&problem, &Control::default(), |_| {})?.fitted;
    let solver = fitted.estimate.solver.as_ref();
    Ok(Result {
        load: match approach {
            Approach::Linear => from_base_parameters(&fitted, &known)?,
            _ => load_of(&fitted.estimate.parameters)?,
        },
        torque_error: fitted
            .estimate
            .joints
            .iter()
            .map(|j| j.rmse_train)
            .collect(),
        iterations: solver.map_or(0, |s| s.iterations),
        rank: fitted.fit.rank,
        unknowns: fitted.fit.unknowns,
    })
}

/// The load among reported parameters.
pub fn load_of(parameters: &[Parameter]) -> Outcome<Load> {
    let mut load = [0.0; PER_LINK];
    for (value, name) in load.iter_mut().zip(NAMES) {
        let wanted = format!("payload.{name}");
        let found = parameters.iter().find(|p| p.name == wanted);
        *value = found.and_then(|p| p.value).ok_or(format!("no {wanted}"))?;
    }
    Ok(load)
}

/// Solves `β = K π_known + K₆ π_load` for the load: the base parameters β of the robot with its load, less those
/// of the links without. The equations count by the covariance of β.
fn from_base_parameters(fitted: &Fitted, known: &[f64]) -> Outcome<Load> {
    let (model, posterior) = (&fitted.model, &fitted.fit.posterior);
    let last = model.tree().len() - 1;
    let count = posterior.combinations.len();
    let (mut rows, mut rest) = (DMatrix::zeros(count, PER_LINK), DVector::zeros(count));
    for (k, combination) in posterior.combinations.iter().enumerate() {
        rest[k] = combination.value;
        for term in &combination.terms {
            let at = model.find(&term.parameter)?;
            let parameter = &model.parameters()[at];
            if let Role::Inertial { link, .. } = parameter.role {
                rest[k] -= term.coefficient * known[at];
                if link == last {
                    rows[(k, at - PER_LINK * last)] += term.coefficient;
                }
            } else if term.parameter.contains("rotor_inertia") && combination.terms.len() > 1 {
                // A rotor that turns with a link alone shows only together with it.
                rest[k] -= term.coefficient * parameter.value;
            }
        }
    }
    let moved: Vec<usize> = (0..count).filter(|&k| rows.row(k).norm() > 0.0).collect();
    let covariance = DMatrix::from_fn(moved.len(), moved.len(), |i, j| {
        posterior.covariance[moved[i]][moved[j]]
    });
    let whiten = Cholesky::new(covariance)
        .ok_or("a singular covariance")?
        .l();
    let (rows, rest) = (rows.select_rows(&moved), rest.select_rows(&moved));
    let unsolvable = "equations that cannot be solved";
    let rows = whiten.solve_lower_triangular(&rows).ok_or(unsolvable)?;
    let rest = whiten.solve_lower_triangular(&rest).ok_or(unsolvable)?;
    let raw = rows.svd(true, true).solve(&rest, f64::EPSILON)?;
    let body = Inertia(std::array::from_fn(|k| raw[k]));
    let body = body.central().ok_or("a load without mass")?;
    let (c, i) = (body.centre, body.tensor);
    Ok([
        raw[0],
        c[0],
        c[1],
        c[2],
        i[(0, 0)],
        i[(1, 1)],
        i[(2, 2)],
        i[(0, 1)],
        i[(0, 2)],
        i[(1, 2)],
    ])
}
