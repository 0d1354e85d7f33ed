//! Feasible estimation without constraints: a chart of the bodies, coordinates in which every body is physically possible.
//!
//! ```text
//! D J D = margin·1 + e^(2α) U Uᵀ,   U = [e^d1 s12 s13 t1; 0 e^d2 s23 t2; 0 0 e^d3 t3; 0 0 0 1]
//! ```
//!
//! is a one-to-one map of R¹⁰ onto the bodies that the cones admit (Rucker and Wensing 2022, "Smooth parameterization
//! of rigid-body inertia", eqs 9 to 11, with the margin of the cones). The residual in (α, d, s, t) is a smooth sum of
//! squares with bounds alone, which Levenberg-Marquardt minimises. At the edge of what is possible d goes to its least
//! value, and slowly: there the cones are the better way, and this one their check.

use crate::estimate::derived::pseudo_inertia::{LENGTH, scaled_body};
use crate::estimate::error::EstimateError;
use crate::estimate::feasible::compressed;
use crate::estimate::feasible::program::{PULL, pull};
use crate::estimate::feasible::solve::{self, Feasible, Setting};
use crate::estimate::feasible::standard::StandardParameters;
use crate::estimate::fit_problem::problem::FitProblem;
use crate::problem::affine::AffineRows;
use crate::problem::form::{Form, Objective, Structure, Variable};
use crate::problem::solution::Control;
use crate::problem::view::LeastSquares;
use crate::problem::{Linearization, OutsideDomain, Problem, SquareRoot, Values};
use crate::robot::inertia::{Inertia, PER_LINK};
use crate::solve::levenberg_marquardt;
use crate::stats::range::within;
use nalgebra::{DMatrix, DVector, Matrix4};

/// Names of the coordinates of a body.
const NAMES: [&str; PER_LINK] = [
    "alpha", "d1", "d2", "d3", "s12", "s23", "s13", "t1", "t2", "t3",
];

/// Row and column of U that the coordinates behind α set; the first three are logarithms.
const ENTRIES: [(usize, usize); PER_LINK - 1] = [
    (0, 0),
    (1, 1),
    (2, 2),
    (0, 1),
    (1, 2),
    (0, 2),
    (0, 3),
    (1, 3),
    (2, 3),
];

/// Logarithms among the entries.
const LOGARITHMS: usize = 3;

/// Least logarithm: e^(2d) is then below the margin of a body of a kilogramme, and a search that follows a body to its
/// edge ends there.
const LEAST_LOGARITHM: f64 = -8.0;

/// Share of the cost that a search may leave.
const COST_TOLERANCE: f64 = 1e-11;

/// Iterations after which a search has failed: at the edge they are many.
const ITERATION_LIMIT: usize = 1000;

/// The fit over coordinates θ: ten of every body, then the unknowns of no body.
pub struct Chart<'a> {
    problem: &'a FitProblem<'a>,
    setting: Setting<'a>,
    /// Positions among the unknowns of the ten parameters of every body.
    bodies: Vec<[usize; PER_LINK]>,
    /// Positions among the unknowns of the others.
    others: Vec<usize>,
    pull: AffineRows,
    form: Form,
}

impl<'a> Chart<'a> {
    /// # Errors
    /// A body of which parts are known, and limits on bodies: only the cones keep those.
    pub fn new(problem: &'a FitProblem<'a>, setting: Setting<'a>) -> Result<Self, EstimateError> {
        let standard = setting.standard;
        let blocks = &setting.constraints.blocks;
        if let Some(limit) = blocks.get(standard.bodies.len()) {
            let name = limit.name.clone();
            return Err(EstimateError::LimitInChart { name });
        }
        let bodies: Vec<[usize; PER_LINK]> = standard
            .bodies
            .iter()
            .map(|&first| whole_body(standard, first))
            .collect::<Result<_, _>>()?;
        let of_body = |k: &usize| bodies.iter().any(|body| body.contains(k));
        let others: Vec<usize> = (0..standard.len()).filter(|k| !of_body(k)).collect();
        let all = standard.variables();
        let mut variables = Vec::new();
        for &first in &standard.bodies {
            let body = standard.body_name(first);
            variables.extend(NAMES.iter().enumerate().map(|(k, name)| {
                let variable = Variable::free(format!("{body}.{name}"), "1");
                match (1..=LOGARITHMS).contains(&k) {
                    true => variable.within(LEAST_LOGARITHM, f64::INFINITY),
                    false => variable,
                }
            }));
        }
        variables.extend(others.iter().map(|&k| all[k].clone()));
        let pull = pull(standard, &standard.reference(), PULL);
        let rows = match problem.form().objective {
            Objective::SumOfSquares { rows } => rows + pull.offset.len(),
            Objective::Smooth => pull.offset.len(),
        };
        Ok(Self {
            form: Form {
                variables,
                objective: Objective::SumOfSquares { rows },
                constraints: Vec::new(),
                structure: Structure::Smooth,
            },
            problem,
            setting,
            bodies,
            others,
            pull,
        })
    }

