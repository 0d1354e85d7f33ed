//! The report of a feasible fit: every parameter with its value and what that rests on, the certificate, and the cost of the
//! constraints.
//!
//! Standard deviations are those of the data without constraints, which the constraints can only narrow. With
//! a prior on the bodies, `C = A⁻¹ (Tᵀ A_β C_β A_β T + Λ) A⁻¹`, `A = Tᵀ A_β T + Λ`, A_β = RᵀR, Λ the prior's.

use crate::chain::dataset::Dataset;
use crate::estimate::derived::goodness_of_fit::{figures, predictions};
use crate::estimate::derived::physical::{self, Estimated, PhysicalEstimate};
use crate::estimate::derived::pseudo_inertia::{LENGTH, scaled_body};
use crate::estimate::feasible::active_bounds::{self, ActiveBounds};
use crate::estimate::feasible::prior::Sparsity;
use crate::estimate::feasible::program::{PULL, pull};
use crate::estimate::feasible::{FeasibleFit, MARGIN};
use crate::estimate::fit::{self, Fitted};
use crate::estimate::fit_problem::problem::FitProblem;
use crate::estimate::uncertainty::covariance::of_unknowns;
use crate::linalg::triangular::{ColumnScaling, Triangular};
use crate::outcome::estimate::{Estimate, Solver};
use crate::outcome::feasibility::{BodyPrior, Feasibility, Unconstrained};
use crate::outcome::fit::Fit;
use crate::problem::solution::Control;
use crate::problem_file::choices::{Choice, FeasibleBy, PriorKind};
use crate::robot::inertia::Inertia;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// A parameter is at a bound where the constraints leave less than this share of its variance.
const HELD: f64 = 0.01;

/// Weight of the pull while it is asked what constraints hold, per kg: undetermined directions move freely.
const LOOSE: f64 = 1e-2;

pub(super) fn report(found: &FeasibleFit<'_>, data: &Dataset, control: &Control<'_>) -> Fitted {
    let (problem, standard) = (&found.problem, found.standard);
    let model = problem.model;
    let x = &found.feasible.x;
    let values = standard.values(x);
    let base = &standard.to_base * x;
    let count = base.len();
    let of_base = of_unknowns(problem, &base)
        .unwrap_or_else(|| DMatrix::from_diagonal_element(count, count, f64::INFINITY));
    let active = active_bounds::find(found, MARGIN);
    let unknowns = standard.unknowns();
    let Uncertainty {
        covariance,
        from_prior,
    } = uncertainty(found, &of_base, data);
    let at_bound = at_bound(found, &active);
    let estimated = Estimated {
        model,
        unknowns: &unknowns,
        values: &values,
        covariance: &covariance,
        statistical: None,
        from_prior: &from_prior,
        at_bound: &at_bound,
        intervals: &[],
    };
    let PhysicalEstimate {
        parameters,
        covariance: reported_covariance,
    } = physical::report(&estimated);
    let predicted = predictions(model, &values, data);
    let factor = of_columns(problem, &base);
    let smallest = smallest_eigenvalue(&standard.bodies, &values);
    let feasibility = feasibility(found, &active, &values, data, control);
    let fit = Fit {
        base_parameters: fit::base_parameters(problem, &base, &of_base, &[]),
        rank: count,
        unknowns: fit::unknown_count(model),
        condition_number: factor.condition_number(ColumnScaling::UnitNorm),
        feasible: smallest.map(|least| least > 0.0),
        min_pseudo_inertia_eigenvalue: smallest,
        realization: fit::named(model, &values),
        posterior: fit::posterior(problem, &base, &of_base),
        feasibility: Some(feasibility),
        notes: prior_note(found).into_iter().collect(),
        ..Fit::default()
    };
    let estimate = Estimate {
        parameters,
        joints: figures(model, &values, data, &predicted),
        covariance: reported_covariance,
        solver: Some(solver(found)),
    };
    Fitted {
        estimate,
        fit,
        predictions: predicted,
        model: model.clone(),
        values,
    }
}

