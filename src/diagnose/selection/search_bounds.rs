//! Whether the parameters of a law that are searched for lie inside what is searched.
//!
//! A law whose shape ends at a limit of its search was not found there: the data ask for something beyond, where the law is
//! another one, and whatever it explains is the beginning of something that it is not. Such a hypothesis is not named. Sizes that
//! end at zero, and angles, which come round again, are no shapes.

use crate::chain::effect::{ParameterInfo, Search, Unit};
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::ModelFit;

/// A parameter that is nearer to a limit than this share of it is at the limit: searches stop at a thousandth of what an
/// interval tells.
pub const AT_LIMIT: f64 = 1e-3;

/// Whether every searched parameter of a hypothesis, as fitted, lies inside its limits.
pub fn are_inside(fit: &ModelFit, hypothesis: &Hypothesis) -> bool {
    hypothesis.joints.iter().all(|&joint| {
        let mut own = fit.model.joints()[joint].parameters_of(hypothesis.effect.id);
        own.all(|(info, at)| !is_shape(info) || fit.values[at] == 0.0 || !is_at_a_limit(fit, at))
    })
}

fn is_shape(info: &ParameterInfo) -> bool {
    info.search != Search::Typical && info.unit != Unit::Angle
}

/// Whether a parameter ended at a limit of what it may be.
pub fn is_at_a_limit(fit: &ModelFit, at: usize) -> bool {
    let parameter = &fit.model.parameters()[at];
    let near =
        |limit: f64| limit.is_finite() && (fit.values[at] - limit).abs() <= AT_LIMIT * limit.abs();
    near(parameter.lower) || near(parameter.upper)
}
