//! What a hypothesis has to keep, once fitted: scales within what the joint does and inside the limits of their search, a better
//! fit than parameters without a meaning would have, and no larger error on rows that chose nothing.

use crate::chain::dataset::{Dataset, Prepared};
use crate::diagnose::conclusion::confirmation;
use crate::diagnose::fit::contexts::HeldOutHalves;
use crate::diagnose::fit::fit_cache::FitCache;
use crate::diagnose::fit::model_fit::{FitPair, ModelFit};
use crate::diagnose::residuals::effect_size::error_reduction;
use crate::diagnose::residuals::noise_level;
use crate::diagnose::selection::hypothesis_test::{HypothesisTest, fits_better};
use crate::diagnose::selection::law_range;
use crate::diagnose::selection::rival_models::separation;
use crate::diagnose::selection::search_bounds;
use crate::diagnose::selection::time_window::is_shorter;
use crate::recording::motion_error::MotionError;
use crate::recording::split::Split;
use crate::stats::deviation::rms;
use crate::stats::encompassing::Encompassing;
use crate::trials::tests::bench::{Bench, SIGNIFICANCE, effect_of, leaving, offset};

/// The place of a parameter of the first joint among those of a model.
fn place(fit: &ModelFit, name: &str) -> usize {
    let joint = &fit.model.joints()[0].name;
    fit.model.find(&format!("{joint}.{name}")).unwrap()
}

/// The same fit with one of its values changed.
fn at(fit: &ModelFit, name: &str, value: f64) -> ModelFit {
    let mut fit = fit.clone();
    let place = place(&fit, name);
    fit.values[place] = value;
    fit
}

/// A Stribeck curve that has not fallen at the joint's greatest speed is a line with some bend, and one at a limit of its search
/// is another law.
#[test]
fn scales_lie_within_the_motion_and_inside_their_search() {
    let bench = Bench::control();
    let context = bench.context(&bench.opened.data);
    let hypothesis = effect_of("stribeck_friction", 0);
    let fit = bench.fit(context.data, std::slice::from_ref(&hypothesis));
    let name = "stribeck_friction.vs";
    let speeds = context.recordings(Split::Train);
    let speeds = speeds
        .iter()
        .flat_map(|r| r.segment().motors.dq[0].to_vec());
    let fastest = speeds.map(f64::abs).fold(0.0, f64::max);
    let is_reached = |vs: f64| law_range::are_reached(&context, &at(&fit, name, vs), &hypothesis);
    assert!(is_reached(0.99 * fastest));
    assert!(!is_reached(1.01 * fastest));
    let limits = &fit.model.parameters()[place(&fit, name)];
    let is_inside = |vs: f64| search_bounds::are_inside(&at(&fit, name, vs), &hypothesis);
    assert!(is_inside(0.3 * fastest));
    assert!(!is_inside(limits.lower));
    assert!(!is_inside(limits.upper));
    assert!(is_inside(1.01 * limits.lower) && is_inside(0.99 * limits.upper));
}

/// Twice the logarithm of the ratio of likelihoods against its quantile, 6.635 for one parameter (Wilks 1938).
#[test]
fn a_richer_model_fits_better_by_more_than_chance() {
    let bench = Bench::control();
    let poorer = bench.declared(&bench.opened.data);
    let better = |gain: f64| {
        let mut richer = poorer.clone();
        let rows = richer.train[0].len() as f64;
        let factor = (-0.5 * gain / rows).exp();
        richer.train[0].iter_mut().for_each(|e| *e *= factor);
        fits_better(FitPair {
            poorer: &poorer,
            richer: &richer,
        })
    };
    assert!(better(6.7) && !better(6.5) && !better(-20.0));
}

