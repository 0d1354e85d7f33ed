//! The program in the variables' steps, `½ ‖M d + r‖² + cᵀ d − Σ γ_k log det S_k(d)` over cones S_k, and in coordinates
//! of them.

use crate::problem::Linearization;
use crate::problem::error::{ProblemError, ProblemErrorKind};
use crate::problem::form::{Form, Objective, Set};
use crate::solve::error::{SolveError, SolveErrorKind};
use crate::solve::interior::block::Cone;
use crate::solve::interior::coordinates::Coordinates;
use crate::solve::interior::small::{self, LARGEST, Small};
use nalgebra::DVector;

/// What is added to the cost of a problem.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Terms {
    /// c; empty for none.
    pub linear: DVector<f64>,
    /// γ of every constraint of the form, in its order; those that are missing are zero.
    pub log_det: Vec<f64>,
}

pub(super) struct Program {
    /// Of the step, with the sum of squares in them.
    pub coordinates: Coordinates,
    /// c over the coordinates.
    pub linear: DVector<f64>,
    /// Blocks of the constraints in their order, then the bounds.
    pub cones: Vec<Cone>,
    /// Constraint of every cone, or the variable of a bound.
    pub origins: Vec<Origin>,
    /// f at d = 0 less ½ ‖r‖².
    pub constant: f64,
}

/// Where a cone comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Origin {
    /// First row among the rows of all constraints.
    Rows(usize),
    Bound(usize),
}

impl Program {
    pub fn new(
        form: &Form,
        start: &DVector<f64>,
        model: Linearization,
        terms: &Terms,
    ) -> Result<Self, SolveError> {
        let mut program = Self {
            coordinates: Coordinates::of_scales(form),
            linear: terms.linear.clone(),
            cones: Vec::new(),
            origins: Vec::new(),
            constant: model.cost,
        };
        if program.linear.is_empty() {
            program.linear = DVector::zeros(start.len());
        }
        let mut first = 0;
        for (index, constraint) in form.constraints.iter().enumerate() {
            let order = match constraint.set {
                Set::Nonnegative => 1,
                Set::Psd { order } if order <= LARGEST => order,
                Set::Psd { order } => return Err(large(&constraint.name, order)),
                Set::Zero => {
                    let kind = ProblemErrorKind::HasCone {
                        view: "the interior-point method",
                    };
                    return Err(ProblemError::at(&constraint.name, kind).into());
                }
            };
            let weight = terms.log_det.get(index).copied().unwrap_or(0.0);
            let rows = order * (order + 1) / 2;
            for row in (first..first + constraint.rows).step_by(rows.max(1)) {
                let cone = block(&model, row, order, weight);
                program.cones.push(cone);
                program.origins.push(Origin::Rows(row));
            }
            first += constraint.rows;
        }
        program.add_bounds(form, start);
        match (form.objective, model.square_root) {
            (Objective::SumOfSquares { .. }, Some(root)) => {
                program.constant -= 0.5 * root.residual.norm_squared();
                program.coordinates = Coordinates::of_squares(form, &root)
                    .ok_or_else(|| SolveError::whole(SolveErrorKind::ModelNotFinite))?;
            }
            (Objective::SumOfSquares { .. }, None) => {
                return Err(SolveError::whole(SolveErrorKind::ModelNotFinite));
            }
            (Objective::Smooth, _) => program.linear += model.gradient,
        }
        program.linear = program.coordinates.basis.tr_mul(&program.linear);
        Ok(program)
    }

    fn add_bounds(&mut self, form: &Form, start: &DVector<f64>) {
        for (j, variable) in form.variables.iter().enumerate() {
            let (below, above) = (start[j] - variable.lower, variable.upper - start[j]);
            for (sign, room) in [(1.0, below), (-1.0, above)] {
                if room.is_finite() {
                    let corner = |value: f64| {
                        let mut matrix = Small::zeros();
                        matrix[(0, 0)] = value / variable.scale;
                        matrix
                    };
                    self.cones.push(Cone {
                        order: 1,
                        columns: vec![j],
                        slopes: vec![corner(sign)],
                        constant: corner(room),
                        weight: 0.0,
                    });
                    self.origins.push(Origin::Bound(j));
                }
            }
        }
    }

    /// The cost without its logarithms.
    pub fn cost(&self, y: &DVector<f64>) -> f64 {
        self.coordinates.squares(y) + self.linear.dot(y) + self.constant
    }

    /// Gradient of that.
    pub fn gradient(&self, y: &DVector<f64>) -> DVector<f64> {
        self.coordinates.gradient(y) + &self.linear
    }

    /// Sum of the orders of the cones without a weight.
    pub fn degree(&self) -> usize {
        let free = self.cones.iter().filter(|c| c.weight == 0.0);
        free.map(|c| c.order).sum()
    }
}

fn large(name: &str, order: usize) -> SolveError {
    let kind = SolveErrorKind::Setting {
        value: order as f64,
        range: "order <= 4 of every semidefinite block",
    };
    SolveError::at(name, kind)
}

fn block(model: &Linearization, row: usize, order: usize, weight: f64) -> Cone {
    let rows = order * (order + 1) / 2;
    let view = model.jacobian.rows(row, rows);
    let sees = |j: &usize| view.column(*j).iter().any(|x| *x != 0.0);
    let columns: Vec<usize> = (0..model.jacobian.ncols()).filter(sees).collect();
    let of = |j: &usize| {
        let entries: Vec<f64> = view.column(*j).iter().copied().collect();
        small::smat(&entries, order)
    };
    Cone {
        order,
        slopes: columns.iter().map(of).collect(),
        columns,
        constant: small::smat(&model.constraints.as_slice()[row..row + rows], order),
        weight,
    }
}
