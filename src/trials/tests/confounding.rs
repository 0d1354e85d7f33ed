//! Names that are withdrawn beside something else: parts of laws that the vocabulary lacks, and pushes that follow the motion.

use crate::diagnose::conclusion::confounding;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::selection::rival_models::RivalComparison;
use crate::recording::experiment::{Experiment, Motion};
use crate::stats::deviation::rms;
use crate::trials::tests::bench::{Bench, SIGNIFICANCE, effect_of, offset};

/// Whether a name that was found in the first channel is withdrawn where that has something beside what the model says.
fn is_confounded(bench: &Bench, found: Hypothesis, of: impl Fn(&Motion, usize) -> f64) -> bool {
    let data = bench.with_added(&|experiment, k| of(&experiment.motion, k));
    let context = bench.context(&data);
    let full = bench.fit(&data, &[found]);
    let comparison = RivalComparison {
        without: bench.declared(&data),
        alternatives: Vec::new(),
        tried: 0,
    };
    let first = confounding::first(&context, &full, &[comparison], SIGNIFICANCE);
    first.is_some()
}

/// An offset that is found beside a law of two joints' motions is a part of it; beside something that no joint's motion explains
/// it is one, and so it is beside a law of the joint's own motion.
#[test]
fn a_name_for_a_part_of_a_law_is_withdrawn() {
    let bench = Bench::control();
    let recorded = &bench.opened.data.recordings[0].experiment;
    let size = 0.2 * rms(&recorded.signal[0]);
    let speed = rms(&recorded.motion.velocity[0]);
    let is_confounded = |of: &dyn Fn(&Motion, usize) -> f64| is_confounded(&bench, offset(0), of);
    let of_both = |motion: &Motion, k: usize| {
        0.5 * size * (motion.velocity[0][k] / speed).tanh() * (2.0 * motion.position[1][k]).cos()
    };
    assert!(is_confounded(&of_both));
    let of_nothing = |_: &Motion, k: usize| size * (1.0 + (40.3 * k as f64).sin());
    assert!(!is_confounded(&of_nothing));
    let of_own = |motion: &Motion, k: usize| {
        size * (motion.velocity[0][k] / speed).exp() / (1.0 + motion.position[0][k].powi(2))
    };
    assert!(!is_confounded(&of_own));
}

/// A push takes of each recording what is there for some time; what a function of the motion forecasts on other recordings is none, and
/// what a function of time does may be.
#[test]
fn what_follows_the_motion_is_no_push() {
    let bench = Bench::control();
    let recorded = &bench.opened.data.recordings[0].experiment;
    let size = 0.2 * rms(&recorded.signal[0]);
    let withdrawn = |of: &dyn Fn(&Experiment, usize) -> f64| {
        let data = bench.with_added(of);
        let context = bench.context(&data);
        let comparison = RivalComparison {
            without: bench.declared(&data),
            alternatives: Vec::new(),
            tried: 0,
        };
        // A push that is there whenever something is leaves noise.
        let full = ModelFit {
            hypotheses: vec![effect_of("external_contact", 0)],
            validation: bench.declared(&bench.opened.data).validation,
            ..comparison.without.clone()
        };
        confounding::first(&context, &full, &[comparison], SIGNIFICANCE).is_some()
    };
    let far = |motion: &Motion, k: usize| (motion.position[1][k] - 0.2).max(0.0);
    assert!(withdrawn(&|experiment, k| size * far(&experiment.motion, k)));
    // At the same time of every recording, as a function of time says too.
    let for_some_time = |experiment: &Experiment, k: usize| {
        let share = k as f64 / experiment.rows() as f64;
        if (0.3..0.4).contains(&share) {
            size
        } else {
            0.0
        }
    };
    assert!(!withdrawn(&for_some_time));
}

/// A name whose shape no smooth correction has stays, whatever is left beside it.
#[test]
fn a_name_beside_another_law_is_kept() {
    let bench = Bench::control();
    let recorded = &bench.opened.data.recordings[0].experiment;
    let size = 0.2 * rms(&recorded.signal[0]);
    let speed = rms(&recorded.motion.velocity[0]);
    let of = |motion: &Motion, k: usize| {
        let v = motion.velocity[0][k];
        let stribeck = v.signum() * (-(v / (0.1 * speed)).powi(2)).exp();
        size * (motion.velocity[1][k] + stribeck)
    };
    assert!(!is_confounded(
        &bench,
        effect_of("stribeck_friction", 0),
        of
    ));
}
