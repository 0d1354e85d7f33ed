//! Checks of a problem against itself, written once for all: derivatives against central differences
//! (f(x + h e) - f(x - h e)) / 2h, the square root against the gradient, and affinity where it is claimed.

use nalgebra::DVector;

use crate::problem::form::{Form, Objective};
use crate::problem::{Linearization, OutsideDomain, Problem, Values};

/// Central differences in double precision agree with a right derivative within this relative error:
/// the step eps^(1/3) leaves a truncation error of order eps^(2/3) = 4e-11, times the curvature over
/// the scales of the variables, for which four digits are allowed.
pub const DERIVATIVE_TOLERANCE: f64 = 1e-6;

/// An affine problem agrees with its linearisation elsewhere within this relative error: rounding.
pub const AFFINITY_TOLERANCE: f64 = 1e-10;

/// Rounding errors of a computed value, in units of the last place, that a check forgives.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Where a problem differs most from what it claims.
#[derive(Debug, Clone, PartialEq)]
pub struct CheckReport {
    /// The worst entry of each quantity, worst first.
    pub mismatches: Vec<Mismatch>,
}

/// One compared entry.
#[derive(Debug, Clone, PartialEq)]
pub struct Mismatch {
    /// `cost`, `square root`, or the name of a constraint row.
    pub quantity: String,
    /// The variable of the derivative, or the direction of the check.
    pub variable: String,
    /// What the problem says.
    pub claimed: f64,
    /// What differences of its values give.
    pub found: f64,
    /// |claimed - found|, less what rounding explains, over the larger of both.
    pub relative: f64,
}

impl CheckReport {
    /// Whether every entry agrees: relative <= tolerance.
    pub fn holds(&self, tolerance: f64) -> bool {
        self.mismatches.iter().all(|m| m.relative <= tolerance)
    }

    fn from_entries(mut entries: Vec<Mismatch>) -> Self {
        entries.sort_by(|a, b| b.relative.total_cmp(&a.relative));
        let mut mismatches: Vec<Mismatch> = Vec::new();
        for entry in entries {
            if mismatches.iter().all(|m| m.quantity != entry.quantity) {
                mismatches.push(entry);
            }
        }
        Self { mismatches }
    }
}

/// A compared entry whose difference up to `noise` is rounding.
fn compare(quantity: &str, variable: &str, claimed: f64, found: f64, noise: f64) -> Mismatch {
    let size = claimed.abs().max(found.abs());
    let excess = ((claimed - found).abs() - noise).max(0.0);
    let relative = if excess == 0.0 { 0.0 } else { excess / size };
    Mismatch {
        quantity: quantity.to_string(),
        variable: variable.to_string(),
        claimed,
        found,
        // NaN anywhere is the worst mismatch.
        relative: if (claimed - found).is_nan() {
            f64::INFINITY
        } else {
            relative
        },
    }
}

/// Compares gradient and jacobian at x with central differences, and matrixᵀ residual with the gradient.
///
/// The step is eps^(1/3) max(|x|, scale) per variable; x needs that much room inside the domain.
pub fn derivative_check(
    problem: &dyn Problem,
    x: &DVector<f64>,
) -> Result<CheckReport, OutsideDomain> {
    let form = problem.form();
    let model = problem.linearize(x)?;
    let mut entries = consistency(problem, x, &model)?;
    for (j, variable) in form.variables.iter().enumerate() {
        let step = f64::EPSILON.cbrt() * x[j].abs().max(variable.scale);
        let at = |shift: f64| {
            let mut shifted = x.clone();
            shifted[j] += shift;
            let moved = shifted[j] - x[j];
            problem.values(&shifted).map(|v| (v, moved))
        };
        let ((above, up), (below, down)) = (at(step)?, at(-step)?);
        let width = up - down;
        let mut check = |name: &str, claimed: f64, high: f64, low: f64| {
            let noise = ROUNDING * (high.abs() + low.abs()) / width;
            let found = (high - low) / width;
            entries.push(compare(name, &variable.name, claimed, found, noise));
        };
        check("cost", model.gradient[j], above.cost, below.cost);
        for row in 0..form.constraint_rows() {
            let (high, low) = (above.constraints[row], below.constraints[row]);
            check(&form.row_name(row), model.jacobian[(row, j)], high, low);
        }
    }
    Ok(CheckReport::from_entries(entries))
}

