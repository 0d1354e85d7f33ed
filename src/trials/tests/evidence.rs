//! What counts as evidence in a diagnosis: correction for the number of hypotheses, sizes that matter, slopes that forecasts
//! have, names that are withdrawn, rows that judge; and controls, which stay silent.

use crate::chain::dataset::{Dataset, Prepared};
use crate::diagnose::conclusion::confirmation;
use crate::diagnose::conclusion::explanation::Explaining;
use crate::diagnose::conclusion::last_selection::LastSelection;
use crate::diagnose::conclusion::weak_findings;
use crate::diagnose::conclusion::zero_size;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::contexts::HeldOutHalves;
use crate::diagnose::fit::held_out::{self, Purpose};
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::{FitPair, ModelFit};
use crate::diagnose::fit::recording_parameters;
use crate::diagnose::residuals::effect_size::{MATTERS, OF_NOISE, OF_TORQUE, error_reduction};
use crate::diagnose::residuals::noise_level::NoiseLevel;
use crate::diagnose::residuals::reversal_mask;
use crate::diagnose::selection::forecast::{ComparedRows, under_way};
use crate::diagnose::selection::hypothesis_test::HypothesisTest;
use crate::diagnose::selection::rival_models::{Alternative, RivalComparison};
use crate::diagnose::selection::stepwise::{AlreadyTried, Rules, Stepwise};
use crate::problem::solution::Control;
use crate::recording::split::Split;
use crate::stats::encompassing::Encompassing;
use crate::trials::run::run;
use crate::trials::tests::bench::{
    Bench, CONTROLS, SIGNIFICANCE, effect_of, leaving, offset, scope,
};

#[test]
fn a_control_stays_silent() {
    for number in CONTROLS {
        let trial = run(&scope(&["torque_offset"]), number, &Control::default());
        assert!(trial.concealed.is_empty());
        assert!(trial.found.is_empty(), "{number}: {:?}", trial.found);
        assert_eq!(trial.verdict, "nothing is missing", "{number}");
    }
}

/// Of an offset and a friction by load that could stand in the place of one another, rows with an offset find it more probable,
/// where what neither explains does not decide.
#[test]
fn a_finding_is_called_by_the_name_that_rows_find_more_probable() {
    let bench = Bench::control();
    let data = bench.with_signals(&[Split::Train, Split::Validation], |s| s + 1.0);
    let context = bench.context(&data);
    let without = bench.declared(&data);
    let by_load = effect_of("load_dependent_friction", 0);
    let fits = [offset(0), by_load].map(|h| bench.fit(&data, &[h]));
    let [with_offset, with_friction] = &fits;
    assert_eq!(with_offset.freedom(), with_friction.freedom());
    let is_called_otherwise = |found: &ModelFit, rival: &ModelFit, clear: Option<ComparedRows>| {
        let hypothesis = rival.hypotheses[0].clone();
        let alternative = Alternative {
            test: HypothesisTest::of(&context, &without, rival.clone(), hypothesis),
            clear,
            better: false,
        };
        let comparison = RivalComparison {
            without: without.clone(),
            alternatives: vec![alternative],
            tried: 1,
        };
        !comparison.more_probable(&context, found).is_empty()
    };
    let all = Some(ComparedRows::All);
    assert!(is_called_otherwise(with_friction, with_offset, all));
    assert!(!is_called_otherwise(with_offset, with_friction, all));
    assert!(!is_called_otherwise(with_friction, with_offset, None));
}

#[test]
fn invariant_rows_that_are_held_out_take_no_part_in_a_fit() {
    let bench = Bench::new(&["torque_offset"]);
    let other = bench.with_signals(&[Split::Validation], |s| 1.3 * s + 0.2);
    let (one, another) = (bench.declared(&bench.opened.data), bench.declared(&other));
    assert_eq!(one.values, another.values);
    assert_ne!(one.validation, another.validation);
}

