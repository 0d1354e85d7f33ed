//! A defect that ends a search leaves what was found before it: the panic comes from whoever hears of the progress.

mod common;

use exid::chain::effect;
use exid::diagnose;
use exid::diagnose::stage::Stage;
use exid::estimate;
use exid::problem::solution::{Control, TraceRow};
use exid::problem_file::ProblemFile;
use std::path::Path;

fn problem(path: &str, overrides: &[&str]) -> ProblemFile {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    let overrides: Vec<String> = overrides.iter().map(|o| o.to_string()).collect();
    ProblemFile::read(&path, &overrides, &effect::ids()).unwrap()
}

#[test]
fn a_defect_of_a_diagnosis_leaves_the_findings_before_it() {
    let problem = problem("problems/arm6_gearbox/problem.toml", &[]);
    let fails = |stage| {
        let is_second = matches!(stage, Stage::Searching { found: 1, .. });
        assert!(!is_second, "this search has failed")
    };
    let run = diagnose::task::run(&problem, &Control::default(), &fails).unwrap();
    let words = run.defect.unwrap().to_string();
    assert!(words.contains("this search has failed"), "{words}");
    let diagnosis = &run.diagnosis;
    assert!(
        diagnosis.summary.contains("this search has failed"),
        "{}",
        diagnosis.summary
    );
    assert_eq!(diagnosis.verdict, None);
    let found = &diagnosis.findings[0];
    assert_eq!(found.effect, "transmission_efficiency");
    assert_eq!(found.joints, ["a3"]);
    assert!(
        diagnosis.summary.contains("Not tried yet"),
        "{}",
        diagnosis.summary
    );
}

#[test]
fn a_defect_before_the_first_finding_leaves_the_declared_model() {
    let problem = problem("problems/arm6_gearbox/problem.toml", &[]);
    let fails = |stage| assert!(!matches!(stage, Stage::Searching { found: 0, .. }));
    let run = diagnose::task::run(&problem, &Control::default(), &fails).unwrap();
    assert!(run.defect.is_some());
    let misfit = &run.diagnosis.findings;
    assert!(
        misfit
            .iter()
            .any(|f| f.effect == "unnamed" && f.joints == ["a3"])
    );
    let friction = run.estimate.parameters.iter();
    let mut friction = friction.filter(|p| p.name == "a1.coulomb_friction.Fc");
    assert!(friction.next().unwrap().value.is_some());
}

#[test]
fn a_defect_of_a_fit_leaves_the_point_that_it_began_at() {
    let problem = problem("problems/arm6/problem.toml", &[]);
    let fails = |_: &TraceRow| panic!("this search has failed");
    let control = Control {
        progress: Some(&fails),
        ..Control::default()
    };
    let run = estimate::task::run(&problem, &control, |_| ()).unwrap();
    assert!(run.defect.is_some());
    let estimate = &run.fitted.estimate;
    let solver = estimate.solver.as_ref().unwrap();
    assert_eq!((solver.stop.as_str(), solver.converged), ("defect", false));
    assert!(run.fitted.fit.notes[0].contains("this search has failed"));
    let friction = estimate.parameters.iter();
    let mut friction = friction.filter(|p| p.name == "a1.coulomb_friction.Fc");
    assert!((friction.next().unwrap().value.unwrap() - 9.0).abs() < 0.5);
}
