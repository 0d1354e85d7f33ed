//! A physically possible member of the estimate's equivalence class: link parameters with the same base
//! parameters, hence the same torques, whose pseudo-inertias are all positive definite.
//!
//! With `π = π_0 + N z` (π_0 the estimate, z the parameters that base parameters stand for),
//!
//! ```text
//! maximise t   subject to   D J_k(π) D − t·1 ⪰ 0 for every link k,   t <= t_max
//! minimise ‖π − π_reference‖²   subject to   D J_k(π) D − ½ t*·1 ⪰ 0
//! ```
//!
//! D measures lengths in units in which masses and second moments have one size. Where t* is not positive no member is
//! possible, and the robot that is nearest by the covariance C = L Lᵀ of the unknowns takes its place, friction and all
//! else moved along with the bodies:
//!
//! ```text
//! minimise ½ ‖u‖² + ½ ε² ‖D (J − J_reference) D‖²   subject to   D J_k(π_0 + N z + E L u) D − margin·1 ⪰ 0
//! ```

use crate::chain::effect::Linearity;
use crate::chain::model::Model;
use crate::chain::parameter::Role;
use crate::estimate::fit_problem::unknowns::Unknowns;
use crate::linalg::svec::svec;
use crate::problem::form::{Constraint, Form, Objective, Set, Structure, Variable};
use crate::problem::solution::Control;
use crate::problem::view::ConeProgram;
use crate::problem::{Linearization, OutsideDomain, Problem, SquareRoot, Values};
use crate::robot::inertia::{Inertia, PER_LINK};
use crate::solve::conic::{self, Settings};
use nalgebra::{DMatrix, DVector, Matrix4, SymmetricEigen};

/// Length unit of the scaled pseudo-inertias, m: a typical radius of gyration of robot links.
pub(crate) const LENGTH: f64 = 0.1;

/// Largest margin that is asked for, kg: beyond it a body is as good as any, and links without effect on
/// the signal would grow without limit.
const LARGEST_MARGIN: f64 = 0.05;

/// Rows of the svec of a pseudo-inertia.
const ROWS: usize = 10;

/// A member of the class, and how far inside the physical bodies it lies.
#[derive(Debug, Clone, PartialEq)]
pub struct Realization {
    /// Values of all parameters.
    pub values: DVector<f64>,
    /// Smallest eigenvalue of a pseudo-inertia (kg, kg·m², kg·m mixed as they come).
    pub smallest_eigenvalue: f64,
    /// Every pseudo-inertia is positive definite.
    pub feasible: bool,
}

/// Bodies whose parameters are not all known: position of their first parameter.
pub(crate) fn bodies(model: &Model) -> Vec<usize> {
    let links = (0..model.tree().len()).map(|link| PER_LINK * link);
    let payload = model.payload().map(|(_, first)| first);
    links
        .chain(payload)
        .filter(|&first| (first..first + PER_LINK).any(|p| model.parameters()[p].is_free()))
        .collect()
}

/// Finds the member that is possible and closest to the reference (the robot file's bodies); `None`
/// where no body is unknown or the solver fails.
pub fn find(model: &Model, unknowns: &Unknowns, values: &DVector<f64>) -> Option<Realization> {
    let bodies = bodies(model);
    if bodies.is_empty() {
        return None;
    }
    let class = EquivalenceClass::new(model, unknowns, values, &bodies);
    let margin = class.largest_margin()?;
    let chosen = if margin > 0.0 {
        class
            .closest(0.5 * margin)
            .or_else(|| class.most_interior())?
    } else {
        class.most_interior()?
    };
    let smallest = bodies
        .iter()
        .map(|&first| smallest_eigenvalue(&chosen, first))
        .fold(f64::INFINITY, f64::min);
    Some(Realization {
        values: chosen,
        smallest_eigenvalue: smallest,
        feasible: smallest > 0.0,
    })
}

/// Least scaled pseudo-inertia of a nearest possible body, kg: simulators divide by it.
const NEAREST_MARGIN: f64 = 1e-3;

/// Weight ε of the reference, 1/kg: it chooses among robots that the recordings do not tell apart, at a cost in fit that
/// does not count.
const REFERENCE_WEIGHT: f64 = 1e-2;

