//! What `trials` adds: every trial, what was found against what was concealed, and the rates that follow.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use crate::outcome::number;

/// The part of `trials`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Trials {
    /// In the order of their numbers.
    pub trials: Vec<Trial>,
    /// Times that an effect was found first, by what was concealed; of trials whose effect is at least
    /// [`Rates::least_size`] times the noise, and of the controls.
    pub confusion: BTreeMap<String, BTreeMap<String, usize>>,
    /// How often each effect is found, by its size.
    pub power: Vec<Power>,
    /// Findings of the controls.
    pub false_findings: FalseFindings,
    /// The rates over all trials.
    pub rates: Rates,
    /// The same of the trials of each kind of motion.
    #[serde(default)]
    pub by_motion: Vec<Group>,
    /// The same of the trials of each kind of noise.
    #[serde(default)]
    pub by_noise: Vec<Group>,
    /// Stated probabilities against what was there, of all trials and of those of each kind of motion.
    #[serde(default)]
    pub calibration: Vec<Calibration>,
    /// Anything a reader should know, one sentence each.
    #[serde(default)]
    pub notes: Vec<String>,
}

/// The trials of one kind of motion or noise.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Group {
    /// Word of the motion or noise.
    pub kind: String,
    /// How many there are.
    pub trials: usize,
    /// Trials that ended in a failure.
    pub without_answer: usize,
    /// As [`Trials::confusion`].
    pub confusion: BTreeMap<String, BTreeMap<String, usize>>,
    /// How often each effect is found, by its size.
    pub power: Vec<Power>,
    /// Findings of its controls.
    pub false_findings: FalseFindings,
    /// Rates over the trials of this kind.
    pub rates: Rates,
}

/// Claims whose stated probability lies in one tenth.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// Kind of motion; nothing for all trials together.
    pub motion: Option<String>,
    /// Lower end of the tenth; the last one includes 1.
    pub from: f64,
    /// How many there are.
    pub claims: usize,
    /// Mean of what was stated.
    #[serde(with = "number::nullable")]
    pub stated: f64,
    /// Claims that were right.
    pub right: usize,
    /// 95 % interval of the share that is right (Wilson 1927), of claims that are independent.
    pub ci95: [f64; 2],
}

/// A claim of a diagnosis with its probability.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Stated {
    /// Identifier of the effect, or `unnamed`.
    pub effect: String,
    /// Joints at which it is said to act.
    pub joints: Vec<String>,
    /// As stated, 0 to 1.
    #[serde(with = "number::nullable")]
    pub probability: f64,
    /// Whether it was there: the effect on these joints, or physics outside the vocabulary where `unnamed` is said.
    pub right: bool,
}

/// One trial.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// Number of the trial, from which its robot, physics and noise follow with the seed of the run.
    pub seed: u64,
    /// Kind of the random robot.
    pub robot: String,
    /// Kind of the motion.
    #[serde(default)]
    pub motion: String,
    /// Kind of the noise.
    #[serde(default)]
    pub noise: String,
    /// Correlation of the noise of neighbouring samples.
    #[serde(default)]
    pub noise_correlation: f64,
    /// What the declared model lacks; nothing in a control.
    pub concealed: Vec<Hidden>,
    /// What the diagnosis found, strongest first.
    pub found: Vec<Found>,
    /// Findings and rivals with the probabilities that the diagnosis states.
    #[serde(default)]
    pub stated: Vec<Stated>,
    /// The first finding is a concealed effect, or lists one among the rivals that it cannot set aside.
    pub right_effect: bool,
    /// The joints of that finding are those of the effect, of an ordered pair in its direction.
    pub right_joints: bool,
    /// Every concealed effect is found so.
    pub all_found: bool,
    /// The verdict as people read it.
    pub verdict: String,
    /// Wall time of the diagnosis, s.
    #[serde(with = "number::nullable")]
    pub seconds: f64,
    /// Held-out RMS error after over before, of the joint with the largest misfit.
    #[serde(with = "number::optional")]
    pub error_ratio: Option<f64>,
    /// RMS relative error of the friction parameters of the declared model, with what was found, and with the truth.
    #[serde(default)]
    pub friction_error: Option<[f64; 3]>,
    /// RMS error of the torque that links and rotors ask for along the held-out motion, over the noise of a sample, of
    /// the same three models; nothing where the links are known.
    #[serde(default)]
    pub body_error: Option<[f64; 3]>,
    /// Of trials that conceal laws outside the vocabulary: what took the place of what has no name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nameless: Option<Nameless>,
    /// Why the trial has no answer, where it has none.
    #[serde(default)]
    pub failure: Option<String>,
}

