//! Effects that belong to one recording: a push in the held-out recording at another time than in the fitted one.

use exid::chain::dataset::{Dataset, Prepared};
use exid::chain::effect;
use exid::diagnose::residuals::prediction_error::PredictionError;
use exid::diagnose::selection::time_window;
use exid::diagnose::task;
use exid::estimate::covariance::of_unknowns;
use exid::estimate::task as fit;
use exid::problem::solution::Control;
use exid::problem_file::ProblemFile;
use exid::recording::split::Split;
use exid::stats::deviation::rms;
use exid::trials::files::{PROBLEM, prepare};
use exid::trials::plan::{Plan, Scope};
use exid::trials::reference_fits::DeclaredModel;
use std::fs;

/// A trial with a push of half the usual torque from one time (s) to another.
fn pushed(from: f64, to: f64) -> Plan {
    let scope = Scope {
        effects: vec!["external_contact"],
        robots: vec!["arm3"],
        ..Scope::periodic(11)
    };
    let mut plan = Plan::draw(&scope, 0, 0);
    let size = 0.5 * plan.robot.torque[plan.concealed[0].joints()[0]];
    let values = plan.concealed[0].values.iter_mut();
    for ((_, to), value) in values.zip([size, from, to]) {
        *to = value;
    }
    plan
}

#[test]
fn a_push_at_another_time_is_fitted_where_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let [first, second] = ["first", "second"].map(|name| folder.path().join(name));
    let control = Control::default();
    let plan = pushed(4.0, 5.5);
    for (plan, folder) in [(&plan, &first), (&pushed(9.0, 10.2), &second)] {
        fs::create_dir(folder).unwrap();
        prepare(plan, folder, &control).unwrap();
    }
    fs::copy(second.join("validation.csv"), first.join("validation.csv")).unwrap();
    let problem = ProblemFile::read(&first.join(PROBLEM), &[], &effect::ids()).unwrap();
    let run = task::run(&problem, &control, &|_| ()).unwrap();
    let found = &run.diagnosis.findings;
    let words: Vec<&str> = found.iter().map(|f| f.sentence.as_str()).collect();
    assert_eq!(found.len(), 1, "{words:?}");
    assert_eq!(found[0].effect, "external_contact");
    let pushed = plan.robot.name(plan.concealed[0].joints()[0]);
    assert_eq!(found[0].joints, [pushed]);
    assert!(
        found[0].explained_share > 0.9,
        "{}",
        found[0].explained_share
    );
    // Held against the noise of samples: between periods there is the push too.
    for joint in &run.diagnosis.baseline.joints {
        let is_large = joint.lack_of_fit.unwrap() > 10.0;
        assert_eq!(is_large, joint.joint == pushed, "{joint:?}");
    }
    for joint in &run.diagnosis.outcome.joints {
        let left = joint.lack_of_fit.unwrap();
        assert!((0.5..1.8).contains(&left), "{joint:?}");
    }
}

/// A mean over four periods of which one has the push would tell of a quarter of it.
#[test]
fn a_fit_of_what_happens_once_is_of_samples_in_the_order_of_time() {
    let folder = tempfile::tempdir().unwrap();
    let control = Control::default();
    let plan = pushed(4.0, 5.5);
    prepare(&plan, folder.path(), &control).unwrap();
    let joint = plan.robot.name(plan.concealed[0].joints()[0]);
    let effects = r#"["coulomb_friction", "viscous_friction", "external_contact"]"#;
    let values = &plan.concealed[0].values;
    let mut sets = vec![format!("drive.effects_of={{ {joint} = {effects} }}")];
    // When it was is known; how large it was is asked.
    let stated = values.iter().skip(1);
    sets.extend(stated.map(|(name, value)| format!("drive.values.\"{name}\"={value:?}")));
    let problem = ProblemFile::read(&folder.path().join(PROBLEM), &sets, &effect::ids()).unwrap();
    let estimate = fit::run(&problem, &control, |_| ())
        .unwrap()
        .fitted
        .estimate;
    let (name, truth) = &values[0];
    let found = estimate.find(name).unwrap();
    let (value, deviation) = found.value.zip(found.std_dev).unwrap();
    assert!(
        (value - truth).abs() < 4.0 * deviation && deviation < 0.05 * truth.abs(),
        "{value} ± {deviation} in the place of {truth}"
    );
}

/// A model of a trial with its push from one time to another, as fitted.
fn is_shorter(from: f64, to: f64) -> bool {
    let folder = tempfile::tempdir().unwrap();
    let control = Control::default();
    let plan = pushed(from, to);
    prepare(&plan, folder.path(), &control).unwrap();
    let opened = DeclaredModel::read(&folder.path().join(PROBLEM), &control).unwrap();
    let data = opened.data.in_successive_periods();
    let hypothesis = plan.concealed[0].hypothesis.clone();
    let start = plan.concealed[0].values.clone();
    let fit = opened
        .fit(&data, std::slice::from_ref(&hypothesis), &start, &control)
        .unwrap();
    time_window::is_shorter(&opened.context(&data, &control), &fit, &hypothesis)
}

#[test]
fn what_is_there_all_the_time_is_no_push() {
    assert!(is_shorter(4.0, 5.5));
    assert!(!is_shorter(-10.0, 1000.0));
}

/// A complete model that was fitted to a second of motion: what its parameters miss is larger than the noise, and known.
#[test]
fn errors_of_uncertain_parameters_are_foreseen() {
    let folder = tempfile::tempdir().unwrap();
    let control = Control::default();
    let scope = Scope {
        robots: vec!["arm3"],
        ..Scope::periodic(11)
    };
    let mut plan = Plan::draw(&scope, 0, 0);
    plan.concealed.clear();
    plan.known_links = false;
    prepare(&plan, folder.path(), &control).unwrap();
    let opened = DeclaredModel::read(&folder.path().join(PROBLEM), &control).unwrap();
    let short = |r: &Prepared| match r.split {
        Split::Train => r.part(Split::Train, |row| row < 100),
        Split::Validation => r.clone(),
    };
    let data = Dataset {
        recordings: opened.data.recordings.iter().map(short).collect(),
    };
    let fit = opened.fit(&data, &[], &Vec::new(), &control).unwrap();
    let train: Vec<&Prepared> = data.of(Split::Train).collect();
    let covariance = of_unknowns(&fit.problem(&train), &fit.solution.x);
    let context = opened.context(&data, &control);
    let predicted = PredictionError::of(&context, &fit, covariance.as_ref());
    for (c, held_out) in fit.validation.iter().enumerate() {
        let noise = plan.robot.noise[c] / (plan.length.periods as f64).sqrt();
        let (found, foreseen) = (rms(held_out) / noise, predicted.beside(c, noise) / noise);
        assert!(
            foreseen > 1.5,
            "joint {c}: nothing is foreseen beside the noise"
        );
        assert!(
            found < 3.0 * foreseen,
            "joint {c}: {found} found, {foreseen} foreseen"
        );
    }
}
