//! Whether recordings refuse that joints have parameters of an effect in common:
//!
//! ```text
//! W = (R θ)ᵀ (R C Rᵀ)⁻¹ (R θ) ~ χ²(r)     where they have
//! ```
//!
//! with the estimate θ of a model in which every joint has its own, its covariance C in the noise as it is, coloured and
//! correlated across channels, and the r differences R θ between the first joint and the others (Wald 1943). For linear
//! parameters in Gaussian noise W is minus twice the logarithm of the likelihood ratio of the two models.

use crate::chain::dataset::Dataset;
use crate::chain::model::Model;
use crate::chain::prior::Prior;
use crate::chain::sharing::Sharing;
use crate::chain::transition_limits::TransitionLimits;
use crate::chain::words::{list, short};
use crate::estimate::fit::Fitted;
use crate::estimate::initial::search_range;
use crate::outcome::estimate::Estimate;
use crate::outcome::parameter::{Parameter, Source};
use crate::outcome::sharing::{SeparateValue, SharedParameter, Sharing as Answer};
use crate::setup::error::SetupError;
use crate::setup::model_spec::{Addition, ModelSpec, ModelWithPrior};
use crate::stats::distribution::Distribution;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Chance that any of the questions of a run is refused where joints do have all parameters in common.
pub const SIGNIFICANCE: f64 = 0.01;

/// Share of the largest eigenvalue of the correlation of differences below which one of them follows from the others.
const RANK: f64 = 1e-10;

/// What a result says where the models to compare with cannot be built or fitted; what was found before stays.
pub fn unanswered(error: &dyn std::error::Error) -> String {
    format!(
        "Whether joints have parameters in common ([[drive.shared]]) could not be asked: {error}"
    )
}

/// Questions about the parameters that joints with motors of one type have in common.
#[derive(Debug, Clone, Copy)]
pub struct Question<'a> {
    /// What is declared, and which joints have motors of one type.
    pub declared: &'a ModelSpec,
    /// Physics of the model beside what is declared.
    pub addition: &'a Addition,
    /// What is fitted.
    pub data: &'a Dataset,
    /// Of the transition speeds of the fitted model.
    pub limits: &'a TransitionLimits,
}

impl Question<'_> {
    /// Answers of the recordings, beside the model that was fitted to them; `fit` fits another model.
    ///
    /// # Errors
    /// Those of building and fitting the models to compare with.
    pub fn answers<E: From<SetupError>>(
        &self,
        fitted: &Fitted,
        fit: &dyn Fn(&Model, &Prior) -> Result<Fitted, E>,
    ) -> Result<Vec<Answer>, E> {
        let model = &fitted.model;
        let proposed = self.declared.proposed_sharing(model);
        let tests = model.shared().len() + proposed.len();
        if tests == 0 {
            return Ok(Vec::new());
        }
        let of_joints = match model.shared().is_empty() {
            true => None,
            false => {
                let separated = self.declared.separated();
                Some(fit_beside(self, &separated, fitted, Vec::new(), fit)?)
            }
        };
        let separate = of_joints.as_ref().unwrap_or(fitted);
        let level = SIGNIFICANCE / tests as f64;
        let test = |all: &[Sharing]| -> Vec<Tested> {
            let each = all.iter();
            each.map(|sharing| Tested::of(sharing, separate, level))
                .collect()
        };
        let mut declared = test(model.shared());
        for tested in &mut declared {
            tested.in_model = true;
        }
        let open = test(&proposed);
        let kept = proposed.iter().zip(&open);
        let kept = kept.filter(|(_, tested)| tested.wald.is_some() && !tested.refused);
        let kept: Vec<Sharing> = kept.map(|(sharing, _)| sharing.clone()).collect();
        let common = match kept.is_empty() {
            true => None,
            false => Some(fit_beside(self, self.declared, fitted, kept, fit)?),
        };
        let in_model = declared.iter().map(|t| t.answer(Some(&fitted.estimate)));
        let common = common.as_ref().map(|fitted| &fitted.estimate);
        let asked = open.iter().map(|t| t.answer(common.filter(|_| !t.refused)));
        Ok(in_model.chain(asked).collect())
    }
}

/// Fits a model with other parameters in common, from the shapes of the one that was fitted.
fn fit_beside<E: From<SetupError>>(
    question: &Question<'_>,
    declared: &ModelSpec,
    fitted: &Fitted,
    shared: Vec<Sharing>,
    fit: &dyn Fn(&Model, &Prior) -> Result<Fitted, E>,
) -> Result<Fitted, E> {
    let addition = Addition {
        shared,
        ..question.addition.clone()
    };
    let ModelWithPrior { mut model, prior } = declared.build_with(&addition)?;
    model.limit_transitions(question.limits);
    search_range::start_within_motion(&mut model, question.data);
    for p in 0..model.parameters().len() {
        let parameter = &model.parameters()[p];
        let before = fitted.model.find(&parameter.name);
        if let (false, true, Ok(k)) = (parameter.is_linear(), parameter.is_free(), before) {
            model.start(p, fitted.values[k]);
        }
    }
    fit(&model, &prior)
}

