//! Expected standard deviations of an estimate from a recording of the motion: of base parameters, and of bodies in the
//! quantities that engineers read where all ten of them come out.
//!
//! `Σ = (WᵀW + M₀)⁻¹` with the rows of one period in units of the noise; nonlinear parameters of effects
//! are estimated as well where the signal depends on them at their present value.

use nalgebra::{Cholesky, DMatrix, DVector};

use crate::chain::base_parameters::BaseParameters;
use crate::chain::evaluate::{BLOCK, Evaluator, Segment};
use crate::chain::model::Model;
use crate::chain::parameter::Role;
use crate::chain::prior::Prior;
use crate::design::trajectory::motion::Motion;
use crate::robot::batch::Trajectory;
use crate::robot::inertia::{Inertia, PER_LINK, REPORTED, TENSOR};

/// One expected standard deviation; `None` where the motion does not determine the parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Deviation {
    /// Name of the parameter, or the combination as an expression.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// In that unit.
    pub std_dev: Option<f64>,
    /// The value that the prediction was made with; absent where nothing states one.
    pub value: Option<f64>,
}

/// The experiment as an estimate would see it.
#[derive(Debug, Clone, Copy)]
pub struct ExpectedEstimate<'a> {
    /// The model that would be fitted.
    pub model: &'a Model,
    /// Its base parameters.
    pub base: &'a BaseParameters,
    /// What is known before the data.
    pub prior: &'a Prior,
    /// Values at which nonlinear parameters act.
    pub values: &'a DVector<f64>,
    /// Runs, each without (false) or with the load.
    pub loads: &'a [bool],
    /// Of each channel.
    pub noise: &'a [f64],
}

impl ExpectedEstimate<'_> {
    /// Expected deviations for a motion of the motors.
    pub fn deviations(&self, motors: &Motion) -> Vec<Deviation> {
        let parameters = self.unknowns();
        let information = self.information(motors, &parameters);
        let covariance = invert(&information);
        let at = |k: usize| covariance.as_ref().map(|c| c[(k, k)].sqrt());
        let model = self.model;
        let kept = self.base.base.len();
        let mut all = Vec::new();
        let bodies = self.whole_bodies(&parameters);
        for (k, &parameter) in parameters.iter().enumerate() {
            let own = &model.parameters()[parameter];
            if let Some(body) = bodies.iter().find(|b| b.columns.contains(&k)) {
                if body.columns[0] == k {
                    all.extend(body.report(covariance.as_ref()));
                }
                continue;
            }
            let name = if k < kept {
                self.base.expression(model, k)
            } else {
                own.name.clone()
            };
            all.push(Deviation {
                name,
                unit: own.unit.clone(),
                std_dev: at(k),
                value: if k < kept {
                    self.base_value(k)
                } else {
                    self.is_stated(parameter).then(|| self.values[parameter])
                },
            });
        }
        all
    }

    /// Value of a base parameter: the kept parameter and what is regrouped with it.
    fn base_value(&self, k: usize) -> Option<f64> {
        let base = &self.base.base[k];
        let regrouped = base.others.iter();
        let is_stated = self.is_stated(base.parameter)
            || regrouped.clone().any(|(other, _)| self.is_stated(*other));
        let others = regrouped.map(|(p, factor)| factor * self.values[*p]);
        is_stated.then(|| self.values[base.parameter] + others.sum::<f64>())
    }

    /// Whether something gives the parameter a value: what nothing states is zero, as are single quantities of a body that has
    /// mass.
    fn is_stated(&self, parameter: usize) -> bool {
        let is_of_body = parameter < PER_LINK * self.model.tree().len();
        let own = match is_of_body {
            true => parameter - parameter % PER_LINK..parameter - parameter % PER_LINK + PER_LINK,
            false => parameter..parameter + 1,
        };
        own.into_iter().any(|p| self.values[p] != 0.0)
    }

    /// Kept parameters of the base, then the nonlinear ones.
    fn unknowns(&self) -> Vec<usize> {
        let mut parameters = self.base.kept();
        let all = self.model.parameters().iter().enumerate();
        parameters.extend(
            all.filter(|(_, p)| p.is_nonlinear_unknown())
                .map(|(k, _)| k),
        );
        parameters
    }

    fn information(&self, motors: &Motion, parameters: &[usize]) -> DMatrix<f64> {
        let count = parameters.len();
        let mut information = DMatrix::zeros(count, count);
        let [q, dq, ddq] = &motors.values;
        let mut evaluator = Evaluator::new(self.model, self.values, parameters);
        for &loaded in self.loads {
            let segment = Segment::states(Trajectory { q, dq, ddq }, loaded);
            for start in (0..motors.len()).step_by(BLOCK) {
                let range = start..(start + BLOCK).min(motors.len());
                let samples = range.len();
                let block = evaluator.evaluate(segment, range);
                for (c, channel) in self.model.channels().iter().enumerate() {
                    if !channel.active {
                        continue;
                    }
                    let weight = self.noise[c].recip();
                    let rows = DMatrix::from_fn(samples, count, |s, k| {
                        block.derivative(c, k).map_or(0.0, |d| weight * d[s])
                    });
                    information += rows.tr_mul(&rows);
                }
            }
        }
        let prior = self.prior.rows().select_columns(parameters);
        information + prior.tr_mul(&prior)
    }

    /// Bodies whose ten parameters are all determined by themselves, at a value with mass.
    fn whole_bodies(&self, parameters: &[usize]) -> Vec<Body> {
        let model = self.model;
        let determined = |p: usize| self.base.determines(p) && parameters.contains(&p);
        let mut bodies = Vec::new();
        for (first, parameter) in model.parameters().iter().enumerate() {
            let is_first = matches!(
                parameter.role,
                Role::Inertial { quantity: 0, .. } | Role::Payload { quantity: 0 }
            );
            if !is_first || !(first..first + PER_LINK).all(determined) {
                continue;
            }
            let values = Inertia(std::array::from_fn(|k| self.values[first + k]));
            let Some((owner, _)) = parameter.name.rsplit_once('.') else {
                continue;
            };
            if values.mass() > 0.0 {
                let columns = (first..first + PER_LINK)
                    .filter_map(|p| parameters.iter().position(|&q| q == p));
                bodies.push(Body {
                    owner: owner.to_string(),
                    columns: columns.collect(),
                    values,
                });
            }
        }
        bodies
    }
}

