//! What a finding means, in a sentence that a plant engineer understands.

use crate::chain::effect::fitted_effect::{Estimated, FittedEffect};
use crate::chain::model::Model;
use crate::chain::words::{list, short};
use crate::diagnose::conclusion::explanation::TriedModel;
use crate::diagnose::fit::hypothesis::{Hypothesis, joint_names};
use crate::outcome::diagnose::Unattested;
use crate::outcome::formula::{OtherFormula, ProposedFormula};
use crate::outcome::parameter::Parameter;

/// What was wrong with the declared model, of a finding of a model with the parameters that it has brought.
pub fn sentence(hypothesis: &Hypothesis, model: &Model, parameters: &[Parameter]) -> String {
    let effect = hypothesis.effect;
    let found = FittedEffect {
        who: list(&joint_names(model, &hypothesis.named_joints())),
        moved: list(&joint_names(model, &hypothesis.joints)),
        by: joint_names(model, hypothesis.other.as_slice()),
        signal: model.signal(),
        parameters: parameters.iter().map(estimated).collect(),
    };
    match effect.knowledge.finding {
        Some(sentence) => sentence(&found),
        None => format!("{}: {}", found.who, effect.sentence.trim_end_matches('.')),
    }
}

fn estimated(parameter: &Parameter) -> Estimated<'_> {
    let name = parameter.name.as_str();
    Estimated {
        name: name.rsplit('.').next().unwrap_or(name),
        unit: &parameter.unit,
        value: parameter.value,
        ci95: parameter.ci95,
    }
}

/// How much a finding helps.
pub fn improvement(before: f64, after: f64, unit: &str) -> String {
    format!(
        "the error on recordings that were not fitted falls from {} to {} {unit}",
        short(before),
        short(after)
    )
}

/// A formula, how much it explains, and what shorter ones do.
pub fn formula(formula: &ProposedFormula) -> String {
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    let others = formula.others.iter();
    let shorter: Vec<&OtherFormula> = others
        .filter(|other| other.complexity < formula.complexity)
        .collect();
    let most = shorter.iter().map(|other| other.explains);
    let most = percent(most.fold(0.0, f64::max));
    let shorter = match shorter.len() {
        0 => String::new(),
        1 => format!("; a shorter formula explains {most}"),
        count => format!("; {count} shorter formulas explain {most} at most"),
    };
    let against = match &formula.against {
        Some(rival) => format!(", not {rival}"),
        None => String::new(),
    };
    let drives = match formula.drives {
        true => " It drives the joint over part of the motion, which friction does not.",
        false => "",
    };
    format!(
        "As a formula, {} at {} explains {} of it ({} probable{against}){shorter}.{drives}",
        formula.expression,
        formula.joint,
        percent(formula.explains),
        percent(formula.probability)
    )
}

/// Of a joint of which a formula alone takes what is left.
pub fn nameless(joint: &str) -> String {
    format!(
        "Something is missing on {joint} that no effect of the vocabulary and no smooth correction explains."
    )
}

/// A joint of which nothing is known.
pub fn nothing_counts(joint: &str) -> String {
    format!(
        "{joint}: no row of the recordings that were not fitted counts, so that nothing is known of what is missing there"
    )
}

/// What is left of a joint and is not known to be noise, and what left less of it and was not confirmed.
pub fn unattested(left: &Unattested, tried: Option<TriedModel<'_>>) -> String {
    let Unattested { joint, unit, .. } = left;
    let noise = match tried {
        Some(TriedModel { test, share }) => format!(
            "it is no noise, for {} at {}, which did not stand the tests, left {:.0} % of it",
            test.hypothesis.effect.id,
            list(&joint_names(&test.fit.model, &test.hypothesis.joints)),
            100.0 * share
        ),
        None => "nothing in them says that this is noise".to_string(),
    };
    format!(
        "{joint}: the error on recordings that were not fitted is {} {unit}, {:.0} % of the signal, and {noise}",
        short(left.rmse_validation),
        100.0 * left.of_signal
    )
}
