//! One side of the comparison: an identified model with the recordings that it was identified from.

use std::collections::BTreeMap;

use crate::chain::dataset::Dataset;
use crate::chain::effect::{Effect, find};
use crate::chain::model::Model;
use crate::diagnose::conclusion::zero_size::sizes_alone;
use crate::outcome::estimate::Estimate;
use crate::outcome::finding::Finding;
use crate::outcome::fit::Fit;
use crate::outcome::joint::JointFigures;
use crate::outcome::parameter::Parameter;
use crate::stats::deviation::rms;
use crate::stats::distribution::Distribution;
use nalgebra::DVector;

/// Share of a signal that is too small to matter, as it is for a finding.
pub(super) const NEGLIGIBLE: f64 = 0.002;

/// An identified model.
#[derive(Debug, Clone, Copy)]
pub struct Side<'a> {
    /// Its parameters with deviations.
    pub estimate: &'a Estimate,
    /// Its base parameters and what else a fit says.
    pub fit: &'a Fit,
    /// Physics beyond the declared model; empty after a fit.
    pub findings: &'a [Finding],
    /// The identified model, with findings where there are any.
    pub model: &'a Model,
    /// All its parameters, in SI units.
    pub values: &'a DVector<f64>,
    /// What it was identified from.
    pub data: &'a Dataset,
}

/// A parameter of an effect by the parts of its name.
#[derive(Debug, Clone, Copy)]
pub(super) struct Named<'a> {
    /// `None` of an effect of the whole robot.
    pub joint: Option<&'a str>,
    pub effect: &'static Effect,
    pub parameter: &'a str,
}

impl<'a> Named<'a> {
    /// `None` where a name is not that of an effect's parameter.
    pub fn of(name: &'a str) -> Option<Self> {
        let (prefix, parameter) = name.rsplit_once('.')?;
        let (joint, id) = match prefix.rsplit_once('.') {
            Some((joint, id)) => (Some(joint), id),
            None => (None, prefix),
        };
        let effect = find(id)?;
        Some(Self {
            joint,
            effect,
            parameter,
        })
    }

    pub fn is_of(&self, other: &Named<'_>) -> bool {
        self.joint == other.joint && self.effect.id == other.effect.id
    }

    /// The value of a size at which there is nothing of the effect; `None` of what is not a size.
    pub fn nothing(&self) -> Option<f64> {
        let mut sizes = sizes_alone(self.effect).into_iter();
        sizes
            .find(|s| s.parameter == self.parameter)
            .map(|s| s.nothing)
    }
}

/// A combination of parameters that a model's recordings determine.
#[derive(Debug, Clone)]
pub(super) struct Determined {
    pub expression: String,
    pub unit: String,
    /// Coefficients by raw parameter; that of `leading` is one, and no other combination has it.
    pub terms: BTreeMap<String, f64>,
    pub leading: String,
    pub value: f64,
    pub variance: f64,
}

impl Side<'_> {
    /// Combinations with a finite variance, with their numbers in the posterior.
    pub(super) fn determined(&self) -> Vec<(usize, Determined)> {
        let posterior = &self.fit.posterior;
        let base = &self.fit.base_parameters;
        let of = |(k, combination): (usize, &crate::outcome::fit::Combination)| {
            let variance = *posterior.covariance.get(k)?.get(k)?;
            let leading = combination.terms.first()?.parameter.clone();
            let single = combination.terms.len() == 1;
            let unit = self
                .model
                .parameters()
                .iter()
                .find(|p| p.name == leading)
                .map_or_else(String::new, |p| p.unit.clone());
            let expression = match base.get(k) {
                Some(base) if !single => base.expression.clone(),
                _ => leading.clone(),
            };
            let terms = combination.terms.iter();
            let determined = Determined {
                expression,
                unit,
                terms: terms
                    .map(|t| (t.parameter.clone(), t.coefficient))
                    .collect(),
                leading,
                value: combination.value,
                variance,
            };
            let is_finite =
                variance.is_finite() && variance >= 0.0 && combination.value.is_finite();
            is_finite.then_some((k, determined))
        };
        posterior
            .combinations
            .iter()
            .enumerate()
            .filter_map(of)
            .collect()
    }

    /// Whether the model has an effect, and some size of it is told from none.
    pub(super) fn shows(&self, named: &Named<'_>) -> bool {
        let quantile = Distribution::Normal.two_sided(0.95);
        let own = self.of_effect(named);
        let mut has_size = false;
        for parameter in &own {
            let size = Named::of(&parameter.name).and_then(|n| n.nothing());
            let (Some(nothing), Some(value)) = (size, parameter.value) else {
                continue;
            };
            has_size = true;
            let half = quantile * parameter.std_dev.unwrap_or(0.0);
            if (value - nothing).abs() > half {
                return true;
            }
        }
        // What has no parameter that is its size is there where the model has it.
        !own.is_empty() && !has_size
    }

    /// Joints of whose signals the model leaves more beyond the noise than the noise itself, and more than is negligible, with
    /// the share.
    pub(super) fn unexplained(&self) -> Vec<(String, f64)> {
        let of = |figures: &JointFigures| {
            let noise = figures.noise_rms?;
            let beyond = (figures.rmse_train.powi(2) - noise.powi(2)).max(0.0).sqrt();
            let share = figures.relative_train * beyond / figures.rmse_train;
            (beyond > noise && share > NEGLIGIBLE).then(|| (figures.joint.clone(), share))
        };
        self.estimate.joints.iter().filter_map(of).collect()
    }

    /// Whether a finding takes more than a negligible share of the signal of its channels, or none is known. What a simulator without
    /// noise shows may be its integration.
    pub(super) fn matters(&self, finding: &Finding) -> bool {
        let of_joint = self.estimate.joints.iter();
        let own = of_joint.filter(|figures| finding.joints.contains(&figures.joint));
        let signals: Vec<f64> = own.map(|f| f.rmse_train / f.relative_train).collect();
        let before = finding.rmse_validation_before.powi(2);
        let taken = (before - finding.rmse_validation_after.powi(2)).max(0.0);
        let share = taken.sqrt() / rms(&signals);
        share.is_nan() || share >= NEGLIGIBLE
    }

    /// Parameters of an effect.
    pub(super) fn of_effect(&self, named: &Named<'_>) -> Vec<&Parameter> {
        let all = self.estimate.parameters.iter();
        all.filter(|p| Named::of(&p.name).is_some_and(|n| n.is_of(named)))
            .collect()
    }
}