/// How the estimate was found.
fn solver(found: &FeasibleFit<'_>) -> Solver {
    let feasible = &found.feasible;
    Solver {
        name: match found.by {
            FeasibleBy::Cones => "interior point".to_string(),
            FeasibleBy::LogCholesky => "Levenberg-Marquardt in a log-Cholesky chart".to_string(),
        },
        stop: feasible.stop.name().to_string(),
        converged: feasible.stop.converged(),
        iterations: feasible.iterations as u64,
        evaluations: feasible.iterations as u64,
        cost: feasible.cost,
    }
}

/// What the prior on the bodies is, how its weight came about, and what a lasso takes away.
fn prior_note(found: &FeasibleFit<'_>) -> Option<String> {
    let (prior, chosen) = found.prior.as_ref()?;
    let by = match chosen.by {
        "held_out" => format!(
            "has the least error on blocks of the training recordings that were held out in turn, among {} strengths \
             from {:.0e} to {:.0e}",
            chosen.path.len(),
            chosen.path.first().map_or(0.0, |p| p.strength),
            chosen.path.last().map_or(0.0, |p| p.strength)
        ),
        "noise" => "leaves residuals as large as the noise".to_string(),
        _ => "was given".to_string(),
    };
    let mut note = format!(
        "The {} prior has the strength {:.3e}, which {by}.",
        prior.kind.word(),
        chosen.weight
    );
    if prior.kind == PriorKind::Lasso {
        let Sparsity { counted, zero } = prior.sparsity(&found.feasible.x);
        note.push_str(&format!(
            " It takes {zero} of {counted} parameters to zero; standard deviations do not count how it shrinks the others."
        ));
    }
    Some(note)
}

/// Triangular factor of the columns of the base parameters.
fn of_columns(problem: &FitProblem<'_>, base: &DVector<f64>) -> Triangular {
    let whole = problem.factor(base).matrix();
    Triangular::of(&whole.columns(0, base.len()).into_owned())
}

/// Least eigenvalue over the pseudo-inertias of bodies; `None` without bodies.
fn smallest_eigenvalue(bodies: &[usize], values: &DVector<f64>) -> Option<f64> {
    let of = |&first: &usize| {
        let body = Inertia(std::array::from_fn(|k| values[first + k]));
        SymmetricEigen::new(body.pseudo_inertia()).eigenvalues.min()
    };
    bodies.iter().map(of).reduce(f64::min)
}

/// How well the standard unknowns are known.
struct Uncertainty {
    covariance: DMatrix<f64>,
    /// Unknowns that only a prior determines.
    from_prior: Vec<usize>,
}

fn uncertainty(found: &FeasibleFit<'_>, of_base: &DMatrix<f64>, data: &Dataset) -> Uncertainty {
    let standard = found.standard;
    let size = standard.len();
    let determined: Vec<Option<usize>> = (0..size).map(|k| base_of(found, k)).collect();
    let by_prior = fit::determined_by_prior(&found.problem, data);
    let Some((prior, chosen)) = &found.prior else {
        let mut covariance = DMatrix::zeros(size, size);
        for (i, a) in determined.iter().enumerate() {
            for (j, b) in determined.iter().enumerate() {
                if let (Some(a), Some(b)) = (a, b) {
                    covariance[(i, j)] = of_base[(*a, *b)];
                }
            }
        }
        let from = |k: &usize| determined[*k].is_some_and(|b| by_prior.contains(&b));
        return Uncertainty {
            covariance,
            from_prior: (0..size).filter(from).collect(),
        };
    };
    let data_information = information(found);
    let weak = pull(standard, &standard.reference(), PULL).matrix;
    let prior_information =
        prior.information(chosen.weight, &found.feasible.x) + weak.tr_mul(&weak);
    let t = &standard.to_base;
    let whole = t.tr_mul(&(&data_information * t)) + &prior_information;
    let meat = t.tr_mul(&(&data_information * of_base * &data_information * t)) + prior_information;
    let from = (0..size).filter(|&k| determined[k].is_none_or(|b| by_prior.contains(&b)));
    let covariance = match whole.cholesky() {
        Some(factor) => {
            let half = factor.solve(&meat);
            let covariance = factor.solve(&half.transpose());
            (&covariance + covariance.transpose()) * 0.5
        }
        None => DMatrix::from_diagonal_element(size, size, f64::INFINITY),
    };
    Uncertainty {
        covariance,
        from_prior: from.collect(),
    }
}

