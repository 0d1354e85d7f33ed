//! The solution of a feasible fit from a compressed residual `½ ‖R β + b‖²` of base unknowns.
//!
//! Without a prior on the bodies the least squares solution is kept where its class has a physical member;
//! the member closest to the robot file's bodies is the answer. Otherwise the cone program decides, and the
//! class of its answer is searched for the closest member in the same way.

use crate::estimate::derived::pseudo_inertia::scaled_body;
use crate::estimate::error::EstimateError;
use crate::estimate::feasible::prior::InertialPrior;
use crate::estimate::feasible::program::{Constraints, EquivalenceClass, PULL, Program, pull};
use crate::estimate::feasible::standard::StandardParameters;
use crate::estimate::fit_problem::problem::FitProblem;
use crate::estimate::residual::compress::stacked;
use crate::problem::Problem;
use crate::problem::affine::AffineRows;
use crate::problem::solution::{Control, Stop};
use crate::solve::error::SolveError;
use crate::solve::interior::{InteriorSolution, Terms};
use nalgebra::{DMatrix, DVector};

/// A prior on the bodies and how strong it is.
pub type Strong<'a> = Option<(&'a InertialPrior, f64)>;

/// The compressed residual over base unknowns.
#[derive(Debug, Clone)]
pub struct Compressed {
    /// R, by base unknowns.
    pub matrix: DMatrix<f64>,
    /// Residual at β = 0.
    pub offset: DVector<f64>,
}

impl Compressed {
    /// ½ ‖R β + b‖² at base unknowns β.
    pub fn cost(&self, base: &DVector<f64>) -> f64 {
        0.5 * (&self.matrix * base + &self.offset).norm_squared()
    }

    /// The least squares solution; `None` where the base unknowns are not determined.
    pub fn least_squares(&self) -> Option<DVector<f64>> {
        let factor =
            crate::linalg::triangular::Triangular::of_system(&self.matrix, &(-&self.offset));
        let system = factor.system()?;
        system.matrix.solve_upper_triangular(&system.right)
    }
}

/// An estimate in the standard parameters with its certificate.
#[derive(Debug, Clone)]
pub struct Feasible {
    /// The unknowns in the order of [`StandardParameters`].
    pub x: DVector<f64>,
    /// ½ ‖R β + b‖² there and at the least squares solution.
    pub cost: f64,
    /// The same at the least squares solution, where bodies need not be possible.
    pub unconstrained: f64,
    /// The constraints change nothing.
    pub inactive: bool,
    /// Duality gap in units of the cost, which bounds its distance from the least; NaN where a chart kept the bodies
    /// possible.
    pub gap: f64,
    /// Largest imbalance of the gradient of the Lagrangian, relative to its terms.
    pub stationarity: f64,
    /// Why the solver stopped.
    pub stop: Stop,
    /// Steps of the solver.
    pub iterations: usize,
}

/// What an estimate is made of beside the residual.
#[derive(Clone, Copy)]
pub struct Setting<'a> {
    /// The unknowns and their way to base unknowns and bodies.
    pub standard: &'a StandardParameters<'a>,
    /// What the unknowns must satisfy.
    pub constraints: &'a Constraints,
    /// Smallest eigenvalue of a scaled pseudo-inertia, kg.
    pub margin: f64,
    /// The prior with its weight; it may be none.
    pub prior: Strong<'a>,
}

/// The feasible optimum of an affine residual.
pub fn estimate(
    setting: Setting<'_>,
    residual: &Compressed,
    control: &Control<'_>,
) -> Result<Feasible, SolveError> {
    if let Some(free) = residual.least_squares()
        && let Some(inactive) = inactive(setting, residual, &free)
    {
        return Ok(inactive);
    }
    let found = constrained(setting, setting.constraints, residual, control)?;
    Ok(active(setting, residual, found))
}

