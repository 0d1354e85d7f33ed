//! The unknowns of a fit: base parameters, represented by the parameters that they keep, and the free
//! nonlinear parameters.

use crate::chain::base_parameters::{BaseParameter, BaseParameters, NEGLIGIBLE, scan_order};
use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::model::Model;
use crate::chain::prior::Prior;
use crate::estimate::fit_problem::estimator::Training;
use crate::estimate::residual::compress::{Request, factor};
use crate::estimate::residual::weights::Weights;
use crate::linalg::triangular::Triangular;
use crate::recording::split::Split;
use nalgebra::{DMatrix, DVector};

/// Unknowns in the order of the estimate's variables.
#[derive(Debug, Clone)]
pub struct Unknowns {
    /// Base parameters that structure, motion and prior determine.
    pub base: BaseParameters,
    /// Positions of the free nonlinear parameters that the recordings determine beside the base parameters.
    pub nonlinear: Vec<usize>,
}

impl Unknowns {
    /// Finds what the training recordings (with a prior) determine.
    ///
    /// Structure decides first, on generic states; then the recorded motion, which may excite less.
    pub fn find(model: &Model, data: &Dataset, prior: &Prior) -> Self {
        let structural = BaseParameters::structural(model, &data.loads(), prior.rows());
        let training: Vec<&Prepared> = data.of(Split::Train).collect();
        let columns = structural.kept();
        let channels = model.channels().len();
        let weights = Weights::PerChannel(DVector::from_element(channels, 1.0));
        let recorded = factor(
            &Request {
                model,
                values: &model.generic_values(),
                columns: &columns,
                weights: &weights,
                factors: None,
                bodies: &[],
            },
            &training,
        );
        let moved = of_motion(&recorded, &columns, prior, STILL);
        let base = compose(&structural, &moved);
        let nonlinear = determined_nonlinear(
            model,
            &base.kept(),
            Training {
                recordings: &training,
                prior,
            },
        );
        Self { base, nonlinear }
    }

    /// All but some: linear ones that are left out are zero, others what the model has.
    pub fn without(&self, unknowns: &[usize]) -> Self {
        let positions = self.positions();
        let stays = |p: &usize| !unknowns.iter().any(|k| positions[*k] == *p);
        let mut base = self.base.clone();
        let lost = base.base.iter().map(|b| b.parameter);
        base.without_effect.extend(lost.filter(|p| !stays(p)));
        base.base.retain(|b| stays(&b.parameter));
        Self {
            base,
            nonlinear: self.nonlinear.iter().copied().filter(stays).collect(),
        }
    }

    /// Positions in the model of all unknowns.
    pub fn positions(&self) -> Vec<usize> {
        let mut positions = self.base.kept();
        positions.extend(&self.nonlinear);
        positions
    }

    /// Values of the unknowns among those of all parameters.
    pub fn among(&self, values: &DVector<f64>) -> DVector<f64> {
        let positions = self.positions();
        DVector::from_iterator(positions.len(), positions.iter().map(|&p| values[p]))
    }

    /// Whether an unknown is a parameter by itself, and not a combination that it leads.
    pub fn is_single(&self, unknown: usize) -> bool {
        let base = self.base.base.get(unknown);
        base.is_none_or(|base| base.others.is_empty())
    }

    /// The base expression that holds a parameter which is not determined by itself.
    pub fn expression_with(&self, model: &Model, parameter: usize) -> Option<String> {
        let holds = |b: &BaseParameter| {
            b.parameter == parameter || b.others.iter().any(|(p, _)| *p == parameter)
        };
        let index = self.base.base.iter().position(holds)?;
        Some(self.base.expression(model, index))
    }

    /// Linear unknowns that enter no base parameter by themselves.
    pub fn undetermined(&self, model: &Model) -> Vec<usize> {
        let all = scan_order(model);
        all.into_iter()
            .filter(|&p| !self.base.determines(p))
            .collect()
    }
}

