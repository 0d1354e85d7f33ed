//! The fit as a cone program in the standard parameters x, and the choice among members of a class:
//!
//! ```text
//! minimise ½ ‖R T x + b‖² + prior(x)      subject to   D J_k(x) D − margin·1 ⪰ 0,  rows(x) >= 0,  lower <= x <= upper
//! minimise ½ ‖D (J_k(x) − J_k,ref) D‖²    over   x = x_0 + N z  (the same base parameters), same constraints
//! ```

use crate::estimate::derived::pseudo_inertia::{
    LARGEST_MARGIN, ROWS, free, identities, largest_margin,
};
use crate::estimate::feasible::standard::StandardParameters;
use crate::linalg::svec::smat;
use crate::linalg::triangular::Triangular;
use crate::problem::Problem;
use crate::problem::affine::{AffineProblem, AffineRows};
use crate::problem::form::{Constraint, Set, Variable};
use crate::problem::solution::Control;
use crate::problem::view::ConeProgram;
use crate::setup::combined_limits::Limit;
use crate::solve::error::SolveError;
use crate::solve::interior::{self, InteriorSolution, Settings, Terms};
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Weight of the pull towards the reference that keeps undetermined directions from running away, in
/// standard deviations of the residual per kg: a tonne costs 5e-7.
pub const PULL: f64 = 1e-6;

/// Shares of the way back to a member well inside, tried in turn where a solver's answer lacks some of the margin: its
/// rows hold up to its tolerance.
const WAY_BACK: [f64; 5] = [1e-8, 1e-6, 1e-4, 1e-2, 1.0];

/// Share of a distance from the reference that counts while a possible member is looked for.
const NEARBY: f64 = 1e-3;

/// Constraints on the unknowns: affine rows by x, and limits of x.
#[derive(Debug, Clone)]
pub struct Constraints {
    /// The unknowns, with their limits.
    pub variables: Vec<Variable>,
    /// Blocks of rows with their sets: one semidefinite block per body, then combined limits.
    pub blocks: Vec<Constraint>,
    /// Rows of all blocks at x = 0 and per unit of x, before the margin.
    pub constant: DVector<f64>,
    /// ∂(rows)/∂x, rows x unknowns.
    pub slopes: DMatrix<f64>,
    bodies: usize,
}

impl Constraints {
    /// Of the bodies with unknowns and of the limits given.
    pub fn new(standard: &StandardParameters<'_>, limits: &[Limit]) -> Self {
        let bodies = standard.pseudo_inertias();
        let first = bodies.offset.len();
        let mut constant = bodies.offset.resize_vertically(first + limits.len(), 0.0);
        let mut slopes = bodies.matrix.resize_vertically(first + limits.len(), 0.0);
        let known = standard.values(&DVector::zeros(standard.len()));
        for (k, limit) in limits.iter().enumerate() {
            constant[first + k] = limit.constant;
            for &(parameter, coefficient) in &limit.terms {
                match standard.parameters.iter().position(|&p| p == parameter) {
                    Some(column) => slopes[(first + k, column)] += coefficient,
                    None => constant[first + k] += coefficient * known[parameter],
                }
            }
        }
        let of_body = |&b: &usize| Constraint {
            name: format!("pseudo-inertia of {}", standard.body_name(b)),
            unit: "kg".to_string(),
            rows: ROWS,
            set: Set::Psd { order: 4 },
        };
        let of_limit = |limit: &Limit| Constraint {
            name: limit.name.clone(),
            unit: limit.unit.clone(),
            rows: 1,
            set: Set::Nonnegative,
        };
        let blocks = standard.bodies.iter().map(of_body);
        Self {
            variables: standard.variables(),
            blocks: blocks.chain(limits.iter().map(of_limit)).collect(),
            constant,
            slopes,
            bodies: standard.bodies.len(),
        }
    }

    /// Rows at zero with the margin taken off every body.
    fn shifted(&self, margin: f64) -> DVector<f64> {
        let mut constant = self.constant.clone();
        let mut of_bodies = constant.rows_mut(0, ROWS * self.bodies);
        of_bodies -= identities(self.bodies) * margin;
        constant
    }