/// The estimate where base unknowns of least cost have a physical member and no prior has a say.
pub(super) fn inactive(
    setting: Setting<'_>,
    residual: &Compressed,
    free: &DVector<f64>,
) -> Option<Feasible> {
    if setting.prior.is_some() {
        return None;
    }
    let cost = residual.cost(free);
    Some(Feasible {
        x: member(setting, free)?,
        cost,
        unconstrained: cost,
        inactive: true,
        gap: 0.0,
        stationarity: 0.0,
        stop: Stop::Optimal,
        iterations: 1,
    })
}

/// The estimate of a cone program: of its class the member closest to the reference.
pub(super) fn active(
    setting: Setting<'_>,
    residual: &Compressed,
    found: InteriorSolution,
) -> Feasible {
    let base = &setting.standard.to_base * &found.solution.x;
    let class = EquivalenceClass {
        constraints: setting.constraints,
        null: &setting.standard.null,
        member: &found.solution.x,
    };
    let closest = match setting.prior {
        None => class.closest(setting.margin, &setting.standard.reference()),
        Some(_) => None,
    };
    Feasible {
        cost: residual.cost(&base),
        x: closest.unwrap_or(found.solution.x),
        unconstrained: residual.least_squares().map_or(0.0, |b| residual.cost(&b)),
        inactive: false,
        gap: found.gap,
        stationarity: found.stationarity,
        stop: found.solution.stop,
        iterations: found.solution.iterations,
    }
}

/// The physical member of the class of base unknowns that is closest to the reference.
pub fn member(setting: Setting<'_>, base: &DVector<f64>) -> Option<DVector<f64>> {
    let standard = setting.standard;
    // A member: each base parameter is carried by one parameter that gives it alone, and the others are zero.
    let mut x = DVector::zeros(standard.len());
    for (row, value) in base.iter().enumerate() {
        let leading = |k: &usize| {
            standard.to_base[(row, *k)] == 1.0
                && standard
                    .to_base
                    .column(*k)
                    .iter()
                    .filter(|c| **c != 0.0)
                    .count()
                    == 1
        };
        let kept = (0..standard.len()).find(leading)?;
        x[kept] = *value;
    }
    let class = EquivalenceClass {
        constraints: setting.constraints,
        null: &standard.null,
        member: &x,
    };
    class.closest(setting.margin, &standard.reference())
}

/// Share of ‖b‖² that the pull towards the reference may cost.
const COST_OF_PULL: f64 = 1e-10;

/// Weight below which the pull is lost in rounding.
const LEAST_PULL: f64 = 1e-9;

/// The cone program with three times the margin, of which an answer may lack one to rounding, so that its class has
/// members with once the margin.
///
/// Where only bodies of many tonnes attain the least cost, the pull keeps the answer from it by about twice what
/// it costs itself: it is then weakened until that is next to nothing.
pub fn constrained(
    setting: Setting<'_>,
    constraints: &Constraints,
    residual: &Compressed,
    control: &Control<'_>,
) -> Result<InteriorSolution, SolveError> {
    let start = setting.standard.reference();
    let allowed = COST_OF_PULL * residual.offset.norm_squared();
    let mut weight = PULL;
    let mut found = pulled(setting, constraints, residual, weight, control)?;
    loop {
        let pulling = pull(setting.standard, &start, weight);
        let cost = 0.5 * pulling.at(&found.solution.x).norm_squared();
        weight *= 0.1;
        if cost <= allowed || weight < LEAST_PULL || found.solution.stop != Stop::Optimal {
            return Ok(found);
        }
        let next = pulled(setting, constraints, residual, weight, control)?;
        if next.solution.stop != Stop::Optimal {
            return Ok(found);
        }
        found = next;
    }
}

