//! Effects that belong to one recording: a push in the held-out recording at another time than in the fitted one.

use exid::chain::effect;
use exid::diagnose::task;
use exid::problem::solution::Control;
use exid::problem_file::ProblemFile;
use exid::trials::plan::{Plan, Scope};
use exid::trials::run::{PROBLEM, prepare};
use std::fs;

/// A trial with a push of half the usual torque from one time (s) to another.
fn pushed(from: f64, to: f64) -> Plan {
    let scope = Scope {
        effects: vec!["external_contact"],
        robots: vec!["arm3"],
        ..Scope::periodic(11)
    };
    let mut plan = Plan::draw(&scope, (0, 0));
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