    /// The constraints without that of one body.
    pub fn without(&self, body: usize) -> Self {
        let mut fewer = self.clone();
        fewer.blocks.remove(body);
        fewer.constant = fewer.constant.remove_rows(ROWS * body, ROWS);
        fewer.slopes = fewer.slopes.remove_rows(ROWS * body, ROWS);
        fewer.bodies -= 1;
        fewer
    }
}

/// A fit under constraints on its bodies.
pub struct Program(AffineProblem);

impl Program {
    /// `½ ‖matrix x + offset‖²` under constraints with a margin.
    pub fn fit(constraints: &Constraints, margin: f64, rows: AffineRows) -> Self {
        let cones = AffineRows {
            matrix: constraints.slopes.clone(),
            offset: constraints.shifted(margin),
        };
        let (variables, blocks) = (constraints.variables.clone(), constraints.blocks.clone());
        Self(AffineProblem::new(variables, blocks, rows, cones))
    }

    /// The same with a variable t_j >= |x_j| behind the others for every weight w_j > 0 of the cost: `t_j − x_j >= 0`,
    /// `t_j + x_j >= 0`. The weights themselves are a term of the solver.
    pub fn with_absolute(mut self, weights: &DVector<f64>) -> Self {
        let problem = &mut self.0;
        let columns: Vec<usize> = (0..weights.len()).filter(|&j| weights[j] > 0.0).collect();
        let (count, first) = (weights.len() + columns.len(), problem.cones.offset.len());
        let AffineRows { matrix, offset } = &mut problem.cones;
        *offset = std::mem::take(offset).resize_vertically(first + 2 * columns.len(), 0.0);
        *matrix = std::mem::take(matrix).resize(offset.len(), count, 0.0);
        let squares = &mut problem.squares.matrix;
        *squares = std::mem::take(squares).resize_horizontally(count, 0.0);
        for (k, &j) in columns.iter().enumerate() {
            let own = weights.len() + k;
            for (row, sign) in [(first + 2 * k, -1.0), (first + 2 * k + 1, 1.0)] {
                problem.cones.matrix[(row, own)] = 1.0;
                problem.cones.matrix[(row, j)] = sign;
            }
            let variable = &problem.form.variables[j];
            let size = Variable::free(format!("|{}|", variable.name), &variable.unit);
            let size = size.scale(variable.scale);
            problem.form.variables.push(size);
        }
        problem.form.constraints.push(Constraint {
            name: "absolute values".to_string(),
            unit: String::new(),
            rows: 2 * columns.len(),
            set: Set::Nonnegative,
        });
        self
    }

    /// An answer may lack up to the shortfall of the margin of its bodies.
    pub fn solve(
        &self,
        start: &DVector<f64>,
        terms: &Terms,
        shortfall: f64,
        control: &Control<'_>,
    ) -> Result<InteriorSolution, SolveError> {
        let view = ConeProgram::try_from(&self.0 as &dyn Problem)?;
        let settings = Settings {
            shortfall,
            ..Settings::default()
        };
        interior::solve(view, start, &settings, terms, control)
    }
}

/// Rows that pull weakly towards a reference: `weight · (pseudo-inertias, others by their scale)`.
pub fn pull(
    standard: &StandardParameters<'_>,
    reference: &DVector<f64>,
    weight: f64,
) -> AffineRows {
    let slopes = standard.pseudo_inertias().matrix;
    let first = slopes.nrows();
    let mut rows = slopes.resize_vertically(first + standard.len(), 0.0);
    for (k, variable) in standard.variables().iter().enumerate() {
        if rows.column(k).rows(0, first).amax() == 0.0 {
            rows[(first + k, k)] = 1.0 / variable.scale;
        }
    }
    rows *= weight;
    AffineRows {
        offset: -&rows * reference,
        matrix: rows,
    }
}

/// Members x = x_0 + N z of a class, within constraints.
pub struct EquivalenceClass<'a> {
    /// What members must satisfy.
    pub constraints: &'a Constraints,
    /// N, unknowns x directions.
    pub null: &'a DMatrix<f64>,
    /// x_0.
    pub member: &'a DVector<f64>,
}

