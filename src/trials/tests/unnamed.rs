//! What has no name in a diagnosis: smooth corrections, residuals that are left, and rivals.

use crate::chain::dataset::Dataset;
use crate::diagnose::conclusion::explanation::Explanation;
use crate::diagnose::findings::compared::Compared;
use crate::diagnose::findings::corrections::Corrections;
use crate::diagnose::findings::unexplained::SearchState;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::contexts::HeldOutHalves;
use crate::diagnose::fit::held_out::Purpose;
use crate::diagnose::fit::model_fit::{FitPair, ModelFit};
use crate::diagnose::formula::seeking::Seeking;
use crate::diagnose::residuals::additive_model::{self, AdditiveModel};
use crate::diagnose::residuals::effect_size::{MATTERS, OF_NOISE, OF_TORQUE};
use crate::diagnose::residuals::noise_level::{self, NoiseLevel, chance};
use crate::diagnose::residuals::prediction_error::PredictionError;
use crate::diagnose::residuals::quantity::Quantity;
use crate::diagnose::residuals::reversal_mask;
use crate::diagnose::selection::forecast::forecast;
use crate::diagnose::selection::rival_models::RivalComparison;
use crate::diagnose::selection::stepwise::{Rules, Stepwise};
use crate::outcome::finding::Finding;
use crate::recording::split::Split;
use crate::robot::random::generator;
use crate::stats::deviation::rms;
use crate::trials::tests::bench::{Bench, SIGNIFICANCE, effect_of, offset};
use nalgebra::DMatrix;
use rand::RngExt;
use rand_distr::StandardNormal;
use std::sync::Arc;

const BOTH: [Split; 2] = [Split::Train, Split::Validation];

/// Smooth corrections of all channels.
fn of_all(context: &Context<'_>, fit: &ModelFit) -> Vec<AdditiveModel> {
    let all: Vec<usize> = (0..fit.model.channels().len()).collect();
    additive_model::of_some(context, fit, &all)
}

/// Whether a smooth correction is significant beside all that were tried, and large enough.
#[test]
fn a_correction_is_needed_where_it_is_significant_and_matters() {
    let bench = Bench::control();
    let data = with_law(&bench);
    let context = bench.context(&data);
    let declared = bench.declared(context.data);
    let mut correction = of_all(&context, &declared).remove(0);
    correction.tried = 5;
    let mut set = |p_value: f64, error_reduction: f64, taken: f64| {
        correction.evidence.p_value = p_value;
        correction.error_reduction = error_reduction;
        correction.taken = taken;
        correction.is_needed(0.05, 3)
    };
    let (just, over) = (0.99 * 0.05, 1.01 * 0.05);
    // Of three channels with five models each.
    assert!(set(just / 15.0, 0.1, 1.0) && !set(over / 15.0, 0.1, 1.0));
    assert!(set(1e-9, 1.01 * MATTERS, 1.0) && !set(1e-9, 0.99 * MATTERS, 1.0));
    assert!(set(1e-9, 0.1, 1.01 * OF_NOISE) && !set(1e-9, 0.1, 0.99 * OF_NOISE));
}

/// Recordings in which the first channel has a torque that the speed of its joint and the position of the next give together.
fn with_law(bench: &Bench) -> Dataset {
    let signal = rms(&bench.opened.data.recordings[0].experiment.signal[0]);
    let speed = rms(&bench.opened.data.recordings[0].experiment.motion.velocity[0]);
    bench.with_added(&|experiment, row| {
        let (v, q) = (
            experiment.motion.velocity[0][row],
            experiment.motion.position[1][row],
        );
        0.1 * signal * (v / speed).tanh() * (2.0 * q).cos()
    })
}

/// A smooth correction says of what the misfit is a function, forecasts it on rows that were not fitted, and is the same beside
/// other rows.
#[test]
fn a_correction_has_the_variables_of_the_misfit() {
    let bench = Bench::control();
    let data = with_law(&bench);
    let context = bench.context(&data);
    let declared = bench.declared(context.data);
    let [correction] = &of_all(&context, &declared)[..] else {
        panic!("one channel has a misfit");
    };
    assert_eq!(correction.channel, 0);
    let mut made_of = correction.made_of[0].clone();
    made_of.sort_by_key(|quantity| format!("{quantity:?}"));
    assert_eq!(made_of, [Quantity::OtherPosition(1), Quantity::Velocity]);
    assert!(correction.error_reduction > 0.5, "{correction:?}");
    assert!(correction.evidence.p_value < 1e-6);
    let again = correction.on(&context, &declared, &[]);
    assert_eq!(again.train, correction.train);
    assert_eq!(again.validation, correction.validation);
    assert_eq!(again.evidence, correction.evidence);
    let left = additive_model::left(&declared, &[correction]);
    let share = rms(&left[0]) / rms(&declared.validation[0]);
    assert!((share - (1.0 - correction.error_reduction)).abs() < 1e-12);
}

