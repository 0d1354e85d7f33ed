//! Samples that do not come evenly, and periods that hold no whole number of them: every signal is compared with the model at its own
//! time, for interpolation would smear what friction does at a reversal.

mod common;

use common::program::says;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Friction of `problems/arm6`, N·m and N·m·s/rad, and the transition speed that `exid simulate` has by default, rad/s.
const COULOMB: [f64; 6] = [9.0, 11.0, 7.0, 3.0, 2.6, 2.1];
const VISCOUS: [f64; 6] = [11.7, 14.3, 9.1, 3.9, 3.4, 2.7];
const SPEED: f64 = 0.004;

/// Of 36 intervals of 95 % fewer than this share hold the truth by chance once in five hundred runs (binomial).
const LEAST_HELD: f64 = 0.82;

/// Writes the problem of the arm into a folder, with these keys in the place of others, simulated with a seed.
fn simulated(folder: &Path, changed: &[(&str, &str)], seed: &str) {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/arm6");
    fs::copy(shipped.join("arm6.urdf"), folder.join("arm6.urdf")).unwrap();
    let mut problem = fs::read_to_string(shipped.join("problem.toml")).unwrap();
    problem = problem.replace(".csv.gz", ".csv");
    for (old, new) in changed {
        assert!(problem.contains(old), "{old}");
        problem = problem.replace(old, new);
    }
    fs::write(folder.join("problem.toml"), problem).unwrap();
    let arguments = [
        "simulate",
        "problem.toml",
        "--seed",
        seed,
        "--out",
        "recorded",
        "--quiet",
    ];
    says(folder, &arguments, 0);
}

/// Keeps the samples of a recording that come after 5 or 6 others, in an order without a pattern.
fn thin(path: &Path) {
    let text = fs::read_to_string(path).unwrap();
    let (header, rows) = text.split_once('\n').unwrap();
    let mut kept = vec![header];
    let (mut next, mut state) = (0_usize, 1_u32);
    for (k, row) in rows.lines().enumerate() {
        if k == next {
            kept.push(row);
            // Numerical Recipes' linear congruential generator.
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            next = k + 5 + (state >> 31) as usize;
        }
    }
    fs::write(path, kept.join("\n")).unwrap();
}

fn thin_both(folder: &Path) {
    for file in ["train.csv", "validation.csv"] {
        thin(&folder.join("recorded").join(file));
    }
}

/// The result of a verb that finds by itself how the recordings were taken; it is in a folder of that name.
fn result_of(folder: &Path, verb: &str, options: &[&str]) -> Value {
    let problem = fs::read_to_string(folder.join("problem.toml")).unwrap();
    let stated = |line: &&str| line.starts_with("rate = ") || line.starts_with("period = ");
    let lines: Vec<&str> = problem.lines().filter(|line| !stated(line)).collect();
    let recorded = lines
        .join("\n")
        .replace("\"train.csv", "\"recorded/train.csv")
        .replace("\"validation.csv", "\"recorded/validation.csv");
    fs::write(folder.join("recorded.toml"), recorded).unwrap();
    printed(
        folder,
        &[&[verb, "recorded.toml", "--out", verb], options].concat(),
    )
}

/// What a command prints as JSON.
fn printed(folder: &Path, arguments: &[&str]) -> Value {
    let text = says(folder, &[arguments, &["--json"]].concat(), 0);
    serde_json::from_str(&text[..=text.rfind('}').unwrap()]).unwrap()
}

/// Share of the intervals of friction of a fit that hold the truth.
fn held(result: &Value) -> f64 {
    let (mut held, mut count) = (0, 0);
    for parameter in result["parameters"].as_array().unwrap() {
        let name = parameter["name"].as_str().unwrap();
        let joint = || name[1..2].parse::<usize>().unwrap() - 1;
        let truth = match name.rsplit('.').next() {
            Some("Fc") => COULOMB[joint()],
            Some("Fv") => VISCOUS[joint()],
            Some("w") => SPEED,
            _ => continue,
        };
        let bound = |k: usize| parameter["ci95"][k].as_f64().unwrap();
        held += i32::from((bound(0)..=bound(1)).contains(&truth));
        count += 1;
    }
    assert_eq!(count, 18);
    f64::from(held) / f64::from(count)
}

fn of_seeds(changed: &[(&str, &str)], after: impl Fn(&Path)) -> f64 {
    let shares = ["1", "2"].map(|seed| {
        let folder = tempfile::tempdir().unwrap();
        simulated(folder.path(), changed, seed);
        after(folder.path());
        held(&result_of(folder.path(), "fit", &[]))
    });
    shares.iter().sum::<f64>() / shares.len() as f64
}

#[test]
fn intervals_hold_where_a_period_is_no_whole_number_of_samples() {
    let share = of_seeds(&[("period = 12.0", "period = 12.0037")], |_| ());
    assert!(share >= LEAST_HELD, "{share}");
}

/// Sum over six joints of the median error of position after 0.1 s, rad. With mean steps in the place of those between the stamps it
/// is 10 mrad, and with these 3.4, which is what the noise of the torques alone leaves.
const OF_ROLLOUTS: f64 = 5e-3;

#[test]
fn rollouts_go_from_sample_to_sample_by_their_stamps() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    simulated(folder, &[("rate = 125.0", "rate = 500.0")], "1");
    thin_both(folder);
    result_of(folder, "fit", &[]);
    let result = printed(folder, &["rollout", "fit", "--out", "rollout"]);
    let joints = result["horizons"][0]["joints"].as_array().unwrap();
    let errors = joints
        .iter()
        .map(|j| j["after"]["median"].as_f64().unwrap());
    let sum: f64 = errors.sum();
    let noise = joints
        .iter()
        .map(|j| j["noise"]["median"].as_f64().unwrap());
    eprintln!("{sum:.5} rad, of noise {:.5}", noise.sum::<f64>());
    assert!(sum < OF_ROLLOUTS, "{sum}");
}

#[test]
fn intervals_hold_where_samples_come_after_10_or_12_ms() {
    let share = of_seeds(&[("rate = 125.0", "rate = 500.0")], thin_both);
    assert!(share >= LEAST_HELD, "{share}");
}

/// Samples for themselves are noisier than averages: away from reversals this delay shows by less than half of their noise.
#[test]
fn a_delay_that_moves_reversals_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let listed = "[drive.effects_of]\na2 = [\"coulomb_friction\", \"viscous_friction\", \"torque_offset\", \"time_delay\"]\n";
    let changed = [
        ("period = 12.0", "period = 12.0037"),
        ("[recordings]\n", &format!("{listed}[recordings]\n")),
        (
            "[simulate.values]\n",
            "[simulate.values]\n\"a2.time_delay.delay\" = 0.012\n",
        ),
    ];
    simulated(folder, &changed, "7");
    let problem = folder.join("problem.toml");
    let declared = fs::read_to_string(&problem).unwrap().replace(listed, "");
    fs::write(&problem, declared).unwrap();
    let sought = ["--set", "diagnose.effects=[\"time_delay\"]"];
    let result = result_of(folder, "diagnose", &sought);
    let found: Vec<&Value> = result["findings"].as_array().unwrap().iter().collect();
    assert_eq!(found.len(), 1, "{}", result["summary"]);
    assert_eq!(found[0]["effect"], "time_delay");
    assert_eq!(found[0]["joints"], serde_json::json!(["a2"]));
}