impl EquivalenceClass<'_> {
    /// A member with the margin, closest to the reference in the scaled pseudo-inertias; `None` where the
    /// class has no member with twice the margin.
    pub fn closest(&self, margin: f64, reference: &DVector<f64>) -> Option<DVector<f64>> {
        let bodies = ROWS * self.constraints.bodies;
        let slopes = (&self.constraints.slopes * self.null)
            .rows(0, bodies)
            .into_owned();
        // Around the closest member of all, possible or not: the given one may have huge entries that cancel.
        let member = self.member + self.null * self.towards(&slopes, reference);
        let around = EquivalenceClass {
            member: &member,
            ..*self
        };
        let rows = around.rows(margin)?;
        if rows.least() >= 0.0 {
            return Some(member);
        }
        let away = (&self.constraints.slopes * (&member - reference))
            .rows(0, bodies)
            .into_owned();
        let squares = AffineRows {
            matrix: slopes,
            offset: away,
        };
        let start = rows.interior(margin, &squares)?;
        let variables = free(squares.matrix.ncols());
        let program = Program(AffineProblem::new(
            variables,
            rows.blocks,
            squares,
            rows.cones,
        ));
        let found = program
            .solve(&start, &Terms::default(), 0.0, &Control::default())
            .ok()?;
        if !found.gap.is_finite() {
            return None;
        }
        let x = found.solution.x;
        let at = |back: f64| &member + self.null * (&x + back * (&start - &x));
        let has_margin = |member: &DVector<f64>| {
            let rows = EquivalenceClass { member, ..*self }.rows(margin);
            rows.is_some_and(|rows| rows.least() >= 0.0)
        };
        let mut tried = std::iter::once(0.0).chain(WAY_BACK).map(at);
        tried.find(has_margin)
    }

    /// z that brings the pseudo-inertias closest to those of a reference, whatever the constraints say.
    fn towards(&self, slopes: &DMatrix<f64>, reference: &DVector<f64>) -> DVector<f64> {
        let away = &self.constraints.slopes * (reference - self.member);
        let away = away.rows(0, slopes.nrows()).into_owned();
        let count = slopes.ncols();
        let factor = Triangular::of_system(slopes, &away).matrix();
        let whole = factor.view((0, 0), (count, count));
        whole
            .solve_upper_triangular(&factor.view((0, count), (count, 1)).column(0).into_owned())
            .filter(|z| z.iter().all(|v| v.is_finite()))
            .unwrap_or_else(|| DVector::zeros(count))
    }

    /// Constraints over z; rows that z does not move must hold as they are.
    fn rows(&self, margin: f64) -> Option<Rows> {
        let constraints = self.constraints;
        let whole = constraints.shifted(margin) + &constraints.slopes * self.member;
        let moved = &constraints.slopes * self.null;
        let mut rows = Rows {
            blocks: Vec::new(),
            cones: AffineRows {
                matrix: DMatrix::default(),
                offset: DVector::default(),
            },
        };
        let mut first = 0;
        for block in &constraints.blocks {
            let part = AffineRows {
                offset: whole.rows(first, block.rows).into_owned(),
                matrix: moved.rows(first, block.rows).into_owned(),
            };
            first += block.rows;
            rows.add(block.clone(), part)?;
        }
        for (k, variable) in constraints.variables.iter().enumerate() {
            for (sign, limit) in [(1.0, variable.lower), (-1.0, variable.upper)] {
                if limit.is_finite() {
                    let block = Constraint {
                        name: variable.name.clone(),
                        unit: variable.unit.clone(),
                        rows: 1,
                        set: Set::Nonnegative,
                    };
                    let room = AffineRows {
                        offset: DVector::from_element(1, sign * (self.member[k] - limit)),
                        matrix: self.null.rows(k, 1) * sign,
                    };
                    rows.add(block, room)?;
                }
            }
        }
        Some(rows)
    }
}

struct Rows {
    blocks: Vec<Constraint>,
    cones: AffineRows,
}

impl Rows {
    /// The smallest eigenvalue of a block and the smallest other row, at z = 0.
    fn least(&self) -> f64 {
        let mut first = 0;
        let mut least = f64::INFINITY;
        for block in &self.blocks {
            let rows = self.cones.offset.rows(first, block.rows);
            let own = match block.set {
                Set::Psd { .. } => SymmetricEigen::new(smat(rows.clone_owned().as_slice()))
                    .eigenvalues
                    .min(),
                _ => rows.min(),
            };
            least = least.min(own);
            first += block.rows;
        }
        least
    }

