//! What `diagnose` adds: where model and recordings differ, what physics is missing, what is left.

use serde::{Deserialize, Serialize};

use crate::outcome::finding::Finding;
use crate::outcome::fit::{Fit, FittedModel, Preprocessing};
use crate::outcome::joint::JointFigures;
use crate::outcome::number;
use crate::outcome::parameter::Parameter;
use crate::outcome::rollout::Rollout;
use crate::outcome::simulator::Simulator;

/// The part of `diagnose`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Diagnosis {
    /// `None` of a search that was interrupted: what it has not tried may be what is missing.
    pub verdict: Option<Verdict>,
    /// A paragraph in plain words.
    pub summary: String,
    /// The declared model, its parameters fitted.
    pub baseline: Baseline,
    /// Where the misfit of the declared model lies, the largest share first.
    pub located: Vec<Located>,
    /// Strongest first.
    pub findings: Vec<Finding>,
    /// What is of weight, and nothing in the recordings says that it is noise.
    #[serde(default)]
    pub unattested: Vec<Unattested>,
    /// The model with all findings, fitted.
    #[serde(rename = "final")]
    pub outcome: Final,
    /// The recording that would tell rivals apart.
    pub next_experiment: Option<NextExperiment>,
    /// Hypotheses that were fitted with all other parameters, step by step.
    #[serde(default)]
    pub evidence: Vec<Evidence>,
    /// Parameters of the declared model that the missing physics had biased.
    #[serde(default)]
    pub spoiled: Vec<BiasedParameter>,
    /// What was done to the recordings before the fits.
    #[serde(default)]
    pub preprocessing: Vec<Preprocessing>,
    /// Anything a reader should know, one sentence each.
    #[serde(default)]
    pub notes: Vec<String>,
    /// The final model as a fit gives it, for later fits and for export.
    #[serde(default)]
    pub fit: Option<Fit>,
    /// The user's simulator beside the robot; absent without recordings of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulator: Option<Simulator>,
    /// Declared and final model simulated forward along what was not fitted, windows sample by sample left out; absent where no
    /// motion follows from the signal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rollout: Option<Rollout>,
}

/// What the findings amount to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// What the declared model leaves is noise as far as the recordings tell.
    NothingMissing,
    /// Findings explain what the declared model leaves.
    Explained,
    /// Findings explain a part of it; what is left is more than noise.
    PartlyExplained,
    /// The declared model leaves more than noise, and nothing of the vocabulary explains it.
    Unexplained,
}

impl Verdict {
    /// A verdict as people read it.
    pub fn or_none(verdict: Option<Self>) -> &'static str {
        verdict.map_or("none, the search was interrupted", Self::words)
    }

    fn words(self) -> &'static str {
        match self {
            Self::NothingMissing => "nothing is missing",
            Self::Explained => "explained",
            Self::PartlyExplained => "partly explained",
            Self::Unexplained => "unexplained",
        }
    }
}

/// The declared model.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Baseline {
    /// How well it predicts each joint.
    pub joints: Vec<JointFigures>,
    /// The model in full.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<FittedModel>,
}

/// The model with all findings.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Final {
    /// How well it predicts each joint.
    pub joints: Vec<JointFigures>,
    /// Its parameters, those of the findings among them.
    pub parameters: Vec<Parameter>,
}

/// A range of covariates in which the misfit of a joint lies.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Located {
    /// Name of the joint.
    pub joint: String,
    /// What the residual depends on.
    pub variable: String,
    /// Unit of the variable.
    pub unit: String,
    /// Range of the variable in which the misfit is largest.
    #[serde(with = "number::nullable")]
    pub low: f64,
    /// Upper end of that range.
    #[serde(with = "number::nullable")]
    pub high: f64,
    /// Share of the residual's energy beyond the noise that the variable explains on held-out rows.
    #[serde(with = "number::nullable")]
    pub share: f64,
    /// The same in words.
    pub sentence: String,
    /// Mean residual over the variable, for the picture.
    #[serde(default)]
    pub curve: Vec<CurvePoint>,
}

/// Mean residual in a bin of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CurvePoint {
    /// Middle of the bin, in the unit of the variable.
    #[serde(with = "number::nullable")]
    pub at: f64,
    /// Recorded minus predicted.
    #[serde(with = "number::nullable")]
    pub mean: f64,
    /// Standard error of the mean, in the unit of the signal.
    #[serde(with = "number::nullable")]
    pub std_error: f64,
}

/// A channel of which the final model leaves more than is known to be noise.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Unattested {
    /// Name of the joint or channel.
    pub joint: String,
    /// Unit of the signal.
    pub unit: String,
    /// Root mean square of what is left on held-out rows.
    #[serde(with = "number::nullable")]
    pub rmse_validation: f64,
    /// Share of the RMS signal.
    #[serde(with = "number::nullable")]
    pub of_signal: f64,
    /// The same in words.
    pub sentence: String,
}

/// A recording that would tell rivals apart.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NextExperiment {
    /// What to record, and which rivals it tells apart.
    pub sentence: String,
    /// A problem file for `exid design`.
    pub problem: String,
}

/// A parameter that was wrong in the declared model because physics was missing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BiasedParameter {
    /// Name of the parameter.
    pub name: String,
    /// SI unit of the values.
    pub unit: String,
    /// Its value in the declared model.
    #[serde(with = "number::nullable")]
    pub before: f64,
    /// Its value in the model with all findings.
    #[serde(with = "number::nullable")]
    pub after: f64,
    /// Standard deviation of the latter.
    #[serde(with = "number::nullable")]
    pub std_dev: f64,
}

/// A hypothesis that was fitted beside what was found before.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// Findings that were in the model already.
    pub step: usize,
    /// Identifier of the effect.
    pub effect: String,
    /// Joints that it was tried at.
    pub joints: Vec<String>,
    /// Share of the held-out residual's forecast that is true: 0 where nothing is, 1 where all is.
    #[serde(with = "number::nullable")]
    pub slope: f64,
    /// Corrected for all hypotheses tried.
    #[serde(with = "number::nullable")]
    pub p_value: f64,
    /// Largest share by which the held-out error of a joint falls.
    #[serde(with = "number::nullable")]
    pub relief: f64,
    /// Change of minus twice the logarithm of the held-out likelihood: negative is better.
    #[serde(with = "number::nullable")]
    pub score: f64,
    /// It joined the model.
    pub accepted: bool,
}