/// What took the place of what has no name.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Nameless {
    /// Torque of the law that was concealed; nothing in a control.
    pub law: Option<String>,
    /// Variables of the motion that the law has, as formulas of laws name them.
    pub variables: Vec<String>,
    /// The formula that was proposed on the joint of the law, in a control on any joint.
    pub formula: Option<String>,
    /// Variables of that formula.
    pub formula_variables: Vec<String>,
    /// Share of the squares beyond the noise that a smooth correction takes from the held-out residual of the law's joint.
    #[serde(with = "number::nullable")]
    pub smooth_share: f64,
    /// The joint of which the largest share of the signal is said to be left without an explanation, where nothing is found.
    #[serde(default)]
    pub unexplained: Option<String>,
    /// The forecast of a motion of 1.3 times the amplitude; nothing in a control.
    pub forecast: Option<Forecast>,
}

/// What is left of the signal of a law's joint in a recording without noise of the same motion with 1.3 times the amplitude, RMS
/// over the noise of a row.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Forecast {
    /// By the final model.
    #[serde(with = "number::nullable")]
    pub nothing: f64,
    /// By the final model with its smooth correction, where there is one.
    #[serde(with = "number::nullable")]
    pub smooth: f64,
    /// By the model with the formula.
    #[serde(default, with = "number::optional")]
    pub formula: Option<f64>,
}

/// Rates over trials that conceal laws outside the vocabulary; sizes are multiples of the noise. How many have their joint found is
/// in [`Self::located`], how many are given a name in [`Rates::outside_named`].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct OutsideRates {
    /// Laws of [`Rates::least_size`] and more: the first finding is on their joint.
    pub located: Share,
    /// The same, or nothing is found, and what is left of their joint is said to be unexplained, more than of any other.
    #[serde(default)]
    pub located_or_unexplained: Share,
    /// Of these laws those of at most two variables: a smooth correction takes at least half of what is beyond the noise.
    pub smooth_takes_half: Share,
    /// The size from which on formulas count.
    #[serde(with = "number::nullable")]
    pub formula_size: f64,
    /// Laws of that size that a smooth correction does not forecast: a formula is proposed.
    pub proposed: Share,
    /// Of the same: a formula is proposed, and errs in the larger motion at most half as much as the smooth correction.
    pub forecasts: Share,
    /// Formulas of laws of that size: their variables are those of the law.
    pub variables_right: Share,
    /// Controls, and laws that the smooth correction forecasts to less than the noise in the larger motion: a formula is proposed that
    /// errs no less there.
    pub needless: Share,
    /// Median of the error of formulas in the larger motion over that of the smooth correction, of laws of that size.
    #[serde(with = "number::optional")]
    pub median_forecast_ratio: Option<f64>,
}

/// A concealed effect.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Hidden {
    /// Identifier of the effect, or a name that begins with [`OUTSIDE`].
    pub effect: String,
    /// Joints at which it acts.
    pub joints: Vec<String>,
    /// Held-out RMS of what the fitted declared model leaves of it over the noise of a row, at the joint where it is
    /// largest.
    #[serde(with = "number::nullable")]
    pub effect_over_noise: f64,
}

/// A finding of a trial.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Found {
    /// Identifier of the effect.
    pub effect: String,
    /// Joints at which it was found.
    pub joints: Vec<String>,
    /// As the diagnosis states it, 0 to 1.
    #[serde(with = "number::nullable")]
    pub explained_share: f64,
    /// Rivals that the recording cannot separate from it.
    #[serde(default)]
    pub inseparable: Vec<Inseparable>,
}

