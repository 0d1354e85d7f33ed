//! A physically possible member of the estimate's equivalence class: link parameters with the same base
//! parameters, hence the same torques, whose pseudo-inertias are all positive definite.
//!
//! With `π = π_0 + N z` (π_0 the estimate, z the parameters that base parameters stand for),
//!
//! ```text
//! minimise ½ (t − t_max)² + ½ ε² ‖D (J − J_reference) D‖²   subject to   D J_k(π) D − t·1 ⪰ 0 for every link k
//! minimise ½ ‖D (J − J_reference) D‖²   subject to   D J_k(π) D − ½ t*·1 ⪰ 0
//! ```
//!
//! (t* and a little less where it is not positive). D measures lengths in units in which masses and second moments have one size.
//! Where t* is not positive no member is possible, and the robot that is nearest by the covariance C = L Lᵀ of the unknowns takes
//! its place, friction and all else moved along with the bodies:
//!
//! ```text
//! minimise ½ ‖u‖² + ½ ε² ‖D (J − J_reference) D‖²   subject to   D J_k(π_0 + N z + E L u) D − margin·1 ⪰ 0
//! ```

use crate::chain::effect::Linearity;
use crate::chain::model::Model;
use crate::chain::parameter::Role;
use crate::estimate::derived::pseudo_inertia::{
    ROWS, free, identities, largest_margin, scaled_rows,
};
use crate::estimate::fit_problem::unknowns::Unknowns;
use crate::problem::Problem;
use crate::problem::affine::{AffineProblem, AffineRows};
use crate::problem::form::{Constraint, Set};
use crate::problem::solution::Control;
use crate::problem::view::ConeProgram;
use crate::robot::inertia::{Inertia, PER_LINK};
use crate::solve::interior::{self, Settings, Terms};
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Share of a distance from the reference that counts while the largest margin is looked for: it keeps links without effect on the signal
/// from growing without limit.
const NEARBY: f64 = 1e-6;

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
    let chosen = class.chosen()?;
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

/// Share of a margin that no member has, by which one that is closer to the reference may miss it further.
const SLACK: f64 = 0.01;

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

/// A member that is furthest inside the physical bodies.
struct MostInterior {
    /// t*, kg.
    margin: f64,
    /// Values of all parameters.
    values: DVector<f64>,
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

    /// The member closest to the reference with half of the largest margin, or a little less than it where it is not positive.
    fn chosen(&self) -> Option<DVector<f64>> {
        let inside = self.most_interior()?;
        let asked = match inside.margin > 0.0 {
            true => 0.5 * inside.margin,
            false => (1.0 + SLACK) * inside.margin,
        };
        Some(self.closest(asked).unwrap_or(inside.values))
    }

    /// The member with the largest margin.
    fn most_interior(&self) -> Option<MostInterior> {
        let cones = self.cones(0.0);
        let program = largest_margin(self.constraints(), &cones, &self.away(), NEARBY);
        let solution = solved(&program)?;
        let count = self.free.len();
        Some(MostInterior {
            margin: solution[count],
            values: self.member(&solution.rows(0, count).into_owned()),
        })
    }

    /// The member closest to the reference with at least the given margin.
    fn closest(&self, margin: f64) -> Option<DVector<f64>> {
        // Distance in the scaled pseudo-inertias, so that masses and inertias count alike.
        let program = AffineProblem::new(
            free(self.free.len()),
            self.constraints(),
            self.away(),
            self.cones(margin),
        );
        solved(&program).map(|z| self.member(&z))
    }

