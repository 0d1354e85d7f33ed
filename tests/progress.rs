//! Whoever waits for a run hears how much of it is done where that can be counted.

use exid::problem_file::ProblemFile;
use exid::verb::Verb;
use exid::verb::settings::{OnMistakes, Settings};
use std::path::Path;
use std::sync::Mutex;
use std::time::Instant;

/// Everything that a run of a shipped problem says.
fn heard(verb: Verb, name: &str, set: &[&str]) -> Vec<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("problems/{name}/problem.toml"));
    let set: Vec<String> = set.iter().map(|key| (*key).to_owned()).collect();
    let problem = ProblemFile::read(&path, &set, &exid::chain::effect::ids()).unwrap();
    let heard = Mutex::new(Vec::new());
    let settings = Settings {
        seed: 1,
        on_mistakes: OnMistakes::Refuse,
        interrupt: None,
        progress: &|step| heard.lock().unwrap().push(step.to_owned()),
        command: Vec::new(),
        started: Instant::now(),
    };
    verb.run(&problem, &settings).unwrap();
    heard.into_inner().unwrap()
}

#[test]
fn recordings_and_hypotheses_are_counted_with_the_time_that_is_left() {
    let has = |heard: &[String], parts: [&str; 2]| {
        heard
            .iter()
            .any(|words| parts.iter().all(|part| words.contains(part)))
    };
    let read = "looking for mistakes in the inputs: 1 of 2, about";
    let fit = heard(Verb::Fit, "arm6", &[]);
    assert!(has(&fit, [read, " left"]), "{fit:?}");
    let simulate = heard(Verb::Simulate, "arm6", &[]);
    assert!(
        has(&simulate, ["simulating recordings: 1 of 2, about", " left"]),
        "{simulate:?}"
    );
    let diagnose = heard(Verb::Diagnose, "arm6_gearbox", &[]);
    let tried = ["hypotheses of what is missing (0 found so far): ", " left"];
    assert!(has(&diagnose, tried), "{diagnose:?}");
}