/// Corrections of what a declared model leaves, and which of the held-out rows of the first channel chose models.
fn corrections(bench: &Bench, data: Dataset) -> (Vec<AdditiveModel>, Vec<bool>) {
    let halves = HeldOutHalves::of(data, Vec::new());
    let contexts = halves.contexts(&bench.opened.declared, &bench.control);
    let full = bench.declared(contexts.whole.data);
    let rules = Rules {
        sought: None,
        significance: SIGNIFICANCE,
    };
    let found = Corrections::of(&contexts, &full, rules);
    let pairs = contexts.whole.data.recordings.iter();
    let pairs = pairs.zip(&contexts.selection.data.recordings);
    let held_out = pairs.filter(|(whole, _)| whole.split == Split::Validation);
    let chose = held_out.flat_map(|(whole, chose)| {
        let rows = whole.counting_for(0);
        rows.map(|row| chose.counts_for(0, row))
    });
    let chose = chose.collect();
    (found.over_all_rows(&contexts, &full), chose)
}

/// What corrections take of the held-out rows of the first channel.
fn taken(all: &[AdditiveModel]) -> Vec<f64> {
    let rows = all[0].validation[0].len();
    (0..rows)
        .map(|k| all.iter().map(|c| c.validation[0][k]).sum())
        .collect()
}

/// Where a half of the held-out rows changes what is taken of the other half does, and what is taken of itself does not.
#[test]
fn invariant_no_held_out_row_is_forecast_by_a_correction_that_was_fitted_to_it() {
    let bench = Bench::control();
    let data = with_law(&bench);
    let (before, chose) = corrections(&bench, data.clone());
    let before = taken(&before);
    assert!(rms(&before) > 0.0 && chose.iter().any(|c| *c) && !chose.iter().all(|c| *c));
    for half in [Purpose::Selection, Purpose::Test] {
        let halves = HeldOutHalves::of(data.clone(), Vec::new());
        let contexts = halves.contexts(&bench.opened.declared, &bench.control);
        let changed = match half {
            Purpose::Selection => contexts.selection.data,
            Purpose::Test => contexts.test.data,
        };
        let mut other = data.clone();
        for (recording, part) in other.recordings.iter_mut().zip(&changed.recordings) {
            if recording.split == Split::Validation {
                let experiment = Arc::make_mut(&mut recording.experiment);
                let scale = 0.02 * rms(&experiment.signal[0]);
                for row in part.counting() {
                    let q = experiment.motion.position[2][row];
                    experiment.signal[0][row] += scale * (3.0 * q).sin();
                }
            }
        }
        let (after, _) = corrections(&bench, other);
        let after = taken(&after);
        let change = |of_chosen: bool| {
            let rows = (0..chose.len()).filter(|k| chose[*k] == of_chosen);
            let by: Vec<f64> = rows.map(|k| after[k] - before[k]).collect();
            rms(&by) / rms(&before)
        };
        let of_itself = half == Purpose::Selection;
        assert!(change(of_itself) < 1e-9, "{half:?} {}", change(of_itself));
        assert!(change(!of_itself) > 1e-3, "{half:?} {}", change(!of_itself));
    }
}

/// The first formula leaves hardly more of rows that were not fitted than any, and those that only resemble the law come later.
#[test]
fn formulas_that_forecast_well_come_first() {
    let bench = Bench::control();
    let data = with_law(&bench);
    let context = bench.context(&data);
    let declared = bench.declared(context.data);
    let seeking = Seeking {
        context: &context,
        model: &declared,
        variables: &[vec![Quantity::Velocity, Quantity::OtherPosition(1)]],
    };
    let all = seeking.fitted(0).unwrap().all;
    let left = |k: usize| rms(&all[k].fit.validation[0]);
    let order = seeking.in_order(0, &all);
    assert!(order.len() > 1);
    let least = (0..all.len()).map(left).fold(f64::INFINITY, f64::min);
    assert!(left(order[0]) < 1.1 * least);
    assert!(left(order[order.len() - 1]) > 1.5 * least);
}