    /// Coordinates of unknowns whose bodies are possible; a body at its edge is taken a little inside.
    pub fn coordinates(&self, x: &DVector<f64>) -> DVector<f64> {
        let values = self.setting.standard.values(x);
        let bodies = self.setting.standard.bodies.iter();
        let mut theta: Vec<f64> = bodies
            .flat_map(|&first| coordinates(&scaled_body(&values, first), self.setting.margin))
            .collect();
        theta.extend(self.others.iter().map(|&k| x[k]));
        DVector::from_vec(theta)
    }

    /// The unknowns at coordinates, and their derivatives.
    pub fn unknowns(&self, theta: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let size = self.setting.standard.len();
        let (mut x, mut slopes) = (DVector::zeros(size), DMatrix::zeros(size, theta.len()));
        for (body, positions) in self.bodies.iter().enumerate() {
            let first = PER_LINK * body;
            let own: [f64; PER_LINK] = std::array::from_fn(|k| theta[first + k]);
            let (parameters, by_coordinate) = parameters(&own, self.setting.margin);
            for (entry, &k) in positions.iter().enumerate() {
                x[k] = parameters.0[entry];
                for (c, slope) in by_coordinate.iter().enumerate() {
                    slopes[(k, first + c)] = slope.0[entry];
                }
            }
        }
        let first = PER_LINK * self.bodies.len();
        for (j, &k) in self.others.iter().enumerate() {
            x[k] = theta[first + j];
            slopes[(k, first + j)] = 1.0;
        }
        (x, slopes)
    }
}

/// Positions among the unknowns of a body's ten parameters.
fn whole_body(
    standard: &StandardParameters<'_>,
    first: usize,
) -> Result<[usize; PER_LINK], EstimateError> {
    let mut positions = [0; PER_LINK];
    for (entry, position) in positions.iter_mut().enumerate() {
        let found = standard.parameters.iter().position(|&p| p == first + entry);
        *position = found.ok_or_else(|| EstimateError::PartOfBodyInChart {
            body: standard.body_name(first),
        })?;
    }
    Ok(positions)
}

/// `(α, d, s, t)` of a scaled pseudo-inertia.
fn coordinates(scaled: &Matrix4<f64>, margin: f64) -> [f64; PER_LINK] {
    let mut room = margin;
    let upper = loop {
        // Columns from the last: the factor is upper triangular, with the mass in its corner.
        let shifted = scaled + Matrix4::identity() * (room - margin - margin);
        let turned = Matrix4::from_fn(|i, j| shifted[(3 - i, 3 - j)]);
        match turned.cholesky() {
            Some(factor) => {
                let lower = factor.l();
                break Matrix4::from_fn(|i, j| lower[(3 - i, 3 - j)]);
            }
            None if room.is_finite() => room *= 2.0,
            // No room makes a body of what is not a number.
            None => break shifted,
        }
    };
    let size = upper[(3, 3)];
    let entry = |k: usize| {
        let value = upper[ENTRIES[k]] / size;
        if k < LOGARITHMS { value.ln() } else { value }
    };
    std::array::from_fn(|k| if k == 0 { size.ln() } else { entry(k - 1) })
}

/// The body at coordinates and its derivative with respect to each.
fn parameters(theta: &[f64; PER_LINK], margin: f64) -> (Inertia, [Inertia; PER_LINK]) {
    let unscale = Matrix4::from_diagonal(&[LENGTH, LENGTH, LENGTH, 1.0].into());
    let body = |scaled: Matrix4<f64>| Inertia::from_pseudo_inertia(&(unscale * scaled * unscale));
    let size = (2.0 * theta[0]).exp();
    let mut upper = Matrix4::zeros();
    upper[(3, 3)] = 1.0;
    for (k, &at) in ENTRIES.iter().enumerate() {
        let value = theta[1 + k];
        upper[at] = if k < LOGARITHMS { value.exp() } else { value };
    }
    let product = upper * upper.transpose() * size;
    let slopes = std::array::from_fn(|c| {
        if c == 0 {
            return body(product * 2.0);
        }
        let at = ENTRIES[c - 1];
        let mut unit = Matrix4::zeros();
        unit[at] = if c <= LOGARITHMS { upper[at] } else { 1.0 };
        body((unit * upper.transpose() + upper * unit.transpose()) * size)
    });
    (body(product + Matrix4::identity() * margin), slopes)
}

