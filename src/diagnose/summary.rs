//! The final model's predictions with smooth corrections, and the paragraph that says what was found.

use crate::diagnose::bench::Bench;
use crate::diagnose::refit::Refit;
use crate::diagnose::smooth::Smooth;
use crate::estimate::figures::{Predictions, figures_by_recording, predictions_by_recording};
use crate::estimate::fit::Fitted;
use crate::outcome::diagnose::{Finding, Verdict};
use crate::recording::split::Split;

/// Held-out residuals of a model with smooth corrections.
pub fn left(refit: &Refit, smooths: &[&Smooth]) -> Vec<Vec<f64>> {
    let mut left = refit.validation.clone();
    for smooth in smooths {
        let pairs = left[smooth.channel].iter_mut().zip(&smooth.validation);
        pairs.for_each(|(e, f)| *e -= f);
    }
    left
}

/// Takes smooth corrections from the predictions of the final model and makes its figures again.
pub fn correct(
    bench: &Bench<'_>,
    (refit, fitted): (&Refit, &mut Fitted),
    smooths: &[&Smooth],
) -> Predictions {
    let values = |k: usize| refit.values_in(bench.data, k);
    let mut predictions = match refit.own.is_empty() {
        true => fitted.predictions.clone(),
        false => predictions_by_recording(&refit.model, &values, bench.data),
    };
    for smooth in smooths {
        let (mut train, mut held_out) = (smooth.train.iter(), smooth.validation.iter());
        for (recording, of_channels) in bench.data.recordings.iter().zip(&mut predictions) {
            let series = match recording.split {
                Split::Train => &mut train,
                Split::Validation => &mut held_out,
            };
            let counting = recording.counting();
            for (row, correction) in counting.zip(series) {
                of_channels[smooth.channel][row] -= correction;
            }
        }
    }
    if !smooths.is_empty() || !refit.own.is_empty() {
        let of = (bench.data, &predictions);
        fitted.estimate.joints = figures_by_recording(&refit.model, (&refit.values, &values), of);
    }
    predictions
}

/// What was found, in plain words.
pub fn paragraph(
    verdict: Verdict,
    findings: &[Finding],
    (examined, cut_short): (usize, bool),
) -> String {
    let tried = format!("{examined} hypotheses were tried");
    match verdict {
        Verdict::NothingMissing if cut_short => {
            "The search was interrupted before it found anything; that does not mean that nothing is missing."
                .to_string()
        }
        Verdict::NothingMissing => format!(
            "Nothing is missing that matters: {tried}, and none lowers the error on recordings that were not \
             fitted by as much as 1 %."
        ),
        _ => {
            let mut text: Vec<String> = findings.iter().map(|f| f.sentence.clone()).collect();
            for finding in findings {
                let alike: Vec<&str> = finding
                    .rivals
                    .iter()
                    .filter(|r| !r.separable)
                    .map(|r| r.effect.as_str())
                    .collect();
                if !alike.is_empty() {
                    text.push(format!(
                        "These recordings cannot tell {} from {}.",
                        finding.effect,
                        alike.join(" or ")
                    ));
                }
            }
            text.push(match verdict {
                Verdict::Explained => "With that the model explains the recordings.".to_string(),
                Verdict::PartlyExplained => {
                    "That explains part of the misfit; some is left.".to_string()
                }
                _ => "Most of the misfit is left without a name.".to_string(),
            });
            if cut_short {
                text.push("The search was interrupted: not every effect has been tried.".to_string());
            }
            text.join(" ")
        }
    }
}
