//! Hypotheses whose size is not significantly different from zero.
//!
//! A hypothesis that forecasts the residual may owe that to parameters beside its size, or to a size that is tied to others:
//! with θ ± 1.96 σ over the value at which its torque is none, the number that a finding would state may as well be zero.

use crate::chain::effect::knowledge::Sizes;
use crate::chain::effect::{Effect, Law, Linearity, ParameterInfo};
use crate::chain::model::Model;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::recording::split::Split;
use crate::stats::distribution::Distribution;

/// Probability that the interval of a size holds it.
const COVERAGE: f64 = 0.95;

/// A parameter that says how much of an effect there is, and its value where there is none.
pub struct Size<'a> {
    /// Name within the effect.
    pub parameter: &'a str,
    /// In the parameter's unit.
    pub nothing: f64,
}

/// Sizes of what a hypothesis adds, of which one has to be told from none.
fn sizes<'a>(model: &'a Model, hypothesis: &Hypothesis) -> Vec<Size<'a>> {
    match hypothesis.other {
        Some(other) => vec![Size {
            parameter: model.joints()[other].name.as_str(),
            nothing: 0.0,
        }],
        None => sizes_alone(hypothesis.effect),
    }
}

/// Sizes of an effect that takes no other joint.
pub fn sizes_alone(effect: &Effect) -> Vec<Size<'static>> {
    let of = |names: &[&'static str], nothing: f64| -> Vec<Size<'static>> {
        let size = |&parameter: &&'static str| Size { parameter, nothing };
        names.iter().map(size).collect()
    };
    let first = |effect: &Effect| {
        let parameter = effect.parameters.first();
        parameter.map_or_else(Vec::new, |p| of(&[p.name], 0.0))
    };
    match effect.knowledge.sizes {
        Sizes::Of { names, nothing } => of(names, nothing),
        Sizes::First => first(effect),
        Sizes::Linear => {
            let is_linear = |p: &&ParameterInfo| p.linearity == Linearity::Linear;
            let linear = effect.parameters.iter().filter(is_linear);
            let linear: Vec<&'static str> = linear.map(|p| p.name).collect();
            match linear.is_empty() {
                true => first(effect),
                false => of(&linear, 0.0),
            }
        }
    }
}

/// The hypothesis of a model with the least certain size, of those whose every size may be none.
pub fn least_certain(context: &Context<'_>, full: &ModelFit) -> Option<usize> {
    if full.hypotheses.is_empty() || context.control.is_interrupted() {
        return None;
    }
    let recordings = context.recordings(Split::Train);
    let positions = full.unknowns.positions();
    let deviations = full.parameter_deviations(&recordings);
    let quantile = Distribution::Normal.two_sided(COVERAGE);
    let base = &full.unknowns.base.base;
    // Distance from none in half widths of the interval, of a parameter that is an unknown by itself.
    let distance = |k: usize, nothing: f64| {
        let half = quantile * deviations[positions[k]]?;
        let alone = base.get(k).is_none_or(|b| b.others.is_empty());
        (alone && half.is_finite()).then(|| (full.solution.x[k] - nothing).abs() / half)
    };
    let of = |h: &Hypothesis| {
        let own = own_parameters(full, h);
        let distances = sizes(&full.model, h).into_iter().flat_map(|size| {
            let suffix = format!(".{}", size.parameter);
            let named = own
                .iter()
                .filter(move |&&p| full.model.parameters()[p].name.ends_with(&suffix));
            let unknown = named.filter_map(|p| positions.iter().position(|q| q == p));
            unknown
                .filter_map(|k| distance(k, size.nothing))
                .collect::<Vec<f64>>()
        });
        distances.reduce(f64::max)
    };
    let uncertain = full.hypotheses.iter().enumerate().filter_map(|(k, h)| {
        let distance = of(h).filter(|distance| *distance < 1.0)?;
        Some((k, distance))
    });
    uncertain.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| k)
}

/// Parameters that a hypothesis has brought.
fn own_parameters(full: &ModelFit, hypothesis: &Hypothesis) -> Vec<usize> {
    let id = hypothesis.effect.id;
    let joints = hypothesis.named_joints();
    let names = joints.iter().map(|&j| full.model.joints()[j].name.as_str());
    let mut prefixes: Vec<String> = names.map(|joint| format!("{joint}.{id}.")).collect();
    prefixes.push(format!("{id}."));
    if matches!(hypothesis.effect.law, Law::Body) {
        prefixes.push("payload.".to_string());
    }
    let parameters = full.model.parameters().iter().enumerate();
    let own = parameters.filter(|(_, p)| prefixes.iter().any(|prefix| p.name.starts_with(prefix)));
    own.map(|(k, _)| k).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::effect::find;
    use crate::chain::effect::knowledge::Knowledge;

    #[test]
    fn sizes_are_what_makes_an_effect_nothing() {
        let of = |id: &str| -> Vec<(&str, f64)> {
            let sizes = sizes_alone(find(id).unwrap()).into_iter();
            sizes.map(|size| (size.parameter, size.nothing)).collect()
        };
        assert_eq!(of("stribeck_friction"), [("Fs", 0.0)]);
        assert_eq!(of("external_contact"), [("torque", 0.0)]);
        let ripple = [("amplitude", 0.0), ("amplitude2", 0.0)];
        assert_eq!(of("torque_ripple"), ripple);
        assert_eq!(of("transmission_efficiency"), [("R", 1.0)]);
    }

    /// An effect that says no more has the sizes that enter its torque linearly, or else its first parameter.
    #[test]
    fn sizes_that_are_not_stated_are_linear() {
        let of = |id: &str| -> Vec<&str> {
            let effect = Effect {
                knowledge: Knowledge::NONE,
                ..*find(id).unwrap()
            };
            let sizes = sizes_alone(&effect).into_iter();
            sizes.map(|size| size.parameter).collect()
        };
        assert_eq!(of("torque_ripple"), ["amplitude", "amplitude2"]);
        assert_eq!(of("external_contact"), ["torque"]);
    }
}
