//! What uncertain torque constants add to the covariance of an estimate from currents (type B: JCGM 100:2008, 4.3).
//!
//! A torque τ(i) that is larger than declared by the share ε moves the predicted current by −ε u, with u = τ/τ', the
//! current itself where one constant says all, and with it the optimum:
//!
//! ```text
//! dx/dε_c = B Xᵀ W u_c,   B = (XᵀX + PᵀP)⁻¹,   v = Σ_c σ_c dx/dε_c,   C = v vᵀ
//! ```
//!
//! with the weighted derivatives X, the prior's rows P, u_c in channel c alone and the relative standard deviation σ_c of
//! its constant. Errors of all
//! constants are taken as one, as warm magnets and a common data sheet make them: such an error scales every mass alike and
//! leaves nothing to see, where constants that err apart leave residuals. No recording makes it smaller. Where the gain of a drive is estimated it takes up the
//! error of the constant, and nothing else does.

use crate::chain::model::Signal;
use crate::estimate::fit_problem::problem::FitProblem;
use crate::estimate::residual::rows::{RowBlock, tasks, visit};
use crate::estimate::uncertainty::covariance::inverse_over_determined;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Relative standard deviation of a torque constant of which nothing is stated: data sheets give ±10 %, which holds 95 %.
pub const OF_DATA_SHEETS: f64 = 0.05;

/// Covariance of the unknowns at the optimum x, `deviations` being relative, one for each joint; `None` where the signal
/// is no current or every constant is certain.
pub fn covariance(
    problem: &FitProblem<'_>,
    x: &DVector<f64>,
    deviations: &[f64],
) -> Option<DMatrix<f64>> {
    if problem.model.signal() != Signal::Current || deviations.iter().all(|s| *s == 0.0) {
        return None;
    }
    let inverse = inverse_over_determined(problem, x)?;
    let values = problem.parameters(x);
    let right = right_sides(problem, &values);
    let positions = problem.unknowns.positions();
    let mut together = DVector::zeros(x.len());
    for (c, channel) in problem.model.channels().iter().enumerate() {
        let Some(joint) = channel.joint.filter(|_| channel.active) else {
            continue;
        };
        let moved = match problem.model.joints()[joint].gain {
            Some(gain) => DVector::from_iterator(
                x.len(),
                positions.iter().map(|&p| match p == gain {
                    true => -values[gain],
                    false => 0.0,
                }),
            ),
            None => &inverse * (inverse.transpose() * right.column(c)),
        };
        together += deviations[joint] * moved;
    }
    Some(&together * together.transpose())
}

/// `Xᵀ W u_c` in a column for each channel c.
fn right_sides(problem: &FitProblem<'_>, values: &DVector<f64>) -> DMatrix<f64> {
    let positions = problem.unknowns.positions();
    let channels = problem.model.channels().len();
    let weights = problem.weights().matrix();
    let squared = weights.transpose() * &weights;
    let of = |index: usize| {
        let mut part = DMatrix::zeros(positions.len(), channels);
        let recording = problem.recordings[index];
        for task in tasks(problem.model, std::iter::once(recording)) {
            visit(problem.model, values, &positions, &task, |block| {
                let factors = |c: usize| row_factors(problem, index, c, block);
                let factors: Vec<Vec<f64>> = (0..channels).map(factors).collect();
                let times = |c: usize, series: &[f64]| -> Vec<f64> {
                    series.iter().zip(&factors[c]).map(|(x, f)| x * f).collect()
                };
                let moved = |c: usize| times(c, &moved(problem, values, c, block.predicted(c)));
                let moved: Vec<Vec<f64>> = (0..channels).map(moved).collect();
                for (j, k) in (0..channels).flat_map(|j| (0..positions.len()).map(move |k| (j, k)))
                {
                    let Some(derivative) = block.derivative(j, k) else {
                        continue;
                    };
                    let own = times(j, derivative);
                    for (c, moved) in moved.iter().enumerate() {
                        let product = own.iter().zip(moved).map(|(a, b)| a * b);
                        part[(k, c)] += squared[(j, c)] * product.sum::<f64>();
                    }
                }
            });
        }
        part
    };
    let recordings = 0..problem.recordings.len();
    let parts: Vec<DMatrix<f64>> = recordings.into_par_iter().map(of).collect();
    let none = DMatrix::zeros(positions.len(), channels);
    parts.iter().fold(none, |sum, part| sum + part)
}

/// τ/τ' of a channel at its predicted currents.
fn moved(
    problem: &FitProblem<'_>,
    values: &DVector<f64>,
    channel: usize,
    predicted: &[f64],
) -> Vec<f64> {
    let joint = problem.model.channels()[channel].joint;
    let polynomial = joint.and_then(|joint| problem.model.joints()[joint].polynomial);
    let Some(first) = polynomial else {
        return predicted.to_vec();
    };
    let c: [f64; 4] = std::array::from_fn(|k| values[first + k]);
    let of = |current: &f64| {
        let i = current.abs();
        let torque = c[0] + i * (c[1] + i * (c[2] + i * c[3]));
        let slope = c[1] + i * (2.0 * c[2] + 3.0 * i * c[3]);
        current.signum() * torque / slope
    };
    predicted.iter().map(of).collect()
}

/// Factors of the rows of a block in one channel; 0 of those that do not count.
fn row_factors(
    problem: &FitProblem<'_>,
    recording: usize,
    channel: usize,
    block: &RowBlock<'_>,
) -> Vec<f64> {
    let active = f64::from(u8::from(problem.model.channels()[channel].active));
    let counts = block.counting();
    let factors = problem.factors.as_ref().map(|all| &all[recording][channel]);
    let of = |k: usize| match counts.as_ref().is_none_or(|counts| counts[k]) {
        true => active * factors.map_or(1.0, |factors| factors[block.start() + k]),
        false => 0.0,
    };
    (0..block.range.len()).map(of).collect()
}