/// A question with what a fit in which every joint has its own parameters says of it.
struct Tested {
    /// Identifier of the effect.
    effect: &'static str,
    joints: Vec<String>,
    /// A row for every parameter, an entry for every joint.
    rows: Vec<Vec<Parameter>>,
    wald: Option<Wald>,
    refused: bool,
    in_model: bool,
}

/// The statistic of the differences between joints.
struct Wald {
    statistic: f64,
    freedom: usize,
    p_value: f64,
}

impl Tested {
    fn of(sharing: &Sharing, separate: &Fitted, level: f64) -> Self {
        let (model, estimate) = (&separate.model, &separate.estimate);
        let name = |p: &usize| &model.parameters()[*p].name;
        let row = |row: Vec<usize>| -> Vec<Parameter> {
            let found = row.iter().filter_map(|p| estimate.find(name(p)));
            found.cloned().collect()
        };
        let positions = sharing.positions(model.joints()).into_iter();
        let rows: Vec<Vec<Parameter>> = positions.map(row).collect();
        let wald = wald(&rows, estimate);
        let joints = sharing.having(model.joints()).into_iter();
        Self {
            effect: sharing.effect.id,
            joints: joints.map(|j| model.joints()[j].name.clone()).collect(),
            rows,
            refused: wald.as_ref().is_some_and(|wald| wald.p_value < level),
            wald,
            in_model: false,
        }
    }

    /// As results have it, with the values of a model in which they are common.
    fn answer(&self, common: Option<&Estimate>) -> Answer {
        let parameters: Vec<SharedParameter> = self
            .rows
            .iter()
            .filter_map(|row| {
                let first = row.first()?;
                let shared = common.and_then(|estimate| estimate.find(&first.name));
                Some(SharedParameter {
                    name: without_joint(&first.name).to_string(),
                    unit: first.unit.clone(),
                    value: shared.and_then(|p| p.value),
                    std_dev: shared.and_then(|p| p.std_dev),
                    ci95: shared.and_then(|p| p.ci95),
                    separate: self
                        .joints
                        .iter()
                        .zip(row)
                        .map(|(joint, own)| separate_value(joint, own))
                        .collect(),
                })
            })
            .collect();
        Answer {
            effect: self.effect.to_string(),
            joints: self.joints.clone(),
            in_model: self.in_model,
            sentence: self.sentence(&parameters),
            parameters,
            statistic: self.wald.as_ref().map(|wald| wald.statistic),
            degrees_of_freedom: self.wald.as_ref().map_or(0, |wald| wald.freedom),
            p_value: self.wald.as_ref().map(|wald| wald.p_value),
            refused: self.refused,
        }
    }

    fn sentence(&self, parameters: &[SharedParameter]) -> String {
        let (id, joints) = (self.effect, list(&self.joints));
        let Some(wald) = &self.wald else {
            return format!(
                "The recordings do not determine `{id}` of {joints} one by one, so that they cannot say whether these have it in common."
            );
        };
        let chance = format!(
            "χ² = {:.1} of {} differences, p = {}",
            wald.statistic,
            wald.freedom,
            short(wald.p_value)
        );
        if self.refused {
            let remedy = match self.in_model {
                true => "; the values are those of no motor, take the effect out of drive.shared",
                false => "",
            };
            return format!(
                "The recordings refuse that {joints} have `{id}` in common ({chance}): {}{remedy}.",
                differences(parameters)
            );
        }
        let gain = shorter(parameters).map_or_else(String::new, |factor| {
            format!(" Intervals are {factor:.1} times shorter than those of single joints.")
        });
        match self.in_model {
            true => format!(
                "{joints} have `{id}` in common, and the recordings do not refuse that ({chance}).{gain}"
            ),
            false => format!(
                "{joints} may have `{id}` in common: the recordings do not refuse that ({chance}).{gain} To share it, set \
                 joints = [{}] and effects = [\"{id}\"] in a table [[drive.shared]].",
                quoted(&self.joints)
            ),
        }
    }
}

fn separate_value(joint: &str, own: &Parameter) -> SeparateValue {
    SeparateValue {
        joint: joint.to_owned(),
        value: own.value,
        std_dev: own.std_dev,
    }
}

fn without_joint(name: &str) -> &str {
    name.split_once('.').map_or(name, |(_, rest)| rest)
}

fn quoted(names: &[String]) -> String {
    let all: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
    all.join(", ")
}