#[test]
fn a_finding_that_fails_is_told_from_one_that_raises_the_error() {
    let bench = Bench::new(&["torque_offset"]);
    let halves = HeldOutHalves::of(bench.opened.data.clone(), Vec::new());
    let contexts = halves.contexts(&bench.opened.declared, &bench.control);
    let joint = bench.plan.concealed[0].hypothesis.joints[0];
    let prefixes = [
        bench.declared(contexts.selection.data),
        bench.fit(contexts.selection.data, &[offset(joint)]),
    ];
    let test = |p_value: f64| HypothesisTest {
        hypothesis: offset(joint),
        fit: prefixes[1].clone(),
        evidence: Encompassing {
            slope: 1.0,
            ratio: 5.0,
            distance: 5.0,
            freedom: 50.0,
            p_value,
        },
        p_value,
        error_reduction: 0.1,
    };
    let failing = |p_value: f64| confirmation::failing(&[test(p_value)], SIGNIFICANCE);
    assert_eq!(failing(0.9 * SIGNIFICANCE), None);
    assert_eq!(failing(1.1 * SIGNIFICANCE), Some(0));
    assert_eq!(confirmation::misplaced(&contexts, &prefixes), None);
    let mut wrong = prefixes.clone();
    let joint = &wrong[1].model.joints()[joint].name;
    let place = wrong[1]
        .model
        .find(&format!("{joint}.torque_offset.offset"));
    // Three times the offset that there is leaves twice of it.
    wrong[1].values[place.unwrap()] *= 3.0;
    assert_eq!(confirmation::misplaced(&contexts, &wrong), Some(0));
}

/// Stamps of samples are no better than a twentieth of the interval between them.
#[test]
fn a_delay_shorter_than_stamps_are_good_is_none() {
    let bench = Bench::control();
    let mut context = bench.context(&bench.opened.data);
    context.noise = Some(vec![1e-9; 3]);
    let hypothesis = effect_of("time_delay", 0);
    let fit = bench.fit(context.data, std::slice::from_ref(&hypothesis));
    let held_out = context.recordings(Split::Validation);
    let interval = 1.0 / held_out[0].experiment.rate_hz;
    let signal = context.signal_rms(Split::Validation)[0];
    let reduction = |delay: f64| {
        let [poorer, richer] = [0.2, 0.1].map(|share| leaving(&fit, &[share * signal, 1.0, 1.0]));
        let richer = at(&richer, "time_delay.delay", delay);
        let pair = FitPair {
            poorer: &poorer,
            richer: &richer,
        };
        error_reduction(&context, &hypothesis, pair)
    };
    assert_eq!(reduction(0.049 * interval), 0.0);
    assert!((reduction(0.051 * interval) - 0.5).abs() < 1e-12);
    assert!((reduction(-0.051 * interval) - 0.5).abs() < 1e-12);
}

/// Friction that remembers takes more than what speeds that are off around reversals leave; what does not remember may take less.
#[test]
fn bristles_that_errors_of_speed_imitate_are_none() {
    let bench = Bench::control();
    let reduction = |id: &str, deviation: f64| {
        let data = bench.changed(&[Split::Validation], |experiment| {
            let speeds = &experiment.motion.velocity;
            let errors = speeds.iter().map(|v| [0.0, deviation * rms(v), 0.0]);
            experiment.motion_error = Some(MotionError::independent(&errors.collect::<Vec<_>>()));
        });
        let mut context = bench.context(&data);
        context.noise = Some(vec![1e-9; 3]);
        let hypothesis = effect_of(id, 0);
        let fit = bench.fit(context.data, std::slice::from_ref(&hypothesis));
        let signal = context.signal_rms(Split::Validation)[0];
        let [poorer, richer] = [0.02, 0.01].map(|share| leaving(&fit, &[share * signal, 1.0, 1.0]));
        let pair = FitPair {
            poorer: &poorer,
            richer: &richer,
        };
        error_reduction(&context, &hypothesis, pair)
    };
    let is_half = |reduction: f64| (reduction - 0.5).abs() < 1e-12;
    assert!(is_half(reduction("presliding_hysteresis", 0.0)));
    assert_eq!(reduction("presliding_hysteresis", 0.1), 0.0);
    assert!(is_half(reduction("stribeck_friction", 0.1)));
}

