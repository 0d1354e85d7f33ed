//! The final model's predictions with smooth corrections, and the paragraph that says what was found.

use crate::chain::words::short;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::residuals::additive_model::AdditiveModel;
use crate::diagnose::residuals::noise_level::UNEXPLAINED;
use crate::estimate::fit::Fitted;
use crate::estimate::goodness_of_fit::{
    Predictions, ValuesByRecording, figures_by_recording, predictions_by_recording,
};
use crate::outcome::diagnose::{Unattested, Verdict};
use crate::outcome::finding::Finding;
use crate::outcome::joint::JointFigures;
use crate::recording::split::Split;

/// Takes smooth corrections from the predictions of the final model and makes its figures again.
pub fn correct(
    context: &Context<'_>,
    fit: &ModelFit,
    fitted: &mut Fitted,
    corrections: &[&AdditiveModel],
) -> Predictions {
    let values = |k: usize| fit.values_in(context.data, k);
    let mut predictions = match fit.own.is_empty() {
        true => fitted.predictions.clone(),
        false => predictions_by_recording(&fit.model, &values, context.data),
    };
    for correction in corrections {
        for split in [Split::Train, Split::Validation] {
            let all = context.data.recordings.iter().zip(&mut predictions);
            correction.take_off(split, all.filter(|(recording, _)| recording.split == split));
        }
    }
    if !corrections.is_empty() || !fit.own.is_empty() {
        let own = ValuesByRecording {
            training: &fit.values,
            own: &values,
        };
        fitted.estimate.joints = figures_by_recording(&fit.model, own, context.data, &predictions);
    }
    predictions
}

/// What a paragraph says beside the findings.
pub struct About<'a> {
    /// Number of hypotheses.
    pub examined: usize,
    /// What is left, is of weight, and is not known to be noise.
    pub unattested: &'a [Unattested],
    /// Figures of the final model.
    pub joints: &'a [JointFigures],
    /// Effects that an interrupted search has not tried.
    pub untried: Vec<String>,
}

/// What was found, in plain words; `None` is the verdict of a search that was interrupted.
pub fn paragraph(verdict: Option<Verdict>, findings: &[Finding], about: &About<'_>) -> String {
    let mut text: Vec<String> = findings.iter().map(told).collect();
    text.push(match verdict {
        None => return interrupted(text, about),
        Some(Verdict::NothingMissing) => format!(
            "Nothing is missing that matters: {} hypotheses were tried, and none is told from chance and lowers the error \
             on recordings that were not fitted by as much as 1 %.{}",
            about.examined,
            beyond_noise(about.joints)
        ),
        Some(Verdict::Explained) => "With that the model explains the recordings.".to_string(),
        Some(Verdict::PartlyExplained) => {
            "That explains part of the misfit; some is left.".to_string()
        }
        Some(Verdict::Unexplained) if findings.is_empty() => format!(
            "What is left is not explained: {} hypotheses were tried, and none of them is it.",
            about.examined
        ),
        Some(Verdict::Unexplained) => "Most of the misfit is left without a name.".to_string(),
    });
    let left = about.unattested.iter().map(|left| &left.sentence);
    text.extend(left.map(|sentence| format!("{sentence}.")));
    text.join(" ")
}

/// Joints whose errors are beyond the noise though they are no misfit of weight; nothing where there are none.
fn beyond_noise(joints: &[JointFigures]) -> String {
    let beyond = joints.iter().filter_map(|figures| {
        let lack = figures.lack_of_fit.filter(|&lack| lack > UNEXPLAINED)?;
        let times = lack.sqrt();
        Some(match figures.relative_validation {
            Some(share) => format!(
                "{} ({times:.1} times, {} % of the signal)",
                figures.joint,
                short(100.0 * share)
            ),
            None => format!("{} ({times:.1} times)", figures.joint),
        })
    });
    let beyond: Vec<String> = beyond.collect();
    match beyond.is_empty() {
        true => String::new(),
        false => format!(
            " Errors beyond the noise are left at {}: too little, or too near reversals, to be told from errors of the motion.",
            beyond.join(", ")
        ),
    }
}

fn interrupted(mut text: Vec<String>, about: &About<'_>) -> String {
    text.push(
        match text.is_empty() {
            true => {
                "The search was interrupted before it found anything; that does not mean that nothing is missing."
            }
            false => "The search was interrupted: not every effect has been tried.",
        }
        .to_string(),
    );
    if !about.untried.is_empty() {
        text.push(format!("Not tried yet: {}.", about.untried.join(", ")));
    }
    text.join(" ")
}

fn told(finding: &Finding) -> String {
    let open = finding.rivals.iter().filter(|r| !r.separable);
    let alike: Vec<&str> = open.map(|r| r.effect.as_str()).collect();
    match alike.is_empty() {
        true => finding.sentence.clone(),
        false => format!(
            "{} These recordings cannot tell {} from {}.",
            finding.sentence,
            finding.effect,
            alike.join(" or ")
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::tests::joint_figures;

    fn left(joint: &str, lack_of_fit: Option<f64>) -> JointFigures {
        JointFigures {
            lack_of_fit,
            relative_validation: Some(0.026),
            ..joint_figures(joint, 0.022)
        }
    }

    #[test]
    fn what_is_beyond_the_noise_is_said_though_nothing_is_missing() {
        let said = |joints: &[JointFigures]| {
            let about = About {
                examined: 7,
                unattested: &[],
                joints,
                untried: Vec::new(),
            };
            paragraph(Some(Verdict::NothingMissing), &[], &about)
        };
        let quiet = said(&[left("j1", Some(1.2)), left("j2", None)]);
        assert!(quiet.ends_with("1 %."), "{quiet}");
        let loud = said(&[left("j1", Some(1.2)), left("j2", Some(64.0))]);
        assert!(
            loud.contains("at j2 (8.0 times, 2.60 % of the signal)"),
            "{loud}"
        );
        assert!(!loud.contains("j1"), "{loud}");
    }
}