/// Values of the possible robot that is nearest to an estimate by its covariance, with nonlinear parameters as they are: along them
/// torques are linear for a small step alone. `None` where no body is unknown, unknowns are undetermined, or the solver fails.
pub fn nearest(
    model: &Model,
    unknowns: &Unknowns,
    values: &DVector<f64>,
    covariance: &DMatrix<f64>,
) -> Option<DVector<f64>> {
    let bodies = bodies(model);
    if bodies.is_empty() || !covariance.iter().all(|c| c.is_finite()) {
        return None;
    }
    let class = EquivalenceClass::new(model, unknowns, values, &bodies);
    let positions = unknowns.positions();
    let is_held = |&k: &usize| {
        let parameter = &model.parameters()[positions[k]];
        parameter.linearity == Linearity::Nonlinear
    };
    let held: Vec<usize> = (0..positions.len()).filter(is_held).collect();
    class.nearest(&positions, &given(covariance, &held))
}

/// The covariance of unknowns where some are known: `C − C_h C_hh⁺ C_hᵀ`, the Schur complement of theirs.
fn given(covariance: &DMatrix<f64>, held: &[usize]) -> DMatrix<f64> {
    if held.is_empty() {
        return covariance.clone();
    }
    let theirs = covariance.select_rows(held).select_columns(held);
    let with = covariance.select_columns(held);
    let eigen = theirs.symmetric_eigen();
    let rounding = f64::EPSILON * eigen.eigenvalues.amax();
    let mut left = covariance.clone();
    for (direction, variance) in eigen.eigenvectors.column_iter().zip(&eigen.eigenvalues) {
        if *variance > rounding {
            let along = &with * direction;
            left -= &along * along.transpose() / *variance;
        }
    }
    left
}

fn smallest_eigenvalue(values: &DVector<f64>, first: usize) -> f64 {
    let body = Inertia(std::array::from_fn(|k| values[first + k]));
    SymmetricEigen::new(body.pseudo_inertia()).eigenvalues.min()
}

/// The equivalence class `π_0 + N z`.
struct EquivalenceClass<'a> {
    values: &'a DVector<f64>,
    reference: DVector<f64>,
    bodies: &'a [usize],
    /// Parameters that move freely: position and the kept parameters that give way, with factors.
    free: Vec<(usize, Vec<(usize, f64)>)>,
    /// Rows of the scaled pseudo-inertias at z = 0, and per unit of every z.
    constant: DVector<f64>,
    slopes: DMatrix<f64>,
}

impl<'a> EquivalenceClass<'a> {
    fn new(
        model: &Model,
        unknowns: &Unknowns,
        values: &'a DVector<f64>,
        bodies: &'a [usize],
    ) -> Self {
        let mut free: Vec<(usize, Vec<(usize, f64)>)> = Vec::new();
        let is_body = |p: usize| {
            matches!(
                model.parameters()[p].role,
                Role::Inertial { .. } | Role::Payload { .. }
            )
        };
        let gives_way =
            |p: usize| is_body(p) || matches!(model.parameters()[p].role, Role::Tare { .. });
        for &parameter in &unknowns.base.without_effect {
            free.push((parameter, Vec::new()));
        }
        for base in &unknowns.base.base {
            for &(parameter, coefficient) in &base.others {
                let entry = (base.parameter, -coefficient);
                match free.iter_mut().find(|(p, _)| *p == parameter) {
                    Some((_, gives)) => gives.push(entry),
                    None => free.push((parameter, vec![entry])),
                }
            }
        }
        free.retain(|(p, gives)| is_body(*p) && gives.iter().all(|(k, _)| gives_way(*k)));
        let rows = |v: &DVector<f64>| {
            let stacked = bodies.iter().flat_map(|&first| scaled_rows(v, first));
            DVector::from_iterator(bodies.len() * ROWS, stacked)
        };
        let constant = rows(values);
        let mut slopes = DMatrix::zeros(constant.len(), free.len());
        for (k, (parameter, gives)) in free.iter().enumerate() {
            let mut direction = DVector::zeros(values.len());
            direction[*parameter] = 1.0;
            for (kept, factor) in gives {
                direction[*kept] += factor;
            }
            slopes.set_column(k, &rows(&direction));
        }
        let mut reference = DVector::zeros(values.len());
        for (p, value) in model.tree().parameters().into_iter().enumerate() {
            reference[p] = value;
        }
        Self {
            values,
            reference,
            bodies,
            free,
            constant,
            slopes,
        }
    }