/// What is there for more than 95 % of the rows at which a joint moves is an offset of all of them.
#[test]
fn what_begins_and_ends_does_so_within_the_recordings() {
    let bench = Bench::control();
    let context = bench.context(&bench.opened.data);
    let hypothesis = effect_of("external_contact", 0);
    let fit = bench.fit(context.data, std::slice::from_ref(&hypothesis));
    let recordings = &context.data.recordings;
    let ends = |r: &Prepared| r.time(r.rows() - 1) - r.time(0);
    let duration = recordings.iter().map(ends).fold(f64::INFINITY, f64::min);
    let lasts = |share: f64| {
        let fit = at(&fit, "external_contact.from", recordings[0].time(0));
        let end = recordings[0].time(0) + share * duration;
        is_shorter(&context, &at(&fit, "external_contact.to", end), &hypothesis)
    };
    assert!(lasts(0.5) && lasts(0.94));
    assert!(!lasts(0.96) && !lasts(3.0));
    assert!(is_shorter(&context, &fit, &offset(0)));
    // A joint that moves in the first half alone.
    let halved = recordings.iter().map(|r| {
        let rests = |c: usize| (0..r.rows()).map(move |row| c == 0 && 2 * row > r.rows());
        let standing: Vec<Vec<bool>> = (0..r.experiment.signal.len())
            .map(|c| rests(c).collect())
            .collect();
        r.clone().with_standstill(&standing)
    });
    let halved = Dataset {
        recordings: halved.collect(),
    };
    let context = bench.context(&halved);
    let begun = at(&fit, "external_contact.from", recordings[0].time(0));
    let until = |share: f64| {
        let end = recordings[0].time(0) + share * duration;
        is_shorter(
            &context,
            &at(&begun, "external_contact.to", end),
            &hypothesis,
        )
    };
    assert!(until(0.4) && !until(0.6));
}

/// A law of friction may have ended in a shallow optimum when it was tried alone: of two fits of one model the better is kept.
#[test]
fn of_two_fits_of_a_model_the_better_is_kept() {
    let bench = Bench::control();
    let declared = bench.declared(&bench.opened.data);
    let leaving_train = |times: f64| {
        let mut fit = declared.clone();
        let series = fit.train.iter_mut().flatten();
        series.for_each(|e| *e *= times);
        fit
    };
    let (shallow, deep) = (leaving_train(1.1), leaving_train(0.9));
    for [known, made] in [[&shallow, &deep], [&deep, &shallow]] {
        let cache = FitCache::default();
        cache.fit_model(&[], || Ok(known.clone())).unwrap();
        let richer = [offset(0)];
        let found = cache.fit_from(&[], &richer, 0.0, || Ok(made.clone()));
        assert_eq!(found.unwrap().train, deep.train);
        let kept = cache.fit_model(&[], || unreachable!("it is known"));
        assert_eq!(kept.unwrap().train, deep.train);
    }
}

/// A ratio beyond z = 2.326 tells two apart, and has a chance of one in twenty where its mean, which grows by the root of the
/// length, is 1.645 less.
#[test]
fn rivals_are_inseparable_in_recordings_that_leave_a_chance_of_one_in_twenty() {
    let bench = Bench::control();
    let context = bench.context(&bench.opened.data);
    let poorer = bench.declared(context.data);
    let richer = bench.fit(context.data, &[offset(0)]);
    let noise_level = noise_level::of_rows(&context, &richer, &[]);
    let pair = FitPair {
        poorer: &poorer,
        richer: &richer,
    };
    let found = separation(&context, &noise_level, pair, &[0]);
    let times = (2.326_347_874 - 1.644_853_627) / found.evidence.distance;
    let expected = times.powi(2);
    assert!((found.times_longer.unwrap() / expected - 1.0).abs() < 1e-6);
}