/// Blocks of a training recording, halves of held-out rows, and rows that fit what belongs to one recording: no row has
/// two parts, and none is lost.
#[test]
fn invariant_no_row_judges_what_it_was_fitted_to() {
    let bench = Bench::new(&["torque_offset"]);
    let train = |r: &&Prepared| r.split == Split::Train;
    let all: Vec<Prepared> = bench
        .opened
        .data
        .recordings
        .iter()
        .filter(train)
        .cloned()
        .collect();
    let rows = all[0].rows();
    let (blocks, held_out) = held_out::with_held_out(Dataset { recordings: all });
    assert!(held_out);
    let counting = |data: &Dataset, split: Split| -> Vec<usize> {
        data.of(split).flat_map(|r| r.counting()).collect()
    };
    let [fitted, judged] = [Split::Train, Split::Validation].map(|s| counting(&blocks, s));
    assert!(judged.iter().all(|row| !fitted.contains(row)));
    assert_eq!(fitted.len() + judged.len(), rows);
    let halves = [Purpose::Selection, Purpose::Test].map(|p| held_out::half(&blocks, p));
    let [chosen, tested] = halves.map(|half| counting(&half, Split::Validation));
    assert!(tested.iter().all(|row| !chosen.contains(row)));
    assert_eq!(chosen.len() + tested.len(), judged.len());
    let (every_other, between) = recording_parameters::alternate(&bench.opened.data);
    let judged = counting(&every_other, Split::Validation);
    let fitted: Vec<usize> = between.iter().flat_map(Prepared::counting).collect();
    assert!(!fitted.is_empty() && judged.iter().all(|row| !fitted.contains(row)));
    assert_eq!(
        bench.declared(&blocks).train[0].len(),
        counting(&blocks, Split::Train).len()
    );
}

/// Rows that choose are fitted beside rows that test but for those which noise connects with these, also over the ends of a period;
/// recordings of which all rows are such are left out.
#[test]
fn invariant_no_row_is_fitted_that_noise_connects_with_a_row_that_tests() {
    let bench = Bench::new(&["torque_offset"]);
    let halves = HeldOutHalves::of(bench.opened.data.clone(), Vec::new());
    let contexts = halves.contexts(&bench.opened.declared, &bench.control);
    let counting = |data: &Dataset| -> Vec<Vec<usize>> {
        let held_out = data.of(Split::Validation);
        held_out.map(|r| r.counting().collect()).collect()
    };
    let (choose, test) = (
        counting(contexts.selection.data),
        counting(contexts.test.data),
    );
    let recordings = bench.opened.data.of(Split::Validation);
    let rows: Vec<usize> = recordings.map(Prepared::rows).collect();
    let memory = 7;
    let data = contexts.with_selection_fitted(memory);
    let trained = bench.opened.data.of(Split::Train).count();
    let fitted: Vec<Vec<usize>> = data
        .of(Split::Train)
        .skip(trained)
        .map(|r| r.counting().collect())
        .collect();
    assert_eq!(fitted.len(), choose.len());
    assert_eq!(counting(&data), test);
    for (((fitted, choose), test), &rows) in fitted.iter().zip(&choose).zip(&test).zip(&rows) {
        let distance = |a: usize, b: usize| a.abs_diff(b).min(rows - a.abs_diff(b));
        let is_far = |row: &usize| test.iter().all(|t| distance(*row, *t) > memory);
        let far: Vec<usize> = choose.iter().copied().filter(is_far).collect();
        assert!(far.len() < choose.len() && !far.is_empty());
        assert_eq!(*fitted, far);
    }
    let longest = rows.into_iter().max().unwrap();
    let data = contexts.with_selection_fitted(longest);
    assert_eq!(data.of(Split::Train).count(), trained);
}