/// The covariance, or `None` where the information is singular; columns without any are left out of it.
fn invert(information: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let size = information.diagonal().map(|d| d.sqrt());
    let known: Vec<usize> = (0..size.len()).filter(|&k| size[k] > 0.0).collect();
    let unit = DMatrix::from_fn(known.len(), known.len(), |i, j| {
        let (i, j) = (known[i], known[j]);
        information[(i, j)] / (size[i] * size[j])
    });
    let inverse = Cholesky::new(unit)?.inverse();
    let mut covariance = DMatrix::from_element(size.len(), size.len(), f64::NAN);
    for (a, &i) in known.iter().enumerate() {
        for (b, &j) in known.iter().enumerate() {
            covariance[(i, j)] = inverse[(a, b)] / (size[i] * size[j]);
        }
    }
    Some(covariance)
}

/// A body that comes out as a whole.
struct Body {
    owner: String,
    /// Columns of its ten raw parameters.
    columns: Vec<usize>,
    values: Inertia,
}

impl Body {
    /// First-order propagation from raw parameters to mass, centre of mass and inertia about it.
    fn report(&self, covariance: Option<&DMatrix<f64>>) -> Vec<Deviation> {
        let jacobian = central_jacobian(&self.values);
        let own = covariance.map(|c| {
            let raw = c.select_rows(&self.columns).select_columns(&self.columns);
            &jacobian * raw * jacobian.transpose()
        });
        let quantities = central_quantities(&self.values);
        REPORTED
            .iter()
            .enumerate()
            .map(|(k, (quantity, unit))| Deviation {
                name: format!("{}.{quantity}", self.owner),
                unit: (*unit).to_string(),
                std_dev: own.as_ref().map(|c| c[(k, k)].sqrt()),
                value: (quantities[0] != 0.0).then_some(quantities[k]),
            })
            .collect()
    }
}

/// Mass, centre of mass, and inertia about it in the order of [`REPORTED`]; a body without mass has zeros.
fn central_quantities(body: &Inertia) -> [f64; PER_LINK] {
    let Some(c) = body.central() else {
        return [0.0; PER_LINK];
    };
    let i = c.tensor;
    [
        c.mass,
        c.centre.x,
        c.centre.y,
        c.centre.z,
        i[(0, 0)],
        i[(0, 1)],
        i[(0, 2)],
        i[(1, 1)],
        i[(1, 2)],
        i[(2, 2)],
    ]
}

/// Derivatives of mass, centre of mass and inertia about it with respect to the raw parameters:
/// `c = h/m`, `I_c = I − (hᵀh·1 − h hᵀ)/m`.
fn central_jacobian(body: &Inertia) -> DMatrix<f64> {
    let (m, h) = (body.mass(), body.first_moment());
    let mut jacobian = DMatrix::zeros(PER_LINK, PER_LINK);
    jacobian[(0, 0)] = 1.0;
    for axis in 0..3 {
        jacobian[(1 + axis, 1 + axis)] = 1.0 / m;
        jacobian[(1 + axis, 0)] = -h[axis] / (m * m);
    }
    for (k, (a, b, raw)) in TENSOR.into_iter().enumerate() {
        let row = 4 + k;
        jacobian[(row, raw)] = 1.0;
        let delta = f64::from(u8::from(a == b));
        let moved = delta * h.norm_squared() - h[a] * h[b];
        jacobian[(row, 0)] = moved / (m * m);
        for axis in 0..3 {
            let own = |x: usize| f64::from(u8::from(x == axis));
            let change = 2.0 * delta * h[axis] - own(a) * h[b] - own(b) * h[a];
            jacobian[(row, 1 + axis)] = -change / m;
        }
    }
    jacobian
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::random::{body, generator};

    #[test]
    fn invariant_jacobian_of_central_quantities_agrees_with_differences() {
        let values = body(&mut generator(4));
        let exact = central_jacobian(&values);
        let h = 1e-6;
        for raw in 0..PER_LINK {
            let moved = |by: f64| {
                let mut moved = values;
                moved.0[raw] += by;
                central_quantities(&moved)
            };
            let (after, before) = (moved(h), moved(-h));
            for k in 0..PER_LINK {
                let difference = (after[k] - before[k]) / (2.0 * h);
                // h² times third derivatives of order one, and rounding 1e-16 / h.
                assert!((difference - exact[(k, raw)]).abs() < 1e-8);
            }
        }
    }
}