/// The parameter whose values lie furthest apart in their deviations, on every joint.
fn differences(parameters: &[SharedParameter]) -> String {
    let apart = |p: &SharedParameter| {
        let values = p.separate.iter().filter_map(|s| s.value);
        let (least, most) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        let deviations = p.separate.iter().filter_map(|s| s.std_dev);
        (most - least) / deviations.fold(f64::MIN_POSITIVE, f64::max)
    };
    let Some(most) = parameters
        .iter()
        .max_by(|a, b| apart(a).total_cmp(&apart(b)))
    else {
        return String::new();
    };
    let values = most.separate.iter().filter_map(|own| {
        let deviation = own
            .std_dev
            .map_or_else(String::new, |s| format!(" ± {s:.2e}"));
        Some(format!("{} {:.4}{deviation}", own.joint, own.value?))
    });
    let unit = match most.unit.as_str() {
        "" => String::new(),
        unit => format!(" {unit}"),
    };
    format!(
        "{} is {}{unit}",
        most.name,
        values.collect::<Vec<_>>().join(", ")
    )
}

/// By how much the intervals of common values are shorter than the mean ones of single joints: the geometric mean.
fn shorter(parameters: &[SharedParameter]) -> Option<f64> {
    let of = |p: &SharedParameter| {
        let own: Vec<f64> = p.separate.iter().filter_map(|s| s.std_dev).collect();
        let mean = own.iter().sum::<f64>() / own.len() as f64;
        p.std_dev
            .filter(|s| *s > 0.0 && !own.is_empty())
            .map(|s| (mean / s).ln())
    };
    let all: Vec<f64> = parameters.iter().filter_map(of).collect();
    (!all.is_empty()).then(|| (all.iter().sum::<f64>() / all.len() as f64).exp())
}

/// The statistic over rows of parameters with a value on every joint. A value on a bound has no deviation of its own: it is
/// given the largest that the parameter has on another joint; a parameter that lies on bounds everywhere says nothing.
fn wald(rows: &[Vec<Parameter>], estimate: &Estimate) -> Option<Wald> {
    let mut entries: Vec<(&Parameter, f64)> = Vec::new();
    let mut pairs: Vec<[usize; 2]> = Vec::new();
    for row in rows {
        let valued = row.iter().filter(|p| match p.source {
            Source::Bound => p.value.is_some(),
            _ => p.std_dev.is_some(),
        });
        let valued: Vec<&Parameter> = valued.collect();
        let widest = valued.iter().filter_map(|p| p.std_dev).fold(0.0, f64::max);
        if widest == 0.0 {
            continue;
        }
        let first = entries.len();
        entries.extend(valued.iter().map(|p| (*p, p.std_dev.unwrap_or(widest))));
        pairs.extend((first + 1..entries.len()).map(|other| [first, other]));
    }
    let count = pairs.len();
    let place = |p: &Parameter| {
        let names = &estimate.covariance.parameters;
        names.iter().position(|name| *name == p.name)
    };
    let places: Vec<Option<usize>> = entries.iter().map(|(p, _)| place(p)).collect();
    let between = |a: usize, b: usize| match (places[a], places[b]) {
        (Some(i), Some(j)) => estimate.covariance.matrix[i][j],
        _ if a == b => entries[a].1.powi(2),
        _ => 0.0,
    };
    let covariance = DMatrix::from_fn(count, count, |i, j| {
        let ([a, b], [c, d]) = (pairs[i], pairs[j]);
        between(a, c) - between(a, d) - between(b, c) + between(b, d)
    });
    let scale = covariance.diagonal().map(|v| v.max(0.0).sqrt());
    if count == 0 || scale.iter().any(|s| *s == 0.0) {
        return None;
    }
    let value = |k: usize| entries[k].0.value.unwrap_or(0.0);
    let apart = DVector::from_fn(count, |i, _| {
        (value(pairs[i][1]) - value(pairs[i][0])) / scale[i]
    });
    let correlation = DMatrix::from_fn(count, count, |i, j| {
        covariance[(i, j)] / (scale[i] * scale[j])
    });
    let eigen = SymmetricEigen::new(correlation);
    let largest = eigen.eigenvalues.max();
    let along = eigen.eigenvectors.tr_mul(&apart);
    let kept = (0..count).filter(|&k| eigen.eigenvalues[k] > RANK * largest);
    let squares: Vec<f64> = kept
        .map(|k| along[k].powi(2) / eigen.eigenvalues[k])
        .collect();
    let (statistic, freedom) = (squares.iter().sum(), squares.len());
    let distribution = Distribution::ChiSquared {
        freedom: freedom as f64,
    };
    Some(Wald {
        statistic,
        freedom,
        p_value: distribution.upper_tail(statistic),
    })
}