/// Bonferroni: as many times the p-value of one test as there are hypotheses, in the search and in the test of its choice.
#[test]
fn p_values_are_corrected_for_the_number_of_hypotheses() {
    let bench = Bench::new(&["torque_offset"]);
    let halves = HeldOutHalves::of(bench.opened.data.clone(), Vec::new());
    let contexts = halves.contexts(&bench.opened.declared, &bench.control);
    let context = &contexts.selection;
    let declared = bench.declared(context.data);
    let sought = ["torque_offset".to_string(), "joint_spring".to_string()];
    let rules = Rules {
        sought: Some(&sought),
        significance: SIGNIFICANCE,
    };
    let stepwise = Stepwise {
        context,
        rules,
        progress: &|_| (),
    };
    let open = rules.open(context, &declared);
    assert_eq!(open.len(), 6);
    let is_corrected = |test: &HypothesisTest, count: f64| {
        test.p_value == (count * test.evidence.p_value).min(1.0)
    };
    let tests = stepwise
        .tests(&declared, &open, AlreadyTried::default())
        .unwrap();
    assert!(
        tests
            .iter()
            .any(|test| test.p_value > 0.0 && test.p_value < 1.0)
    );
    assert!(tests.iter().all(|test| is_corrected(test, 6.0)));
    let chosen = [0, 1, 2].map(offset);
    let richer = bench.fit(context.data, &chosen);
    let confirmed = confirmation::tests(&contexts, &richer, 7).unwrap();
    assert_eq!(confirmed.len(), 3);
    assert!(confirmed.iter().all(|test| is_corrected(test, 7.0)));
    assert!(confirmed.iter().any(|test| test.evidence.p_value > 0.0));
}

#[test]
fn a_hypothesis_is_needed_where_it_is_significant_matters_and_forecasts() {
    let bench = Bench::new(&["torque_offset"]);
    let evidence = |slope: f64, p_value: f64| Encompassing {
        slope,
        ratio: 5.0,
        distance: 5.0,
        freedom: 50.0,
        p_value,
    };
    let fit = bench.declared(&bench.opened.data);
    let needed = |slope: f64, p_value: f64, error_reduction: f64| {
        let test = HypothesisTest {
            hypothesis: offset(0),
            fit: fit.clone(),
            evidence: evidence(slope, p_value),
            p_value,
            error_reduction,
        };
        test.is_needed(SIGNIFICANCE)
    };
    assert!(needed(1.0, 1e-4, 0.02));
    // What is more than twice as large where it was not fitted is something else.
    assert!(needed(1.9, 1e-4, 0.02) && !needed(2.1, 1e-4, 0.02));
    assert!(needed(1.0, 9e-4, 0.02) && !needed(1.0, 1.1e-3, 0.02));
    assert!(needed(1.0, 1e-4, 1.01 * MATTERS) && !needed(1.0, 1e-4, 0.99 * MATTERS));
}

/// What an effect takes away, √(before² − after²), has to be half of the noise and a fifth of a percent of the signal.
#[test]
fn an_effect_matters_beside_the_noise_and_beside_the_signal() {
    let bench = Bench::new(&["torque_offset"]);
    let data = &bench.opened.data;
    let mut context = bench.context(data);
    let fit = bench.declared(data);
    let channels = fit.validation.len();
    let signal = context.signal_rms(Split::Validation);
    let reduction = |context: &Context<'_>, before: f64, taken: f64| {
        let after = (before * before - taken * taken).sqrt();
        // The other joints are as they were.
        let mut left = vec![1.0; channels];
        left[0] = before;
        let poorer = leaving(&fit, &left);
        left[0] = after;
        let richer = leaving(&fit, &left);
        let pair = FitPair {
            poorer: &poorer,
            richer: &richer,
        };
        let expected = 1.0 - after / before;
        (error_reduction(context, &offset(0), pair), expected)
    };
    for (limit, noise) in [
        (OF_NOISE * signal[0], signal[0]),
        (OF_TORQUE * signal[0], 1e-6 * signal[0]),
    ] {
        context.noise = Some(vec![noise; channels]);
        let before = 3.0 * limit;
        let (little, _) = reduction(&context, before, 0.99 * limit);
        assert_eq!(little, 0.0);
        let (enough, expected) = reduction(&context, before, 1.01 * limit);
        assert!((enough - expected).abs() < 1e-12, "{enough}, {expected}");
    }
    assert_eq!([MATTERS, OF_NOISE, OF_TORQUE], [0.01, 0.5, 0.002]);
}