/// Nonlinear unknowns whose columns are independent of those before them. Factors of the whole torque come
/// last: where nothing fixes the scale, the declared one stays.
fn determined_nonlinear(model: &Model, kept: &[usize], training: Training<'_>) -> Vec<usize> {
    let mut nonlinear: Vec<usize> = (0..model.parameters().len())
        .filter(|&p| model.parameters()[p].is_nonlinear_unknown())
        .collect();
    if nonlinear.is_empty() {
        return nonlinear;
    }
    nonlinear.sort_by_key(|&p| scales_torque(model, p));
    let columns: Vec<usize> = kept.iter().chain(&nonlinear).copied().collect();
    let weights = Weights::PerChannel(DVector::from_element(model.channels().len(), 1.0));
    let request = Request {
        model,
        values: &model.generic_values(),
        columns: &columns,
        weights: &weights,
        factors: None,
        bodies: &[],
    };
    let independent = of_motion(
        &factor(&request, training.recordings),
        &columns,
        training.prior,
        NEGLIGIBLE,
    )
    .kept();
    nonlinear.retain(|p| independent.contains(p));
    nonlinear.sort_unstable();
    nonlinear
}

/// Whether a parameter is a factor of a joint's whole torque.
fn scales_torque(model: &Model, parameter: usize) -> bool {
    let joints = model.joints().iter();
    let mut factors =
        joints.flat_map(|j| [j.gain, j.polynomial.map(|first| first + 1), j.controller]);
    factors.any(|p| p == Some(parameter))
}

/// Share of the largest column below which a column of a recorded motion is the rounding of its filters: that of an
/// inertia where nothing accelerates. Nonlinear parameters have no such scale: that of a stiff spring moves little and is seen.
const STILL: f64 = 1e-9;

/// Base parameters of the recorded motion among the structural ones.
fn of_motion(
    recorded: &Triangular,
    columns: &[usize],
    prior: &Prior,
    negligible: f64,
) -> BaseParameters {
    let count = columns.len();
    let mut both = DMatrix::zeros(count + prior.len(), count);
    for i in 0..count {
        for j in i..count {
            both[(i, j)] = recorded.entry(i, j);
        }
    }
    for (j, &parameter) in columns.iter().enumerate() {
        let column = prior.rows().column(parameter);
        both.view_mut((count, j), (prior.len(), 1))
            .copy_from(&column);
    }
    BaseParameters::scan_above(&Triangular::of(&both), columns, negligible)
}

/// Combinations of combinations: what the motion merges, in terms of the model's parameters.
fn compose(structural: &BaseParameters, moved: &BaseParameters) -> BaseParameters {
    let of = |parameter: usize| structural.base.iter().find(|b| b.parameter == parameter);
    let base = moved.base.iter().map(|outer| {
        let mut others: Vec<(usize, f64)> = Vec::new();
        let mut add = |parameter: usize, coefficient: f64| match others
            .iter_mut()
            .find(|(p, _)| *p == parameter)
        {
            Some((_, sum)) => *sum += coefficient,
            None => others.push((parameter, coefficient)),
        };
        if let Some(inner) = of(outer.parameter) {
            inner.others.iter().for_each(|&(p, c)| add(p, c));
        }
        for &(parameter, coefficient) in &outer.others {
            add(parameter, coefficient);
            if let Some(inner) = of(parameter) {
                inner
                    .others
                    .iter()
                    .for_each(|&(p, c)| add(p, coefficient * c));
            }
        }
        BaseParameter {
            parameter: outer.parameter,
            others,
        }
    });
    let mut without_effect = structural.without_effect.clone();
    for &parameter in &moved.without_effect {
        without_effect.push(parameter);
        if let Some(inner) = of(parameter) {
            // What entered only together with it has no effect either, unless another base holds it.
            let held = |p: usize| {
                moved
                    .base
                    .iter()
                    .any(|b| of(b.parameter).is_some_and(|s| s.others.iter().any(|(q, _)| *q == p)))
            };
            without_effect.extend(inner.others.iter().map(|(p, _)| *p).filter(|&p| !held(p)));
        }
    }
    BaseParameters {
        base: base.collect(),
        without_effect,
    }
}