/// The cone program with a pull of some weight.
fn pulled(
    setting: Setting<'_>,
    constraints: &Constraints,
    residual: &Compressed,
    weight: f64,
    control: &Control<'_>,
) -> Result<InteriorSolution, SolveError> {
    let standard = setting.standard;
    let start = standard.reference();
    let data = &residual.matrix * &standard.to_base;
    let weak = pull(standard, &start, weight);
    let none = || AffineRows {
        matrix: DMatrix::zeros(0, standard.len()),
        offset: DVector::zeros(0),
    };
    let rows = setting.prior.map(|(prior, weight)| prior.rows(weight));
    let rows = rows.unwrap_or_else(none);
    let terms = setting.prior.map(|(prior, weight)| prior.terms(weight));
    let terms = terms.unwrap_or_default();
    let matrix = stacked(&[data, rows.matrix, weak.matrix], standard.len());
    let parts = [&residual.offset, &rows.offset, &weak.offset];
    let whole: Vec<f64> = parts.iter().flat_map(|p| p.iter().copied()).collect();
    let (margin, shortfall) = match setting.prior {
        Some(_) => (setting.margin, 0.0),
        None => (3.0 * setting.margin, setting.margin),
    };
    let rows = AffineRows {
        matrix,
        offset: DVector::from_vec(whole),
    };
    let program = Program::fit(constraints, margin, rows);
    let weights = match setting.prior {
        Some((prior, weight)) => prior.absolute(weight),
        None => DVector::zeros(0),
    };
    if weights.iter().all(|w| *w == 0.0) {
        return program.solve(&start, &terms, shortfall, control);
    }
    sparse(program, &weights, &start, control)
}

/// The program with a penalty `Σ w_j |x_j|`, its answer without the variables that stand for the absolute values.
fn sparse(
    program: Program,
    weights: &DVector<f64>,
    start: &DVector<f64>,
    control: &Control<'_>,
) -> Result<crate::solve::interior::InteriorSolution, SolveError> {
    let counted = (0..weights.len()).filter(|&j| weights[j] > 0.0);
    let linear: Vec<f64> = counted.clone().map(|j| weights[j]).collect();
    let sizes: Vec<f64> = counted.map(|j| start[j].abs() + 1.0 / weights[j]).collect();
    let mut whole = start.as_slice().to_vec();
    whole.extend(sizes);
    let mut cost = vec![0.0; weights.len()];
    cost.extend(linear);
    let terms = Terms {
        linear: DVector::from_vec(cost),
        ..Terms::default()
    };
    let program = program.with_absolute(weights);
    let mut found = program.solve(&DVector::from_vec(whole), &terms, 0.0, control)?;
    let x = &found.solution.x;
    found.solution.x = x.rows(0, weights.len()).into_owned();
    Ok(found)
}

/// What the prior on the bodies adds to the cost.
pub fn prior_cost(setting: Setting<'_>, x: &DVector<f64>) -> f64 {
    let Some((prior, weight)) = setting.prior else {
        return 0.0;
    };
    let terms = prior.terms(weight);
    let mut cost = 0.5 * prior.rows(weight).at(x).norm_squared();
    cost += prior.absolute(weight).dot(&x.abs());
    if !terms.linear.is_empty() {
        cost += terms.linear.dot(x);
        let values = setting.standard.values(x);
        for &first in &setting.standard.bodies {
            let identity = nalgebra::Matrix4::identity() * setting.margin;
            let shifted = scaled_body(&values, first) - identity;
            cost -= weight * shifted.determinant().max(f64::MIN_POSITIVE).ln();
        }
    }
    cost
}

/// The residual linearised at base unknowns.
pub(super) fn compressed(
    problem: &FitProblem<'_>,
    at: &DVector<f64>,
) -> Result<Compressed, EstimateError> {
    let outside = |e: crate::problem::OutsideDomain| EstimateError::Solve(e.into());
    let root = problem.linearize(at).map_err(outside)?.square_root;
    let Some(root) = root else {
        return Err(EstimateError::NothingUnknown);
    };
    Ok(Compressed {
        offset: root.residual - &root.matrix * at,
        matrix: root.matrix,
    })
}