/// A declared model, of which a single finding leaves some lacks of fit of others.
struct Weak<'a> {
    context: Context<'a>,
    declared: ModelFit,
}

impl<'a> Weak<'a> {
    fn of(bench: &'a Bench) -> Self {
        Self {
            context: bench.context(&bench.opened.data),
            declared: bench.declared(&bench.opened.data),
        }
    }

    /// The number of a finding that leaves these lacks of fit, `[before, after]` by channel, if it is withdrawn.
    fn withdrawn(
        &self,
        finding: Hypothesis,
        lacks: [[f64; 3]; 2],
        measured: bool,
    ) -> Option<usize> {
        let leaving = |lacks: [f64; 3]| leaving(&self.declared, &lacks.map(f64::sqrt));
        let [without, full] = lacks.map(leaving);
        self.among(finding, without, full, measured)
    }

    fn among(
        &self,
        finding: Hypothesis,
        without: ModelFit,
        mut full: ModelFit,
        measured: bool,
    ) -> Option<usize> {
        let noise = NoiseLevel {
            rms: vec![1.0; full.validation.len()],
            measured,
        };
        full.hypotheses = vec![finding];
        let comparison = RivalComparison {
            without,
            alternatives: Vec::new(),
            tried: 0,
        };
        weak_findings::weakest(&self.context, &noise, &full, &[comparison])
    }
}

/// A finding that leaves more of the excess over the noise than it takes is withdrawn, unless what it leaves is noise.
#[test]
fn a_name_that_explains_less_than_it_leaves_is_withdrawn() {
    let bench = Bench::new(&["torque_offset"]);
    let weak = Weak::of(&bench);
    let withdrawn = |before: f64, after: f64, measured: bool| {
        weak.withdrawn(offset(0), [[before; 3], [after; 3]], measured)
    };
    // Of an excess of 9 four ninths, then five.
    assert_eq!(withdrawn(10.0, 6.0, true), Some(0));
    assert_eq!(withdrawn(10.0, 5.0, true), None);
    // As much noise as misfit is explained.
    assert_eq!(withdrawn(3.0, 2.1, true), Some(0));
    assert_eq!(withdrawn(2.5, 1.9, true), None);
    assert_eq!(withdrawn(10.0, 6.0, false), None);
}

/// A finding of which only rows around reversals leave much is kept, and one that leaves as much under way is not.
#[test]
fn what_is_left_around_reversals_does_not_speak_against_a_name() {
    let bench = Bench::new(&["torque_offset"]);
    let weak = Weak::of(&bench);
    let under_way = reversal_mask::rows(&weak.context, &weak.declared, 0).unwrap();
    let leaving = |of_reversals: f64, of_others: f64| {
        let mut fit = leaving(&weak.declared, &[1.0; 3]);
        let rows = fit.validation[0].iter_mut().zip(&under_way);
        for (left, moves) in rows {
            *left = if *moves { of_others } else { of_reversals };
        }
        fit
    };
    let withdrawn = |full| weak.among(offset(0), leaving(20.0, 2.0), full, true);
    assert_eq!(withdrawn(leaving(19.0, 1.0)), None);
    assert_eq!(withdrawn(leaving(19.0, 1.9)), Some(0));
}

/// A load explains most in the channels of the joints that carry it, where more may be missing in that of its own joint.
#[test]
fn a_load_is_judged_where_it_explains_most() {
    let bench = Bench::new(&["torque_offset"]);
    let weak = Weak::of(&bench);
    let lacks = [[100.0, 100.0, 10.0], [5.0, 5.0, 8.0]];
    let load = effect_of("unmodelled_payload", 2);
    assert_eq!(weak.withdrawn(load, lacks, true), None);
    assert_eq!(weak.withdrawn(offset(2), lacks, true), Some(0));
}