/// A formula of one variable more, which takes hardly more of the squares, comes after the best without it.
#[test]
fn formulas_of_few_variables_come_first_where_more_take_hardly_more() {
    let bench = Bench::control();
    let signal = rms(&bench.opened.data.recordings[0].experiment.signal[0]);
    let data = bench.with_added(&|experiment, row| {
        let [q, other] = [1, 2].map(|joint| experiment.motion.position[joint][row]);
        signal * (0.5 * (2.0 * q).cos() + 0.03 * other)
    });
    let context = bench.context(&data);
    let declared = bench.declared(context.data);
    let seeking = Seeking {
        context: &context,
        model: &declared,
        variables: &[vec![Quantity::OtherPosition(1), Quantity::OtherPosition(2)]],
    };
    let all = seeking.fitted(0).unwrap().all;
    let order = seeking.in_order(0, &all);
    let left = |k: usize| rms(&all[k].fit.validation[0]);
    let least = (0..all.len()).min_by(|&a, &b| left(a).total_cmp(&left(b)));
    let least = least.unwrap();
    let variables = |k: usize| all[k].formula().variables().len();
    let [first, least] = [order[0], least].map(|k| (variables(k), left(k)));
    assert!(
        least.0 > 1 && first.1 > (1.0 + 2.0 * MATTERS) * least.1,
        "{first:?} {least:?}"
    );
    assert_eq!(first.0, 1);
}

/// Formulas of all variables lead to those of the variables of the best, which have more shapes.
#[test]
fn formulas_of_all_variables_are_narrowed_to_those_of_the_best() {
    let bench = Bench::control();
    let data = with_law(&bench);
    let context = bench.context(&data);
    let declared = bench.declared(context.data);
    let least = |variables: &[Vec<Quantity>]| {
        let seeking = Seeking {
            context: &context,
            model: &declared,
            variables,
        };
        let all = seeking.fitted(0).unwrap().all;
        let left = all.iter().map(|of| rms(&of.fit.validation[0]));
        left.fold(f64::INFINITY, f64::min)
    };
    let known = least(&[vec![Quantity::Velocity, Quantity::OtherPosition(1)]]);
    let unknown = least(&[]);
    assert!(unknown < 1.01 * known, "{unknown} {known}");
}

/// Where the residual is noise no correction is sought.
#[test]
fn complete_models_have_no_correction() {
    let bench = Bench::control();
    let context = bench.context(&bench.opened.data);
    let declared = bench.declared(context.data);
    assert!(of_all(&context, &declared).is_empty());
}

/// White noise of so many RMS in the first channels, held out, and next to nothing in the others.
fn with_noise(fit: &ModelFit, rms: &[f64]) -> ModelFit {
    let mut fit = fit.clone();
    let mut rng = generator(3);
    let (loud, quiet) = fit.validation.split_at_mut(rms.len());
    for (series, rms) in loud.iter_mut().zip(rms) {
        for e in series {
            let fresh: f64 = rng.sample(StandardNormal);
            *e = rms * fresh;
        }
    }
    let quiet = quiet.iter_mut().flatten();
    quiet.for_each(|e| *e *= 1e-9);
    fit
}

/// Findings without a name where channels leave white noise, held against noise of a size.
fn unexplained(
    context: &Context<'_>,
    full: &ModelFit,
    noise: f64,
    state: SearchState<'_>,
) -> Vec<Finding> {
    let noise_level = NoiseLevel {
        rms: full.validation.iter().map(|_| noise).collect(),
        measured: true,
    };
    let compared = Compared {
        context,
        declared: full,
        full,
        noise_level: &noise_level,
        predicted: &PredictionError::of(context, full, None),
    };
    compared.unexplained(&[], state)
}