/// Values against the linearisation at the same point, and matrixᵀ residual against the gradient.
fn consistency(
    problem: &dyn Problem,
    x: &DVector<f64>,
    model: &Linearization,
) -> Result<Vec<Mismatch>, OutsideDomain> {
    let form = problem.form();
    let values = problem.values(x)?;
    let noise = ROUNDING * values.cost.abs();
    let mut entries = vec![compare("cost", "itself", model.cost, values.cost, noise)];
    for row in 0..form.constraint_rows() {
        let (claimed, found) = (model.constraints[row], values.constraints[row]);
        let noise = ROUNDING * found.abs();
        entries.push(compare(
            &form.row_name(row),
            "itself",
            claimed,
            found,
            noise,
        ));
    }
    match (&form.objective, &model.square_root) {
        (Objective::Smooth, _) => {}
        (Objective::SumOfSquares { .. }, None) => {
            entries.push(compare("square root", "missing", f64::NAN, 0.0, 0.0));
        }
        (Objective::SumOfSquares { .. }, Some(root)) => {
            let found = root.matrix.tr_mul(&root.residual);
            let size = root.matrix.abs().tr_mul(&root.residual.abs());
            for (j, variable) in form.variables.iter().enumerate() {
                let rows = root.residual.len() as f64;
                let noise = ROUNDING * rows.max(1.0) * size[j];
                entries.push(compare(
                    "square root",
                    &variable.name,
                    model.gradient[j],
                    found[j],
                    noise,
                ));
            }
        }
    }
    Ok(entries)
}

/// Compares a problem that claims to be affine with its linearisation at x, at points one and a
/// thousand scales away along fixed directions.
pub fn affinity_check(
    problem: &dyn Problem,
    x: &DVector<f64>,
) -> Result<CheckReport, OutsideDomain> {
    let form = problem.form();
    let model = problem.linearize(x)?;
    let mut entries = Vec::new();
    for (name, sign, distance) in [
        ("all up", 1.0, 1.0),
        ("alternating", -1.0, 1.0),
        ("all far up", 1.0, 1e3),
        ("alternating far", -1.0, 1e3),
    ] {
        let step = DVector::from_iterator(
            x.len(),
            form.variables.iter().enumerate().map(|(j, v)| {
                // Lengths that differ keep curvatures of two variables from cancelling.
                let length = 1.0 + j as f64 / (1.0 + x.len() as f64);
                distance * length * v.scale * if j % 2 == 0 { 1.0 } else { sign }
            }),
        );
        match problem.values(&(x + &step)) {
            Ok(found) => {
                compare_with_model(form, name, &model, &step, &found, &mut entries);
            }
            // An affine problem has a value everywhere.
            Err(_) => entries.push(compare("domain", name, f64::NAN, 0.0, 0.0)),
        }
    }
    Ok(CheckReport::from_entries(entries))
}

fn compare_with_model(
    form: &Form,
    direction: &str,
    model: &Linearization,
    step: &DVector<f64>,
    found: &Values,
    entries: &mut Vec<Mismatch>,
) {
    let slope = model.gradient.dot(step);
    let curvature = match &model.square_root {
        Some(root) => 0.5 * (&root.matrix * step).norm_squared(),
        None => 0.0,
    };
    let size = model.cost.abs() + slope.abs() + curvature;
    entries.push(compare(
        "cost",
        direction,
        model.cost + slope + curvature,
        found.cost,
        ROUNDING * size,
    ));
    let rows = &model.constraints + &model.jacobian * step;
    let sizes = model.constraints.abs() + model.jacobian.abs() * step.abs();
    for row in 0..form.constraint_rows() {
        entries.push(compare(
            &form.row_name(row),
            direction,
            rows[row],
            found.constraints[row],
            ROUNDING * sizes[row],
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::examples;
    use crate::problem::form::Structure;

    #[test]
    fn every_example_has_right_derivatives() {
        for example in examples::all() {
            let report = derivative_check(example.problem.as_ref(), &example.start).unwrap();
            assert!(
                report.holds(DERIVATIVE_TOLERANCE),
                "{}: {report:?}",
                example.name
            );
        }
    }

    #[test]
    fn every_example_is_affine_where_it_says_so_and_only_there() {
        for example in examples::all() {
            let problem = example.problem.as_ref();
            let report = affinity_check(problem, &example.start).unwrap();
            let claims = problem.form().structure == Structure::Affine;
            assert_eq!(
                report.holds(AFFINITY_TOLERANCE),
                claims,
                "{}: {report:?}",
                example.name
            );
        }
    }

    #[test]
    fn finds_a_wrong_entry_of_each_kind() {
        type Spoil = fn(&mut Linearization);
        let spoil: [(&str, Spoil); 4] = [
            ("cost", |m| m.gradient[1] *= 1.001),
            ("matrix[2]", |m| m.jacobian[(2, 1)] += 1e-3),
            ("square root", |m| {
                if let Some(root) = &mut m.square_root {
                    root.matrix[(0, 0)] *= 1.001;
                }
            }),
            ("square root", |m| m.square_root = None),
        ];
        for (quantity, spoil) in spoil {
            let mut problem = examples::nearest_psd();
            problem.spoil = Some(spoil);
            let x = DVector::from_vec(vec![0.3, -0.7, 0.2]);
            let report = derivative_check(&problem, &x).unwrap();
            let found = |m: &Mismatch| m.quantity == quantity && m.relative > DERIVATIVE_TOLERANCE;
            assert!(
                report.mismatches.iter().any(found),
                "{quantity}: {report:?}"
            );
        }
    }
}