/// A rival that a recording cannot separate from a finding, and whether a longer one can.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Inseparable {
    /// Identifier of the effect.
    pub effect: String,
    /// Joints at which it would act.
    pub joints: Vec<String>,
    /// As the diagnosis says; see [`crate::outcome::finding::Rival`].
    #[serde(default, with = "number::optional")]
    pub times_longer: Option<f64>,
    /// Whether a recording of the same robot tells it apart that is [`LONGER`] times as long.
    #[serde(default)]
    pub told_apart: Option<bool>,
}

/// Names of laws that are not in the vocabulary begin so.
pub const OUTSIDE: &str = "outside: ";

/// Whether what is concealed has no name in the vocabulary.
pub fn is_outside(effect: &str) -> bool {
    effect.starts_with(OUTSIDE)
}

/// Claims that two effects cannot be separated are put to recordings that are so many times as long.
pub const LONGER: usize = 4;

/// Detections of one effect in a range of sizes.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Power {
    /// Identifier of the effect.
    pub effect: String,
    /// Lower end of the range; the upper one is that of the next row.
    #[serde(with = "number::nullable")]
    pub effect_over_noise: f64,
    /// Trials in which it was found.
    pub right: usize,
    /// Trials in which it was concealed in that range.
    pub trials: usize,
}

/// Findings where nothing is concealed.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct FalseFindings {
    /// Trials in which nothing is concealed.
    pub controls: usize,
    /// Those of them in which something was found.
    pub with_finding: usize,
    /// Upper 95 % bound of the rate (Clopper and Pearson 1934).
    #[serde(with = "number::nullable")]
    pub upper95: f64,
}

/// A number of cases and how many of them are so.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Share {
    /// Cases.
    pub of: usize,
    /// Those that are so.
    pub are: usize,
}

impl Share {
    /// One case more.
    pub fn count(&mut self, is_so: bool) {
        self.of += 1;
        self.are += usize::from(is_so);
    }

    /// Not a number of no cases.
    pub fn value(self) -> f64 {
        self.are as f64 / self.of as f64
    }
}

/// The rates over trials whose effect is at least `least_size` times the noise.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Rates {
    /// The size from which on trials count, as a multiple of the noise.
    #[serde(with = "number::nullable")]
    pub least_size: f64,
    /// One effect: the first finding is right.
    pub first_right: Share,
    /// One effect: the first finding bears its very name, not that of a rival that is said to be inseparable.
    pub first_named: Share,
    /// One effect: its joints are named.
    pub joints_right: Share,
    /// Two effects, both of that size: both are found.
    pub both_found: Share,
    /// Effects of that size among several of one robot: found, with their joints.
    #[serde(default)]
    pub each_found: Share,
    /// Findings of trials with vocabulary effects that are neither concealed nor said to be inseparable from it.
    pub wrong_names: Share,
    /// Rivals that are said to be inseparable from a finding, and a recording of [`LONGER`] times the length tells them
    /// apart.
    #[serde(default)]
    pub told_apart: Share,
    /// The same of those that no recording of that length should tell apart.
    #[serde(default)]
    pub wrongly_inseparable: Share,
    /// Physics outside the vocabulary that was given a name.
    pub outside_named: Share,
    /// Median of the held-out error after over before, one effect.
    #[serde(with = "number::optional")]
    pub median_error_ratio: Option<f64>,
    /// Median error of the friction parameters with what was found over that of a fit that knew the truth.
    #[serde(with = "number::optional")]
    pub median_friction_ratio: Option<f64>,
    /// Share of trials in which that ratio is at most 1.5.
    pub friction_back: Share,
    /// The same of the torque that links and rotors ask for.
    #[serde(default, with = "number::optional")]
    pub median_body_ratio: Option<f64>,
    /// Share of trials in which that ratio is at most 1.5.
    #[serde(default)]
    pub bodies_back: Share,
    /// Rates over laws outside the vocabulary, where these are what is concealed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outside: Option<OutsideRates>,
    /// Processor seconds a trial, of the last run.
    #[serde(with = "number::optional")]
    pub core_seconds: Option<f64>,
}