/// A residual is looked at in two views of each of three joints.
#[test]
fn chances_of_residuals_are_corrected_for_joints_and_views() {
    let bench = Bench::control();
    let context = bench.context(&bench.opened.data);
    let declared = bench.declared(context.data);
    let signal = context.signal_rms(Split::Validation)[0];
    let noise = 0.05 * signal;
    let full = with_noise(&declared, &[1.6 * noise]);
    let state = SearchState {
        significance: 0.5,
        withdrawn: &[],
        is_cut_short: false,
    };
    let found = unexplained(&context, &full, noise, state);
    assert_eq!(found.len(), 1);
    let residual = &full.validation[0];
    let under_way = reversal_mask::residual(&context, &full, 0, residual);
    let chances = [&residual[..], &under_way].map(|rows| chance(rows, noise));
    let least = chances.into_iter().flatten().reduce(f64::min).unwrap();
    assert!(least > 1e-12 && least < 0.05, "{least}");
    assert!((found[0].p_value / (6.0 * least) - 1.0).abs() < 1e-12);
    let strict = SearchState {
        significance: 5.9 * least,
        ..state
    };
    assert!(unexplained(&context, &full, noise, strict).is_empty());
}

/// What is furthest beyond the noise comes first, whatever the order of the joints.
#[test]
fn what_is_furthest_from_the_noise_comes_first() {
    let bench = Bench::control();
    let context = bench.context(&bench.opened.data);
    let declared = bench.declared(context.data);
    let signal = context.signal_rms(Split::Validation);
    let noise = 0.1 * signal[0].max(signal[1]);
    let state = SearchState {
        significance: SIGNIFICANCE,
        withdrawn: &[],
        is_cut_short: false,
    };
    let names: Vec<&String> = declared.model.channels().iter().map(|c| &c.name).collect();
    for (times, order) in [([3.0, 5.0], [1, 0]), ([5.0, 3.0], [0, 1])] {
        let full = with_noise(&declared, &times.map(|times| times * noise));
        let found = unexplained(&context, &full, noise, state);
        let joints: Vec<&String> = found.iter().map(|finding| &finding.joints[0]).collect();
        assert_eq!(joints, order.map(|c| names[c]));
    }
}

/// Of a joint without a row that counts nothing is said to be noise.
#[test]
fn a_joint_without_rows_is_not_attested() {
    let bench = Bench::control();
    let context = bench.context(&bench.opened.data);
    let declared = bench.declared(context.data);
    let noise_level = noise_level::of_rows(&context, &declared, &[]);
    let mut full = declared.clone();
    full.validation[0].clear();
    let compared = Compared {
        context: &context,
        declared: &declared,
        full: &full,
        noise_level: &noise_level,
        predicted: &PredictionError::of(&context, &declared, None),
    };
    let nothing = Explanation {
        full: full.clone(),
        tests: Vec::new(),
        comparisons: Vec::new(),
        prefixes: Vec::new(),
        examined: 0,
        withdrawn: Vec::new(),
        tried: Vec::new(),
    };
    let rules = Rules {
        sought: None,
        significance: SIGNIFICANCE,
    };
    let [left] = &compared.unattested(&[], &nothing, rules)[..] else {
        panic!("one joint has no rows");
    };
    assert_eq!(left.joint, full.model.channels()[0].name);
    assert!(left.rmse_validation.is_nan() && left.sentence.contains("no row"));
}

/// However far beyond the noise, a residual that is small beside the signal is none, except where a name was withdrawn.
#[test]
fn residuals_of_no_weight_are_left() {
    let bench = Bench::control();
    let context = bench.context(&bench.opened.data);
    let declared = bench.declared(context.data);
    let signal = context.signal_rms(Split::Validation)[0];
    let found = |residual: f64, withdrawn: &[usize]| {
        let full = with_noise(&declared, &[residual * signal]);
        let state = SearchState {
            significance: SIGNIFICANCE,
            withdrawn,
            is_cut_short: false,
        };
        let noise = 0.2 * residual * signal;
        unexplained(&context, &full, noise, state).len()
    };
    assert_eq!(found(0.9 * OF_TORQUE, &[]), 0);
    assert_eq!(found(1.1 * OF_TORQUE, &[]), 1);
    assert_eq!(found(0.9 * OF_TORQUE, &[0]), 1);
}

