//! Whether estimated nonlinear parameters lie inside the range of their search.
//!
//! A law whose shape ends at a limit of its search was not found there: the data ask for something beyond, where the law is
//! another one, and whatever it explains is the beginning of something that it is not. Such a hypothesis is not named. Sizes that
//! end at zero, and angles, which come round again, are no shapes.

use crate::chain::effect::{Effect, Memory, ParameterInfo, Search, Unit};
use crate::chain::parameter::Parameter;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::ModelFit;

/// A parameter that is nearer to a limit than this share of it is at the limit: searches stop at a thousandth of what an
/// interval tells.
pub const AT_LIMIT: f64 = 1e-3;

/// Whether every searched parameter of a hypothesis, as fitted, lies inside its limits.
pub fn are_inside(fit: &ModelFit, hypothesis: &Hypothesis) -> bool {
    hypothesis.joints.iter().all(|&joint| {
        let mut own = fit.model.joints()[joint].parameters_of(hypothesis.effect.id);
        own.all(|(info, at)| {
            is_of_speed_and_more(hypothesis.effect, info)
                || is_found(info, fit.values[at], &fit.model.parameters()[at])
        })
    })
}

/// What remembers changes with more than speed, and may do so where the speed over which it changes is any.
fn is_of_speed_and_more(effect: &Effect, info: &ParameterInfo) -> bool {
    effect.needs.memory != Memory::None && matches!(info.search, Search::Speed(_))
}

/// Whether a search may have ended at a value: sizes may be at limits, and shapes at zero.
fn is_found(info: &ParameterInfo, value: f64, parameter: &Parameter) -> bool {
    !is_shape(info) || value == 0.0 || !is_at_limit_of(parameter, value)
}

fn is_shape(info: &ParameterInfo) -> bool {
    info.search != Search::Typical && info.unit != Unit::Angle
}

/// Whether a parameter ended at a limit of what it may be.
pub fn is_at_a_limit(fit: &ModelFit, at: usize) -> bool {
    is_at_limit_of(&fit.model.parameters()[at], fit.values[at])
}

fn is_at_limit_of(parameter: &Parameter, value: f64) -> bool {
    let near = |limit: f64| limit.is_finite() && (value - limit).abs() <= AT_LIMIT * limit.abs();
    near(parameter.lower) || near(parameter.upper)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::effect::find;
    use crate::chain::parameter::{Role, State};

    /// A value of a parameter of an effect, between limits.
    fn is_found_at(value: f64, (effect, name): (&str, &str), limits: [f64; 2]) -> bool {
        let effect = find(effect).unwrap();
        let info = effect.parameters.iter().find(|p| p.name == name).unwrap();
        let [lower, upper] = limits;
        let parameter = Parameter {
            name: name.to_string(),
            unit: String::new(),
            role: Role::Effect {
                joint: 0,
                effect: 0,
                parameter: 0,
            },
            state: State::Free,
            value: info.typical,
            lower,
            upper,
            bounded: false,
            scale: 1.0,
            linearity: info.linearity,
        };
        is_found(info, value, &parameter)
    }

    /// Of a shape whose limit is zero the physics ends there, and of another the search does.
    #[test]
    fn a_shape_at_a_limit_of_its_search_is_not_found_unless_it_is_zero() {
        let speed = ("stribeck_friction", "vs");
        assert!(is_found_at(0.1, speed, [0.01, 2.0]));
        for at_a_limit in [0.01, 0.010_005, 1.999, 2.0] {
            assert!(!is_found_at(at_a_limit, speed, [0.01, 2.0]), "{at_a_limit}");
        }
        assert!(is_found_at(0.0, speed, [0.0, 2.0]));
        assert!(is_found_at(1.99, speed, [0.0, 2.0]));
        // A size is none.
        assert!(is_found_at(5.0, ("stribeck_friction", "Fs"), [0.0, 5.0]));
    }
}