/// RᵀR over base unknowns.
fn information(found: &FeasibleFit<'_>) -> DMatrix<f64> {
    let base = &found.standard.to_base * &found.feasible.x;
    let whole = found.problem.factor(&base).matrix();
    let matrix = whole.columns(0, base.len());
    matrix.tr_mul(&matrix)
}

/// The base unknown that an unknown is by itself.
fn base_of(found: &FeasibleFit<'_>, k: usize) -> Option<usize> {
    let t = &found.standard.to_base;
    let rows: Vec<usize> = (0..t.nrows()).filter(|&r| t[(r, k)] != 0.0).collect();
    match rows[..] {
        [row] if t.row(row).iter().filter(|c| **c != 0.0).count() == 1 => Some(row),
        _ => None,
    }
}

/// Unknowns whose value constraints decide: those that data and prior leave open, and those of whose variance
/// the active constraints leave next to nothing.
fn at_bound(found: &FeasibleFit<'_>, active: &ActiveBounds) -> Vec<usize> {
    let size = found.standard.len();
    let open = |k: &usize| found.prior.is_none() && base_of(found, *k).is_none();
    if active.held.nrows() == 0 {
        return (0..size).filter(open).collect();
    }
    let standard = found.standard;
    let weak = pull(standard, &standard.reference(), PULL).matrix;
    let weak = &weak * (LOOSE / weak.amax());
    let t = &standard.to_base;
    let whole = t.tr_mul(&(information(found) * t)) + weak.tr_mul(&weak);
    let Some(factor) = whole.cholesky() else {
        return (0..size).filter(open).collect();
    };
    let covariance = factor.inverse();
    let across = &covariance * active.held.transpose();
    let own = &active.held * &across;
    let rounding = 1e-12 * own.amax();
    let gone = own
        .pseudo_inverse(rounding)
        .map(|inverse| &across * inverse * across.transpose());
    let kept = |k: usize| match &gone {
        Ok(gone) => (covariance[(k, k)] - gone[(k, k)]) / covariance[(k, k)],
        Err(_) => 1.0,
    };
    (0..size).filter(|k| open(k) || kept(*k) < HELD).collect()
}

fn feasibility(
    found: &FeasibleFit<'_>,
    active: &ActiveBounds,
    values: &DVector<f64>,
    data: &Dataset,
    control: &Control<'_>,
) -> Feasibility {
    let feasible = &found.feasible;
    let model = found.problem.model;
    let free = found.problem.parameters(&found.free);
    let least = |&first: &usize| {
        SymmetricEigen::new(scaled_body(values, first))
            .eigenvalues
            .min()
    };
    let bodies = found.standard.bodies.iter();
    let unconstrained = figures(model, &free, data, &predictions(model, &free, data));
    Feasibility {
        margin: MARGIN,
        length: LENGTH,
        least_eigenvalue: bodies.map(least).fold(f64::INFINITY, f64::min),
        gap: feasible.gap,
        stationarity: feasible.stationarity,
        inactive: feasible.inactive,
        cost_unconstrained: feasible.unconstrained,
        cost: feasible.cost,
        prior: found.prior.as_ref().map(|(prior, chosen)| BodyPrior {
            kind: prior.kind.word().to_string(),
            strength: chosen.weight,
            chosen_by: chosen.by.to_string(),
            path: chosen.path.clone(),
        }),
        unconstrained: unconstrained
            .into_iter()
            .map(|joint| Unconstrained {
                joint: joint.joint,
                unit: joint.unit,
                rmse_train: joint.rmse_train,
                rmse_validation: joint.rmse_validation,
            })
            .collect(),
        bodies: if feasible.inactive {
            Vec::new()
        } else {
            active_bounds::bodies(found, active, control)
        },
        at_limit: active.at_limit.clone(),
    }
}