/// A rival takes the place of a finding where it forecasts what that leaves, as one of all that were tried.
#[test]
fn rivals_are_corrected_for_their_number() {
    let bench = Bench::control();
    let usual = bench.context(&bench.opened.data);
    let size = 0.01 * usual.signal_rms(Split::Train)[0];
    let data = bench.changed(&BOTH, |experiment| {
        experiment.signal[0].iter_mut().for_each(|s| *s += size);
    });
    let context = bench.context(&data);
    let sought = ["torque_offset", "stribeck_friction"].map(String::from);
    let full = bench.fit(context.data, &[effect_of("stribeck_friction", 0)]);
    let noise_level = noise_level::of_rows(&context, &full, &[]);
    let rivals = |significance: f64| {
        let stepwise = Stepwise {
            context: &context,
            rules: Rules {
                sought: Some(&sought),
                significance,
            },
            progress: &|_| (),
        };
        let comparison = stepwise.rivals(&full, 0, &noise_level).unwrap();
        let mut open = stepwise.rules.open(&context, &comparison.without);
        open.retain(|h| *h != full.hypotheses[0] && !h.overlaps(&full.hypotheses[0]));
        (comparison, open.len() as f64)
    };
    let of_offset = |comparison: &RivalComparison| {
        let mut all = comparison.alternatives.iter();
        let found = all.find(|a| a.test.hypothesis == offset(0)).unwrap();
        let pair = FitPair {
            poorer: &full,
            richer: &found.test.fit,
        };
        (found.better, forecast(&context, pair).p_value)
    };
    let (comparison, count) = rivals(0.05);
    let (better, p_value) = of_offset(&comparison);
    assert_eq!((better, count), (true, 5.0), "{p_value}");
    assert!(p_value > 0.0);
    assert!(!of_offset(&rivals(0.99 * count * p_value).0).0);
    assert!(of_offset(&rivals(1.01 * count * p_value).0).0);
}

/// Rows at less than half of the usual speed count if reversals, and rows at which the joint creeps, are further away than
/// half a period of the bandwidth.
#[test]
fn rows_under_way_are_fast_or_away_from_reversals() {
    let bench = Bench::control();
    let context = bench.context(&bench.opened.data);
    let declared = bench.declared(context.data);
    let recordings = context.recordings(Split::Validation);
    for joint in 0..3 {
        let mut expected = Vec::new();
        for recording in &recordings {
            let speed = &recording.segment().motors.dq[joint];
            let usual = rms(speed);
            let turns = |k: usize| k > 0 && (speed[k] < 0.0) != (speed[k - 1] < 0.0);
            let near = |k: &usize| turns(*k) || speed[*k].abs() <= 0.03 * usual;
            let near: Vec<usize> = (0..speed.len()).filter(near).collect();
            let rate = recording.experiment.rate_hz;
            let reach = 0.5 * rate / recording.experiment.bandwidth[joint].cutoff_hz;
            let is_away = |row: usize| {
                near.iter().all(|&k| match row >= k {
                    true => (row - k) as f64 >= reach,
                    false => (k - row) as f64 > reach.ceil(),
                })
            };
            let counts = |row: usize| speed[row].abs() > 0.5 * usual || is_away(row);
            expected.extend(recording.counting().map(counts));
        }
        let rows = reversal_mask::rows(&context, &declared, joint);
        assert_eq!(rows.as_ref(), Some(&expected));
        let slow = expected.iter().filter(|counts| !**counts).count();
        assert!(slow > 0 && slow < expected.len());
    }
}

/// An offset that is known within σ adds σ/k to every prediction of a current.
#[test]
fn uncertain_parameters_add_their_share_to_predictions() {
    let bench = Bench::control();
    let context = bench.context(&bench.opened.data);
    let fit = bench.fit(context.data, &[offset(0)]);
    let positions = fit.unknowns.positions();
    let name = format!("{}.torque_offset.offset", fit.model.joints()[0].name);
    let parameter = fit.model.find(&name).unwrap();
    let at = positions.iter().position(|p| *p == parameter).unwrap();
    let noise = 0.7;
    let deviation = rms(&fit.train[0]) * fit.model.joints()[0].torque_constant;
    let beside = |sigma: f64| {
        let mut covariance = DMatrix::zeros(positions.len(), positions.len());
        covariance[(at, at)] = sigma * sigma;
        let predicted = PredictionError::of(&context, &fit, Some(&covariance));
        [0, 1].map(|channel| predicted.beside(channel, noise))
    };
    assert_eq!(beside(0.0), [noise, noise]);
    let expected = noise * (1.0_f64 + 9.0 / 16.0).sqrt();
    let [own, other] = beside(0.75 * deviation);
    assert!((own / expected - 1.0).abs() < 1e-9, "{own}, {expected}");
    assert_eq!(other, noise);
}