    fn member(&self, z: &DVector<f64>) -> DVector<f64> {
        let mut values = self.values.clone();
        for ((parameter, gives), z) in self.free.iter().zip(z.iter()) {
            values[*parameter] += z;
            for (kept, factor) in gives {
                values[*kept] += factor * z;
            }
        }
        values
    }

    fn solve_margin(&self) -> Option<DVector<f64>> {
        let count = self.free.len();
        let mut slopes = self.slopes.clone().resize_horizontally(count + 1, 0.0);
        for (body, _) in self.bodies.iter().enumerate() {
            let identity = svec4(&Matrix4::identity());
            for (row, value) in identity.iter().enumerate() {
                slopes[(body * ROWS + row, count)] = -value;
            }
        }
        let mut gradient = DVector::zeros(count + 1);
        gradient[count] = -1.0;
        let mut variables: Vec<Variable> = (0..count).map(|_| Variable::free("z", "")).collect();
        variables.push(Variable::free("margin", "kg").within(f64::NEG_INFINITY, LARGEST_MARGIN));
        let program = Bodies {
            form: self.form(variables, Objective::Smooth),
            linear: gradient,
            square_root: None,
            constant: self.constant.clone(),
            slopes,
        };
        program.solve()
    }

    /// t*, kg.
    fn largest_margin(&self) -> Option<f64> {
        let solution = self.solve_margin()?;
        Some(solution[self.free.len()])
    }

    fn most_interior(&self) -> Option<DVector<f64>> {
        let solution = self.solve_margin()?;
        let z = solution.rows(0, self.free.len()).into_owned();
        Some(self.member(&z))
    }

    /// The member closest to the reference with at least the given margin.
    fn closest(&self, margin: f64) -> Option<DVector<f64>> {
        let count = self.free.len();
        let mut constant = self.constant.clone();
        let identity = svec4(&Matrix4::identity());
        for (body, _) in self.bodies.iter().enumerate() {
            for (row, value) in identity.iter().enumerate() {
                constant[body * ROWS + row] -= margin * value;
            }
        }
        // Distance in the scaled pseudo-inertias, so that masses and inertias count alike.
        let target = self.rows(&self.reference);
        let program = Bodies {
            form: self.form(
                (0..count).map(|_| Variable::free("z", "")).collect(),
                Objective::SumOfSquares {
                    rows: self.constant.len(),
                },
            ),
            linear: DVector::zeros(count),
            square_root: Some((self.slopes.clone(), &self.constant - target)),
            constant,
            slopes: self.slopes.clone(),
        };
        program.solve().map(|z| self.member(&z))
    }

    /// The possible robot whose unknowns, at these positions, lie nearest by their covariance.
    fn nearest(&self, positions: &[usize], covariance: &DMatrix<f64>) -> Option<DVector<f64>> {
        let eigen = covariance.clone().symmetric_eigen();
        let mut moves = eigen.eigenvectors;
        for (mut column, variance) in moves.column_iter_mut().zip(&eigen.eigenvalues) {
            column *= variance.max(0.0).sqrt();
        }
        let (free, count) = (self.free.len(), positions.len());
        let mut slopes = self.slopes.clone().resize_horizontally(free + count, 0.0);
        let moved = |u: usize| {
            let mut direction = DVector::zeros(self.values.len());
            for (k, &p) in positions.iter().enumerate() {
                direction[p] = moves[(k, u)];
            }
            direction
        };
        for u in 0..count {
            slopes.set_column(free + u, &self.rows(&moved(u)));
        }
        let mut constant = self.constant.clone();
        let identity = svec4(&Matrix4::identity());
        for (body, _) in self.bodies.iter().enumerate() {
            for (row, value) in identity.iter().enumerate() {
                constant[body * ROWS + row] -= NEAREST_MARGIN * value;
            }
        }
        let rows = self.constant.len();
        let mut square_root = DMatrix::zeros(count + rows, free + count);
        square_root
            .view_mut((0, free), (count, count))
            .fill_with_identity();
        square_root
            .view_mut((count, 0), (rows, free + count))
            .copy_from(&(&slopes * REFERENCE_WEIGHT));
        let mut offset = DVector::zeros(count + rows);
        offset
            .rows_mut(count, rows)
            .copy_from(&((&self.constant - self.rows(&self.reference)) * REFERENCE_WEIGHT));
        let variables = (0..free + count).map(|_| Variable::free("z", "")).collect();
        let program = Bodies {
            form: self.form(variables, Objective::SumOfSquares { rows: count + rows }),
            linear: DVector::zeros(free + count),
            square_root: Some((square_root, offset)),
            constant,
            slopes,
        };
        let solution = program.solve()?;
        let mut nearest = self.member(&solution.rows(0, free).into_owned());
        for u in 0..count {
            nearest += moved(u) * solution[free + u];
        }
        Some(nearest)
    }