    /// The possible robot whose unknowns, at these positions, lie nearest by their covariance.
    fn nearest(&self, positions: &[usize], covariance: &DMatrix<f64>) -> Option<DVector<f64>> {
        let eigen = covariance.clone().symmetric_eigen();
        let mut moves = eigen.eigenvectors;
        for (mut column, variance) in moves.column_iter_mut().zip(&eigen.eigenvalues) {
            column *= variance.max(0.0).sqrt();
        }
        let (free_count, count) = (self.free.len(), positions.len());
        let mut slopes = self
            .slopes
            .clone()
            .resize_horizontally(free_count + count, 0.0);
        let moved = |u: usize| {
            let mut direction = DVector::zeros(self.values.len());
            for (k, &p) in positions.iter().enumerate() {
                direction[p] = moves[(k, u)];
            }
            direction
        };
        for u in 0..count {
            slopes.set_column(free_count + u, &self.rows(&moved(u)));
        }
        let rows = self.constant.len();
        let mut square_root = DMatrix::zeros(count + rows, free_count + count);
        square_root
            .view_mut((0, free_count), (count, count))
            .fill_with_identity();
        square_root
            .view_mut((count, 0), (rows, free_count + count))
            .copy_from(&(&slopes * REFERENCE_WEIGHT));
        let mut offset = DVector::zeros(count + rows);
        offset
            .rows_mut(count, rows)
            .copy_from(&(self.away().offset * REFERENCE_WEIGHT));
        let squares = AffineRows {
            matrix: square_root,
            offset,
        };
        let cones = AffineRows {
            matrix: slopes,
            ..self.cones(NEAREST_MARGIN)
        };
        let variables = free(free_count + count);
        let program = AffineProblem::new(variables, self.constraints(), squares, cones);
        let solution = solved(&program)?;
        let mut nearest = self.member(&solution.rows(0, free_count).into_owned());
        for u in 0..count {
            nearest += moved(u) * solution[free_count + u];
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

    /// What the scaled pseudo-inertias are away from the reference.
    fn away(&self) -> AffineRows {
        AffineRows {
            matrix: self.slopes.clone(),
            offset: &self.constant - self.rows(&self.reference),
        }
    }

    /// The scaled pseudo-inertias, with a margin taken off every body.
    fn cones(&self, margin: f64) -> AffineRows {
        AffineRows {
            matrix: self.slopes.clone(),
            offset: &self.constant - identities(self.bodies.len()) * margin,
        }
    }

    fn constraints(&self) -> Vec<Constraint> {
        let of_body = |k: usize| Constraint {
            name: format!("pseudo-inertia of body {}", k + 1),
            unit: "kg".to_string(),
            rows: ROWS,
            set: Set::Psd { order: 4 },
        };
        (0..self.bodies.len()).map(of_body).collect()
    }
}

/// The least of a program; `None` where the solver does not tell it.
fn solved(program: &AffineProblem) -> Option<DVector<f64>> {
    let start = DVector::zeros(program.form.variables.len());
    let view = ConeProgram::try_from(program as &dyn Problem).ok()?;
    let (settings, terms) = (Settings::default(), Terms::default());
    let solved = interior::solve(view, &start, &settings, &terms, &Control::default()).ok()?;
    solved.gap.is_finite().then_some(solved.solution.x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::derived::pseudo_inertia::scaled_body;

    /// Of two bodies one is not possible, whatever the other is: that one is as in the robot file all the same.
    #[test]
    fn where_no_member_is_possible_the_bodies_are_near_those_of_the_robot_file() {
        let mut values = DVector::zeros(2 * PER_LINK);
        for first in [0, PER_LINK] {
            values[first] = 1.0;
            for diagonal in [4, 6, 9] {
                values[first + diagonal] = 0.02;
            }
        }
        let reference = values.clone();
        // A moment of the first body that no mass can have; the mass of the second is not known.
        values[9] = -0.02;
        values[PER_LINK] = 40.0;
        let bodies = [0, PER_LINK];
        let rows = |values: &DVector<f64>| {
            let stacked = bodies.iter().flat_map(|&first| scaled_rows(values, first));
            DVector::from_iterator(bodies.len() * ROWS, stacked)
        };
        let mut mass = DVector::zeros(values.len());
        mass[PER_LINK] = 1.0;
        let class = EquivalenceClass {
            constant: rows(&values),
            slopes: DMatrix::from_columns(&[rows(&mass)]),
            free: vec![(PER_LINK, Vec::new())],
            values: &values,
            reference,
            bodies: &bodies,
        };
        let chosen = class.chosen().unwrap();
        assert!(class.most_interior().unwrap().margin < 0.0);
        assert!(
            (chosen[PER_LINK] - 1.0).abs() < 1e-4,
            "{}",
            chosen[PER_LINK]
        );
        assert_eq!(chosen[9], values[9]);
    }

    /// A possible body whose moments of inertia are unknown is as near that of the robot file as half of the largest margin allows.
    #[test]
    fn bodies_keep_half_of_the_largest_margin() {
        let mut values = DVector::zeros(PER_LINK);
        let mut moments = DVector::zeros(PER_LINK);
        values[0] = 1.0;
        for diagonal in [4, 6, 9] {
            values[diagonal] = 0.0002;
            moments[diagonal] = 1.0;
        }
        let rows = |values: &DVector<f64>| DVector::from_column_slice(&scaled_rows(values, 0));
        let class = EquivalenceClass {
            constant: rows(&values),
            slopes: DMatrix::from_columns(&[rows(&moments)]),
            free: vec![(4, vec![(6, 1.0), (9, 1.0)])],
            values: &values,
            reference: values.clone(),
            bodies: &[0],
        };
        let margin = |values: &DVector<f64>| {
            SymmetricEigen::new(scaled_body(values, 0))
                .eigenvalues
                .min()
        };
        let largest = class.most_interior().unwrap().margin;
        assert!(largest > 4.0 * margin(&values));
        let kept = margin(&class.chosen().unwrap());
        assert!((kept / largest - 0.5).abs() < 1e-3, "{kept} of {largest}");
    }

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