    /// z with at least the margin that all blocks have beyond their own, not much further from the reference than need be.
    fn interior(&self, margin: f64, away: &AffineRows) -> Option<DVector<f64>> {
        let count = away.matrix.ncols();
        let program = Program(largest_margin(
            self.blocks.clone(),
            &self.cones,
            away,
            NEARBY,
        ));
        let mut start = DVector::zeros(count + 1);
        let least = self.least();
        start[count] = least - least.abs().max(LARGEST_MARGIN);
        let found = program
            .solve(&start, &Terms::default(), 0.0, &Control::default())
            .ok()?;
        let x = found.solution.x;
        (found.gap.is_finite() && x[count] >= margin).then(|| x.rows(0, count).into_owned())
    }

    /// `None` where a row that nothing moves is violated.
    fn add(&mut self, block: Constraint, own: AffineRows) -> Option<()> {
        let AffineRows {
            matrix: slopes,
            offset: constant,
        } = own;
        if slopes.amax() == 0.0 && block.set == Set::Nonnegative {
            return (constant[0] >= 0.0).then_some(());
        }
        let AffineRows { matrix, offset } = &mut self.cones;
        let at = offset.len();
        let size = at + block.rows;
        *offset = std::mem::take(offset).resize_vertically(size, 0.0);
        offset.rows_mut(at, block.rows).copy_from(&constant);
        *matrix = std::mem::take(matrix).resize(size, slopes.ncols(), 0.0);
        matrix.rows_mut(at, block.rows).copy_from(&slopes);
        self.blocks.push(block);
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::derived::pseudo_inertia::svec4;
    use nalgebra::Matrix4;

    /// kg.
    const MARGIN: f64 = 0.01;

    /// Bodies whose scaled pseudo-inertias are x_k times the identity, with a limit x_0 >= least.
    fn constraints(bodies: usize, least: f64) -> Constraints {
        let rows = ROWS * bodies + 1;
        let identity = DVector::from_vec(svec4(&Matrix4::identity()));
        let mut slopes = DMatrix::zeros(rows, bodies);
        for body in 0..bodies {
            let mut own = slopes.view_mut((ROWS * body, body), (ROWS, 1));
            own.copy_from(&identity);
        }
        slopes[(rows - 1, 0)] = 1.0;
        let mut constant = DVector::zeros(rows);
        constant[rows - 1] = -least;
        let block = |rows: usize, set: Set| Constraint {
            name: String::new(),
            unit: String::new(),
            rows,
            set,
        };
        let mut blocks = vec![block(ROWS, Set::Psd { order: 4 }); bodies];
        blocks.push(block(1, Set::Nonnegative));
        Constraints {
            variables: free(bodies),
            blocks,
            constant,
            slopes,
            bodies,
        }
    }

    /// What is closest to a reference among (2, z).
    fn closest(least: f64, reference: f64) -> Option<DVector<f64>> {
        let class = EquivalenceClass {
            constraints: &constraints(2, least),
            null: &DMatrix::from_row_slice(2, 1, &[0.0, 1.0]),
            member: &DVector::from_vec(vec![2.0, -1.0]),
        };
        class.closest(MARGIN, &DVector::from_vec(vec![7.0, reference]))
    }

    #[test]
    fn every_body_has_its_margin() {
        let shifted = constraints(3, 1.0).shifted(MARGIN);
        for body in 0..3 {
            let own = smat(shifted.rows(ROWS * body, ROWS).clone_owned().as_slice());
            let off = own + DMatrix::identity(4, 4) * MARGIN;
            assert!(off.amax() < 1e-15, "body {body}: {off}");
        }
        assert_eq!(shifted[3 * ROWS], -1.0);
        // A reference that is no body: the closest one is at the margin, to the tolerance of the solver.
        let at_margin = closest(1.0, -4.0).unwrap()[1];
        assert!((MARGIN..MARGIN + 1e-4).contains(&at_margin), "{at_margin}");
        let inside = closest(1.0, 3.0).unwrap();
        assert!((inside - DVector::from_vec(vec![2.0, 3.0])).amax() < 1e-12);
    }

    /// x_0 is the same for all members.
    #[test]
    fn a_class_that_breaks_a_limit_which_nothing_moves_has_no_member() {
        for reference in [3.0, -4.0] {
            assert!(closest(2.0, reference).is_some());
            assert_eq!(closest(2.1, reference), None);
        }
    }
}
