//! Standard parameters, the unknowns of a feasible fit: every free linear parameter by itself, then the nonlinear ones, and the
//! base parameters as their combinations `β = T x`.

use crate::chain::base_parameters::{BaseParameter, BaseParameters};
use crate::chain::model::Model;
use crate::chain::parameter::Role;
pub use crate::estimate::derived::pseudo_inertia::LENGTH;
use crate::estimate::derived::pseudo_inertia::{ROWS, scaled_pseudo_inertia, scaled_rows};
use crate::estimate::derived::realization;
use crate::estimate::fit_problem::unknowns::Unknowns;
use crate::problem::affine::AffineRows;
use crate::problem::form::Variable;
use crate::robot::inertia::{Inertia, PER_LINK};
use nalgebra::{DMatrix, DVector, Matrix4, SymmetricEigen};

/// Smallest eigenvalue of a reference body's scaled pseudo-inertia, kg: a robot file may leave a body out.
const LEAST_REFERENCE: f64 = 1e-3;

/// Unknowns of a feasible fit in their order.
#[derive(Debug)]
pub struct StandardParameters<'a> {
    /// Whose parameters the unknowns are.
    pub model: &'a Model,
    /// Positions in the model: linear unknowns in the order of the scan, then nonlinear ones.
    pub parameters: Vec<usize>,
    /// How many of them are linear.
    pub linear: usize,
    /// T, base unknowns x unknowns.
    pub to_base: DMatrix<f64>,
    /// Directions that change no base parameter, unknowns x directions.
    pub null: DMatrix<f64>,
    /// First parameter of every body with an unknown.
    pub bodies: Vec<usize>,
}

impl<'a> StandardParameters<'a> {
    /// Of the unknowns of a fit: those that the data determine together with those that only their combinations determine.
    pub fn new(model: &'a Model, unknowns: &Unknowns) -> Self {
        let linear = crate::chain::base_parameters::scan_order(model);
        let count = linear.len();
        let mut parameters = linear;
        parameters.extend(&unknowns.nonlinear);
        let at = |p: usize| parameters.iter().position(|&q| q == p);
        let base = &unknowns.base.base;
        let mut to_base = DMatrix::zeros(base.len() + unknowns.nonlinear.len(), parameters.len());
        for (row, entry) in base.iter().enumerate() {
            let own = (entry.parameter, 1.0);
            for &(p, coefficient) in std::iter::once(&own).chain(&entry.others) {
                if let Some(column) = at(p) {
                    to_base[(row, column)] = coefficient;
                }
            }
        }
        for k in 0..unknowns.nonlinear.len() {
            to_base[(base.len() + k, count + k)] = 1.0;
        }
        let kept: Vec<usize> = base.iter().filter_map(|b| at(b.parameter)).collect();
        let others: Vec<usize> = (0..count).filter(|k| !kept.contains(k)).collect();
        let mut null = DMatrix::zeros(parameters.len(), others.len());
        for (direction, &free) in others.iter().enumerate() {
            null[(free, direction)] = 1.0;
            for (row, &k) in kept.iter().enumerate() {
                null[(k, direction)] = -to_base[(row, free)];
            }
        }
        Self {
            model,
            bodies: realization::bodies(model),
            linear: count,
            parameters,
            to_base,
            null,
        }
    }

    /// Number of unknowns.
    pub fn len(&self) -> usize {
        self.parameters.len()
    }

    /// Whether nothing is unknown.
    pub fn is_empty(&self) -> bool {
        self.parameters.is_empty()
    }

    /// Values of all parameters of the model.
    pub fn values(&self, x: &DVector<f64>) -> DVector<f64> {
        let mut values = self.model.values();
        for (k, &p) in self.parameters.iter().enumerate() {
            values[p] = x[k];
        }
        self.model.spread(&mut values);
        values
    }

    /// The unknowns of values of all parameters.
    pub fn pick(&self, values: &DVector<f64>) -> DVector<f64> {
        DVector::from_iterator(self.len(), self.parameters.iter().map(|&p| values[p]))
    }