impl Problem for Chart<'_> {
    fn form(&self) -> &Form {
        &self.form
    }

    fn values(&self, theta: &DVector<f64>) -> Result<Values, OutsideDomain> {
        let (x, _) = self.unknowns(theta);
        if x.iter().any(|v| !v.is_finite()) {
            return Err(OutsideDomain::new("a body without finite parameters"));
        }
        let inner = self
            .problem
            .values(&(&self.setting.standard.to_base * &x))?;
        Ok(Values {
            cost: inner.cost + 0.5 * self.pull.at(&x).norm_squared(),
            constraints: DVector::zeros(0),
        })
    }

    fn linearize(&self, theta: &DVector<f64>) -> Result<Linearization, OutsideDomain> {
        let (x, slopes) = self.unknowns(theta);
        let to_base = &self.setting.standard.to_base;
        let root = self.problem.linearize(&(to_base * &x))?.square_root;
        let root = root.ok_or_else(|| OutsideDomain::new("a fit without a residual"))?;
        let data = root.matrix * (to_base * &slopes);
        let weak = &self.pull.matrix * slopes;
        let mut matrix = data.resize_vertically(root.residual.len() + weak.nrows(), 0.0);
        matrix
            .rows_mut(root.residual.len(), weak.nrows())
            .copy_from(&weak);
        let behind = self.pull.at(&x);
        let whole = root.residual.iter().chain(behind.iter()).copied();
        let residual = DVector::from_iterator(matrix.nrows(), whole);
        Ok(Linearization {
            cost: 0.5 * residual.norm_squared(),
            gradient: matrix.tr_mul(&residual),
            square_root: Some(SquareRoot { matrix, residual }),
            constraints: DVector::zeros(0),
            jacobian: DMatrix::zeros(0, theta.len()),
        })
    }
}

/// The feasible optimum for the weights of a problem: bodies from those of the robot file, the rest from base
/// unknowns.
pub(super) fn minimise(
    setting: Setting<'_>,
    problem: &FitProblem<'_>,
    first: &DVector<f64>,
    control: &Control<'_>,
) -> Result<Feasible, EstimateError> {
    let standard = setting.standard;
    let chart = Chart::new(problem, setting)?;
    let mut start = standard.reference();
    let given = standard.pick(&problem.parameters(first));
    for &k in &chart.others {
        let variable = &setting.constraints.variables[k];
        start[k] = within(given[k], [variable.lower, variable.upper]);
    }
    let settings = levenberg_marquardt::Settings {
        cost_tolerance: COST_TOLERANCE,
        max_iterations: ITERATION_LIMIT,
        ..levenberg_marquardt::Settings::default()
    };
    let view = LeastSquares::try_from(&chart as &dyn Problem)?;
    let start = chart.coordinates(&start);
    let found = levenberg_marquardt::minimize(view, &start, &settings, control)?;
    let (x, _) = chart.unknowns(&found.x);
    let base = &standard.to_base * &x;
    let model = compressed(problem, &base)?;
    let unconstrained = model.least_squares();
    Ok(Feasible {
        cost: model.cost(&base),
        unconstrained: unconstrained.as_ref().map_or(0.0, |b| model.cost(b)),
        inactive: unconstrained.is_some_and(|b| solve::member(setting, &b).is_some()),
        x: solve::member(setting, &base).unwrap_or(x),
        gap: f64::NAN,
        stationarity: f64::NAN,
        stop: found.stop,
        iterations: found.iterations,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::random::{body, generator, symmetric};

    const MARGIN: f64 = 1e-6;

    fn scaled(parameters: &Inertia) -> Matrix4<f64> {
        crate::estimate::derived::pseudo_inertia::scaled_pseudo_inertia(parameters)
    }

    #[test]
    fn coordinates_of_a_body_give_the_body() {
        let mut rng = generator(1);
        for _ in 0..50 {
            let truth = body(&mut rng);
            let theta = coordinates(&scaled(&truth), MARGIN);
            let (back, _) = parameters(&theta, MARGIN);
            for (a, b) in truth.0.iter().zip(back.0) {
                assert!((a - b).abs() < 1e-12 * (1.0 + truth.mass()));
            }
        }
    }

    #[test]
    fn every_point_is_a_possible_body_and_slopes_agree_with_differences() {
        const STEP: f64 = 1e-6;
        let mut rng = generator(2);
        for _ in 0..50 {
            let theta: [f64; PER_LINK] = std::array::from_fn(|_| symmetric(&mut rng, 1.0));
            let (at, slopes) = parameters(&theta, MARGIN);
            let least = scaled(&at).symmetric_eigenvalues().min();
            // Up to the rounding of the largest entries.
            assert!(least >= MARGIN - 1e-13 * scaled(&at).amax(), "{least}");
            for (c, slope) in slopes.iter().enumerate() {
                let moved = |step: f64| {
                    let mut theta = theta;
                    theta[c] += step;
                    parameters(&theta, MARGIN).0
                };
                let (ahead, behind) = (moved(STEP), moved(-STEP));
                for k in 0..PER_LINK {
                    let difference = (ahead.0[k] - behind.0[k]) / (2.0 * STEP);
                    assert!((difference - slope.0[k]).abs() < 1e-7 * (1.0 + slope.0[k].abs()));
                }
            }
        }
    }
}
