//! What counts as evidence in a diagnosis: correction for the number of hypotheses, sizes that matter, slopes that forecasts
//! have, names that are withdrawn, rows that judge; and controls, which stay silent.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::effect::{find, ids};
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::contexts::HeldOutHalves;
use crate::diagnose::fit::held_out::{self, Purpose};
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::{FitPair, ModelFit};
use crate::diagnose::fit::recording_parameters;
use crate::diagnose::residuals::effect_size::{MATTERS, OF_NOISE, OF_TORQUE, error_reduction};
use crate::diagnose::residuals::noise_level::NoiseLevel;
use crate::diagnose::selection::confirmation;
use crate::diagnose::selection::explanation::Explaining;
use crate::diagnose::selection::hypothesis_test::HypothesisTest;
use crate::diagnose::selection::reached::Reached;
use crate::diagnose::selection::rival_models::RivalComparison;
use crate::diagnose::selection::stepwise::{Rules, Stepwise};
use crate::diagnose::selection::weak_findings;
use crate::problem::solution::Control;
use crate::problem_file::ProblemFile;
use crate::recording::split::Split;
use crate::setup::robot::{Robot, open};
use crate::stats::encompassing::Encompassing;
use crate::trials::files::{PROBLEM, prepare};
use crate::trials::plan::{Plan, Scope};
use crate::trials::reference_fits::Opened;
use crate::trials::run::run;
use std::sync::Arc;

const SIGNIFICANCE: f64 = 0.001;

/// Robots of three joints in motions that repeat.
fn scope(effects: &[&'static str]) -> Scope {
    Scope {
        effects: effects.to_vec(),
        robots: vec!["arm3"],
        ..Scope::periodic(2)
    }
}

/// A trial of which every recording repeats, with its declared model fitted.
struct Bench {
    problem: ProblemFile,
    robot: Robot,
    opened: Opened,
    control: Control<'static>,
}

impl Bench {
    fn new(effects: &[&'static str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let control = Control::default();
        prepare(
            &Plan::draw(&scope(effects), (0, 0)),
            folder.path(),
            &control,
        )
        .unwrap();
        let path = folder.path().join(PROBLEM);
        let problem = ProblemFile::read(&path, &[], &ids()).unwrap();
        Self {
            robot: open(&problem).unwrap(),
            opened: Opened::read(&path, &control).unwrap(),
            problem,
            control,
        }
    }

    fn declared(&self, data: &Dataset) -> ModelFit {
        let fit = self.opened.fit(data, &[], &Vec::new(), &self.control);
        fit.unwrap()
    }

    /// The same recordings with other signals of some splits.
    fn with_signals(&self, splits: &[Split], other: impl Fn(f64) -> f64) -> Dataset {
        let of = |recording: &Prepared| {
            let mut recording = recording.clone();
            if splits.contains(&recording.split) {
                let series = &mut Arc::make_mut(&mut recording.experiment).signal;
                series.iter_mut().flatten().for_each(|s| *s = other(*s));
            }
            recording
        };
        Dataset {
            recordings: self.opened.data.recordings.iter().map(of).collect(),
        }
    }
}

fn offset(joint: usize) -> Hypothesis {
    Hypothesis {
        effect: find("torque_offset").unwrap(),
        joints: vec![joint],
        other: None,
    }
}

/// A fit that leaves as much in every held-out row of a channel.
fn leaving(fit: &ModelFit, left: &[f64]) -> ModelFit {
    let mut fit = fit.clone();
    for (series, left) in fit.validation.iter_mut().zip(left) {
        series.fill(*left);
    }
    fit
}

#[test]
fn a_control_stays_silent() {
    for number in [4, 9] {
        let trial = run(&scope(&["torque_offset"]), number, &Control::default());
        assert!(trial.concealed.is_empty());
        assert!(trial.found.is_empty(), "{number}: {:?}", trial.found);
        assert_eq!(trial.verdict, "nothing is missing", "{number}");
    }
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

/// Bonferroni: as many times the p-value of one test as there are hypotheses, in the search and in the test of its choice.
#[test]
fn p_values_are_corrected_for_the_number_of_hypotheses() {
    let bench = Bench::new(&["torque_offset"]);
    let halves = HeldOutHalves::of(bench.opened.data.clone(), Vec::new());
    let contexts = halves.contexts(&bench.problem, &bench.robot, &bench.control);
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
    let tests = stepwise.tests(&declared, &open, &[]).unwrap();
    assert!(
        tests
            .iter()
            .any(|test| test.p_value > 0.0 && test.p_value < 1.0)
    );
    assert!(tests.iter().all(|test| is_corrected(test, 6.0)));
    let chosen = [0, 1, 2].map(offset);
    let richer = bench
        .opened
        .fit(context.data, &chosen, &Vec::new(), &bench.control);
    let confirmed = confirmation::tests(&contexts, &richer.unwrap(), 7).unwrap();
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
    let mut context = bench.opened.context(data, &bench.control);
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

/// A finding that leaves more of the excess over the noise than it takes is withdrawn, unless what it leaves is noise.
#[test]
fn a_name_that_explains_less_than_it_leaves_is_withdrawn() {
    let bench = Bench::new(&["torque_offset"]);
    let declared = bench.declared(&bench.opened.data);
    let channels = declared.validation.len();
    let withdrawn = |before: f64, after: f64, measured: bool| {
        let noise = NoiseLevel {
            rms: vec![1.0; channels],
            measured,
        };
        let mut full = leaving(&declared, &vec![after.sqrt(); channels]);
        full.hypotheses = vec![offset(0)];
        let comparison = RivalComparison {
            without: leaving(&declared, &vec![before.sqrt(); channels]),
            alternatives: Vec::new(),
        };
        weak_findings::weakest(&noise, &full, &[comparison])
    };
    // Of an excess of 9 four ninths, then five.
    assert_eq!(withdrawn(10.0, 6.0, true), Some(0));
    assert_eq!(withdrawn(10.0, 5.0, true), None);
    // As much noise as misfit is explained.
    assert_eq!(withdrawn(3.0, 2.1, true), Some(0));
    assert_eq!(withdrawn(2.5, 1.9, true), None);
    assert_eq!(withdrawn(10.0, 6.0, false), None);
}

/// Offsets beside a misfit that no effect sought has, of twice their squares: the search finds them, and they are withdrawn.
#[test]
fn a_search_withdraws_what_it_found_beside_something_larger() {
    let bench = Bench::new(&["torque_offset"]);
    let context = bench.opened.context(&bench.opened.data, &bench.control);
    let size = 0.05 * context.signal_rms(Split::Train)[0];
    let misfit = |s: f64| s + size * (1.0 + 2.0 * (3.0 * s / size).sin());
    let data = bench.with_signals(&[Split::Train, Split::Validation], misfit);
    let halves = HeldOutHalves::of(data, Vec::new());
    let contexts = halves.contexts(&bench.problem, &bench.robot, &bench.control);
    let sought = ["torque_offset".to_string()];
    let explaining = Explaining {
        contexts: &contexts,
        rules: Rules {
            sought: Some(&sought),
            significance: SIGNIFICANCE,
        },
        watch: &|_| (),
        reached: &Reached::default(),
    };
    let declared = bench.declared(contexts.selection.data);
    let selection = explaining.select(declared).unwrap();
    let explanation = explaining.conclude(selection).unwrap();
    assert!(explanation.tried.iter().any(|step| step.accepted));
    assert!(explanation.full.hypotheses.is_empty());
    assert!(!explanation.withdrawn.is_empty());
}