    /// Variables with natural limits and those that were asked for.
    pub fn variables(&self) -> Vec<Variable> {
        let of = |&p: &usize| {
            let parameter = &self.model.parameters()[p];
            Variable::free(&parameter.name, &parameter.unit)
                .scale(parameter.scale)
                .within(parameter.lower, parameter.upper)
        };
        self.parameters.iter().map(of).collect()
    }

    /// Name of a body by its first parameter.
    pub fn body_name(&self, first: usize) -> String {
        match self.model.parameters()[first].role {
            Role::Payload { .. } => "payload".to_string(),
            _ => self.model.tree().joints()[first / PER_LINK].link.clone(),
        }
    }

    /// svec of the scaled pseudo-inertias of all bodies at x = 0, and per unit of every unknown.
    pub fn pseudo_inertias(&self) -> AffineRows {
        let rows = |values: &DVector<f64>| {
            let stacked = self.bodies.iter().flat_map(|&b| scaled_rows(values, b));
            DVector::from_iterator(ROWS * self.bodies.len(), stacked)
        };
        let constant = rows(&self.values(&DVector::zeros(self.len())));
        let mut slopes = DMatrix::zeros(constant.len(), self.len());
        for (k, &p) in self.parameters.iter().enumerate() {
            if matches!(
                self.model.parameters()[p].role,
                Role::Inertial { .. } | Role::Payload { .. }
            ) {
                let mut unit = DVector::zeros(self.model.parameters().len());
                unit[p] = 1.0;
                slopes.set_column(k, &rows(&unit));
            }
        }
        AffineRows {
            matrix: slopes,
            offset: constant,
        }
    }

    /// Scaled pseudo-inertias of the robot file's bodies, made definite where they are not, in the order of
    /// the bodies.
    pub fn references(&self) -> Vec<Matrix4<f64>> {
        let file = self.model.tree().parameters();
        let of = |&first: &usize| {
            let body = match self.model.parameters()[first].role {
                Role::Payload { .. } => Inertia::default(),
                _ => Inertia(std::array::from_fn(|k| file[first + k])),
            };
            let scaled = scaled_pseudo_inertia(&body);
            let least = SymmetricEigen::new(scaled).eigenvalues.min();
            scaled + Matrix4::identity() * (LEAST_REFERENCE - least).max(0.0)
        };
        self.bodies.iter().map(of).collect()
    }

    /// Unknowns at the reference bodies, the others inside their limits.
    pub fn reference(&self) -> DVector<f64> {
        let mut values = self.model.values();
        for (&first, scaled) in self.bodies.iter().zip(self.references()) {
            let unscale = Matrix4::from_diagonal(&[LENGTH, LENGTH, LENGTH, 1.0].into());
            let body = Inertia::from_pseudo_inertia(&(unscale * scaled * unscale));
            for k in 0..PER_LINK {
                values[first + k] = body.0[k];
            }
        }
        for &p in &self.parameters {
            let parameter = &self.model.parameters()[p];
            let room = parameter
                .scale
                .min(0.5 * (parameter.upper - parameter.lower));
            if parameter.lower.is_finite() && parameter.upper > parameter.lower {
                values[p] = values[p].max(parameter.lower + room);
            }
            if parameter.upper.is_finite() && parameter.upper > parameter.lower {
                values[p] =
                    values[p].min(parameter.upper - room.min(parameter.upper - parameter.lower));
            }
        }
        self.pick(&values)
    }

    /// The same unknowns in the shape of those of other fits: every linear one stands for itself.
    pub fn unknowns(&self) -> Unknowns {
        let single = |&parameter: &usize| BaseParameter {
            parameter,
            others: Vec::new(),
        };
        Unknowns {
            base: BaseParameters {
                base: self.parameters[..self.linear].iter().map(single).collect(),
                without_effect: Vec::new(),
            },
            nonlinear: self.parameters[self.linear..].to_vec(),
        }
    }
}