/// Where nothing has an offset, the estimates of three are as far from zero as noise makes them, and the least certain of
/// them is the first to be struck out; an offset of a hundredth of the signal stays.
#[test]
fn a_size_that_may_be_none_is_the_first_to_be_withdrawn() {
    let bench = Bench::control();
    let size = 0.01
        * bench
            .opened
            .context(&bench.opened.data, &bench.control)
            .signal_rms(Split::Train)[0];
    let offsets = [0, 1, 2].map(offset);
    for (added, remaining) in [(0.0, 0), (size, 3)] {
        let data = bench.with_signals(&[Split::Train, Split::Validation], |s| s + added);
        let context = bench.context(&data);
        let mut left = offsets.to_vec();
        loop {
            let fit = bench.fit(&data, &left);
            let Some(k) = zero_size::least_certain(&context, &fit) else {
                break;
            };
            left.remove(k);
        }
        assert_eq!(left.len(), remaining, "{added}");
    }
}

/// Offsets beside a misfit that no effect sought has, of twice their squares: the search finds them, and they are withdrawn.
/// That they took a third of the squares away is known all the same.
#[test]
fn a_search_withdraws_what_it_found_beside_something_larger() {
    let bench = Bench::new(&["torque_offset"]);
    let context = bench.context(&bench.opened.data);
    let size = 0.05 * context.signal_rms(Split::Train)[0];
    let misfit = |s: f64| s + size * (1.0 + 2.0 * (3.0 * s / size).sin());
    let data = bench.with_signals(&[Split::Train, Split::Validation], misfit);
    let halves = HeldOutHalves::of(data, Vec::new());
    let contexts = halves.contexts(&bench.opened.declared, &bench.control);
    let sought = ["torque_offset".to_string()];
    let explaining = Explaining {
        contexts: &contexts,
        rules: Rules {
            sought: Some(&sought),
            significance: SIGNIFICANCE,
        },
        on_stage: &|_| (),
        reached: &LastSelection::default(),
    };
    let declared = bench.declared(contexts.selection.data);
    let selection = explaining.select(declared).unwrap();
    let explanation = explaining.conclude(selection).unwrap();
    assert!(explanation.tried.iter().any(|step| step.accepted));
    assert!(explanation.full.hypotheses.is_empty());
    assert!(!explanation.withdrawn.is_empty());
    let of = |channel: usize| explanation.least_tried(channel, explaining.rules);
    let share = of(0).unwrap().share;
    assert!((share.powi(2) - 2.0 / 3.0).abs() < 0.1, "{share}");
}

/// What is left at the reversals of a joint is not looked at on its own channel, and is on that of any other.
#[test]
fn rows_under_way_are_those_of_the_joint_that_moves() {
    let bench = Bench::new(&["torque_offset"]);
    let context = bench.context(&bench.opened.data);
    let poorer = bench.declared(context.data);
    let richer = bench.fit(context.data, &[offset(0)]);
    let p_value = |poorer: &ModelFit| {
        let pair = FitPair {
            poorer,
            richer: &richer,
        };
        under_way(&context, pair, None).p_value
    };
    let joints = poorer.model.joints().len();
    let under_way: Vec<Vec<bool>> = (0..joints)
        .map(|joint| reversal_mask::rows(&context, &poorer, joint).unwrap())
        .collect();
    let usual = p_value(&poorer);
    for channel in 0..joints {
        for (joint, rows) in under_way.iter().enumerate() {
            let mut off = poorer.clone();
            let series = off.validation[channel].iter_mut();
            for (e, moves) in series.zip(rows) {
                *e += if *moves { 0.0 } else { 1e3 };
            }
            let same = p_value(&off) == usual;
            assert_eq!(same, joint == channel, "joint {joint}, channel {channel}");
        }
    }
}