    /// Scaled pseudo-inertias of all bodies.
    fn rows(&self, values: &DVector<f64>) -> DVector<f64> {
        let stacked = self
            .bodies
            .iter()
            .flat_map(|&first| scaled_rows(values, first));
        DVector::from_iterator(self.bodies.len() * ROWS, stacked)
    }

    fn form(&self, variables: Vec<Variable>, objective: Objective) -> Form {
        let block = |k: usize| Constraint {
            name: format!("pseudo-inertia of body {}", k + 1),
            unit: "kg".to_string(),
            rows: ROWS,
            set: Set::Psd { order: 4 },
        };
        Form {
            variables,
            objective,
            constraints: (0..self.bodies.len()).map(block).collect(),
            structure: Structure::Affine,
        }
    }
}

fn svec4(matrix: &Matrix4<f64>) -> Vec<f64> {
    let dynamic = DMatrix::from_column_slice(4, 4, matrix.as_slice());
    svec(&dynamic).iter().copied().collect()
}

/// svec of `D J D`, D = diag(1/ℓ, 1/ℓ, 1/ℓ, 1).
fn scaled_rows(values: &DVector<f64>, first: usize) -> Vec<f64> {
    let body = Inertia(std::array::from_fn(|k| values[first + k]));
    let mut scale = Matrix4::identity();
    for k in 0..3 {
        scale[(k, k)] = 1.0 / LENGTH;
    }
    svec4(&(scale * body.pseudo_inertia() * scale))
}

/// Affine positive semidefinite rows with a linear cost or a sum of squares.
struct Bodies {
    form: Form,
    linear: DVector<f64>,
    square_root: Option<(DMatrix<f64>, DVector<f64>)>,
    constant: DVector<f64>,
    slopes: DMatrix<f64>,
}

impl Bodies {
    fn solve(&self) -> Option<DVector<f64>> {
        let start = DVector::zeros(self.form.variables.len());
        let view = ConeProgram::try_from(self as &dyn Problem).ok()?;
        let solved = conic::solve(view, &start, &Settings::default(), &Control::default()).ok()?;
        let stop = solved.solution.stop;
        let usable = stop.converged() || stop == crate::problem::solution::Stop::NearlyOptimal;
        usable.then_some(solved.solution.x)
    }
}

impl Problem for Bodies {
    fn form(&self) -> &Form {
        &self.form
    }

    fn values(&self, x: &DVector<f64>) -> Result<Values, OutsideDomain> {
        let squares = self
            .square_root
            .as_ref()
            .map_or(0.0, |(a, b)| 0.5 * (a * x + b).norm_squared());
        Ok(Values {
            cost: self.linear.dot(x) + squares,
            constraints: &self.constant + &self.slopes * x,
        })
    }

    fn linearize(&self, x: &DVector<f64>) -> Result<Linearization, OutsideDomain> {
        let Values { cost, constraints } = self.values(x)?;
        let square_root = self.square_root.as_ref().map(|(a, b)| SquareRoot {
            matrix: a.clone(),
            residual: a * x + b,
        });
        let gradient = match &square_root {
            Some(root) => &self.linear + root.matrix.tr_mul(&root.residual),
            None => self.linear.clone(),
        };
        Ok(Linearization {
            cost,
            gradient,
            square_root,
            constraints,
            jacobian: self.slopes.clone(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of two unknowns with correlation r the variance of one given the other is σ² (1 − r²) (Kay 1993, theorem 10.2).
    #[test]
    fn what_is_known_takes_its_share_of_the_covariance() {
        let covariance =
            DMatrix::from_row_slice(3, 3, &[4.0, 3.0, 0.0, 3.0, 9.0, 0.0, 0.0, 0.0, 1e6]);
        let left = given(&covariance, &[1, 2]);
        let expected = DMatrix::from_diagonal(&DVector::from_row_slice(&[4.0 - 1.0, 0.0, 0.0]));
        assert!((&left - expected).amax() < 1e-9, "{left}");
        assert_eq!(given(&covariance, &[]), covariance);
    }
}
