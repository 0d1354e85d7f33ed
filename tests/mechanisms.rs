//! Robots with closed loops, fitted by the program: the parallel robot H4 at published parameters, and a linkage from
//! a URDF with the joint that closes it. Recordings of both are made without exid: see their `make.py`.

use exid::chain::evaluate::{Evaluator, Segment};
use exid::chain::forward::{Accuracy, Driven, Forward};
use exid::outcome::predictions::{Predictions, Quantity};
use exid::problem_file::ProblemFile;
use exid::robot::batch::Trajectory;
use exid::setup;
use exid::setup::model_spec::ModelSpec;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn shipped(problem: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("problems")
        .join(problem)
}

fn run(verb: &str, problem: &Path) -> Output {
    run_with(verb, problem, &[])
}

fn run_with(verb: &str, problem: &Path, further: &[&str]) -> Output {
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_exid"));
    command.current_dir(folder.path()).arg(verb).arg(problem);
    command.args(["--json", "--out", "out"]).args(further);
    command.output().unwrap()
}

fn fit(problem: &str) -> Value {
    let output = run("fit", &shipped(problem));
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{words}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Table 3 of the paper: what the recordings are made with, and its relative standard deviations in percent.
const TABLE_3: [(&str, f64, f64); 14] = [
    ("motor1.rotor_inertia.Jm", 0.0167, 2.3695),
    ("motor2.rotor_inertia.Jm", 0.0164, 2.3590),
    ("motor3.rotor_inertia.Jm", 0.0176, 1.5776),
    ("motor4.rotor_inertia.Jm", 0.0234, 1.1579),
    ("nacelle.mass", 0.984, 0.4666),
    ("nacelle.inertia_zz", 0.0029, 3.7311),
    ("motor1.viscous_friction.Fv", 0.2112, 4.7212),
    ("motor2.viscous_friction.Fv", 0.1236, 7.5670),
    ("motor3.viscous_friction.Fv", 0.1266, 5.2000),
    ("motor4.viscous_friction.Fv", 0.1133, 5.6255),
    ("motor1.coulomb_friction.Fc", 1.2186, 2.0756),
    ("motor2.coulomb_friction.Fc", 1.0252, 2.3623),
    ("motor3.coulomb_friction.Fc", 0.7902, 2.7986),
    ("motor4.coulomb_friction.Fc", 1.0394, 2.1046),
];

fn parameter(result: &Value, name: &str) -> (f64, f64) {
    let all = result["parameters"].as_array().unwrap();
    let found = all.iter().find(|p| p["name"] == name);
    let found = found.unwrap_or_else(|| panic!("no {name}"));
    let number = |key: &str| found[key].as_f64().unwrap_or_else(|| panic!("{found}"));
    (number("value"), number("std_dev"))
}

#[test]
fn recovers_known_truth_of_the_published_parallel_robot() {
    for problem in ["h4_parallel/problem.toml", "h4_parallel/sensors.toml"] {
        let result = fit(problem);
        assert_eq!(result["rank"], 14);
        let mut ratios = Vec::new();
        for (name, truth, published) in TABLE_3 {
            let (value, sd) = parameter(&result, name);
            let relative = 100.0 * sd / value;
            eprintln!(
                "{problem} {name}: {value:.5} for {truth}, {relative:.2} % (published {published} %)"
            );
            assert!(
                (value - truth).abs() < 3.0 * sd,
                "{name}: {value} ± {sd} for {truth}"
            );
            ratios.push((relative / published).ln());
        }
        // The noise of the recordings is such that the paper's accuracy comes out, within a factor of two on the
        // whole.
        let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
        assert!(mean.abs() < f64::ln(2.0), "{mean}");
        for joint in result["joints"].as_array().unwrap() {
            // Fig. 5: another motion is predicted as well as the one that was fitted.
            let [train, held_out] =
                ["rmse_train", "rmse_validation"].map(|key| joint[key].as_f64().unwrap());
            assert!(held_out < 1.3 * train, "{joint}");
        }
    }
}

/// Table 1: the gains of the amplifiers, from the force at the platform while it is clamped.
#[test]
fn recovers_known_gains_from_the_static_force() {
    let result = fit("h4_parallel/gains.toml");
    for (motor, truth) in [2.85, 2.65, 2.70, 2.87].into_iter().enumerate() {
        let name = format!("motor{}.drive_gain.gain", motor + 1);
        let (value, sd) = parameter(&result, &name);
        eprintln!("{name}: {value:.4} ± {sd:.4} for {truth}");
        assert!((value - truth).abs() < 3.0 * sd, "{name}: {value} ± {sd}");
        // What ten steps of every level leave of a tenth of Coulomb friction, evenly spread: 0.4 %.
        assert!(sd < 0.006 * truth, "{name}: {value} ± {sd}");
    }
    // At rest an inertia shows nothing.
    let all = result["parameters"].as_array().unwrap();
    let inertia = all
        .iter()
        .find(|p| p["name"] == "nacelle.inertia_zz")
        .unwrap();
    assert_eq!(inertia["source"], "undetermined", "{inertia}");
}

#[test]
fn recovers_known_truth_of_a_linkage() {
    let result = fit("parallelogram/problem.toml");
    // Two inertias, two couplings, four weights; two frictions for each motor.
    assert_eq!(result["rank"], 8 + 4);
    let ids = exid::chain::effect::ids();
    let problem = ProblemFile::read(&shipped("parallelogram/problem.toml"), &[], &ids).unwrap();
    let robot = setup::robot::open(&problem).unwrap();
    let model = ModelSpec::without_prior(&problem, &robot)
        .unwrap()
        .build()
        .unwrap()
        .model;
    let mut truth = model.tree().parameters();
    truth.resize(model.parameters().len(), 0.0);
    for (name, value) in [
        ("shoulder.coulomb_friction.Fc", 6.0),
        ("lift.coulomb_friction.Fc", 4.0),
        ("shoulder.viscous_friction.Fv", 9.0),
        ("lift.viscous_friction.Fv", 7.0),
    ] {
        truth[model.find(name).unwrap()] = value;
    }
    let posterior = &result["posterior"];
    let combinations = posterior["combinations"].as_array().unwrap();
    for (k, combination) in combinations.iter().enumerate() {
        let terms = combination["terms"].as_array().unwrap();
        let of = |term: &Value| {
            let position = model.find(term["parameter"].as_str().unwrap()).unwrap();
            term["coefficient"].as_f64().unwrap() * truth[position]
        };
        let expected: f64 = terms.iter().map(of).sum();
        let value = combination["value"].as_f64().unwrap();
        let sd = posterior["covariance"][k][k].as_f64().unwrap().sqrt();
        // A share of 1e-4 of truths lies further from an honest estimate: 12 of them.
        assert!(
            (value - expected).abs() < 4.0 * sd,
            "{}: {value} ± {sd} for {expected}",
            terms[0]["parameter"]
        );
    }
}

#[test]
fn positions_that_the_mechanism_cannot_have_are_refused_with_their_time() {
    let folder = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(shipped("h4_parallel/problem.toml")).unwrap();
    let bad = text
        .replace("train.csv.gz", "bad.csv")
        .replace("validation = [\"validation.csv.gz\"]", "");
    fs::write(folder.path().join("problem.toml"), bad).unwrap();
    let mut rows = "t,q1,q2,q3,q4,v1,v2,v3,v4\n".to_string();
    for k in 0..1000 {
        let t = f64::from(k) / 500.0;
        // Degrees where radians belong.
        let q = 30.0 + 10.0 * (2.0 * t).sin();
        rows.push_str(&format!("{t},{q},{q},{q},{q},0,0,0,0\n"));
    }
    fs::write(folder.path().join("bad.csv"), rows).unwrap();
    let problem = folder.path().join("problem.toml");
    let output = run("fit", &problem);
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{words}");
    assert!(words.contains("[position-in-degrees]"), "{words}");
    let output = run_with("fit", &problem, &["--force"]);
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{words}");
    assert!(
        words.contains("t = ") && words.contains("against the mechanism"),
        "{words}"
    );
}

#[test]
fn faults_of_a_mechanism_name_the_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(shipped("h4_parallel/problem.toml")).unwrap();
    let cases = [
        ("rod = 0.48 ", "rot = 0.48 ", "its lengths are lever, rod"),
        ("rod = 0.48 ", "rod = \"a\" ", "`rod` wants a number"),
        ("rod = 0.48 ", "rod = 0.1 ", "workspace"),
        (
            "[recordings.differentiation]",
            "[recordings.sensors]\nmotor1 = { acceleration = \"ax\" }\n[recordings.differentiation]",
            "nacelle_x",
        ),
    ];
    for (from, to, expected) in cases {
        let absolute = format!("\"{}/", shipped("h4_parallel").display());
        let text = text
            .replace(from, to)
            .replace("[\"", &format!("[{absolute}"));
        let text = text.replace(&format!("zero = [{absolute}"), "zero = [\"");
        let text = text.replace(&format!("effects = [{absolute}"), "effects = [\"");
        let path = folder.path().join("problem.toml");
        fs::write(&path, text).unwrap();
        let output = run("fit", &path);
        let words = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{words}");
        assert!(words.contains(expected), "{words}");
    }
}

/// Largest distance of the motors from a motion of half a second about home, under the torques that the chain gives along it
/// at a rate.
fn distance_of_forward(problem: &str, rate: f64) -> f64 {
    let ids = exid::chain::effect::ids();
    let problem = ProblemFile::read(&shipped(problem), &[], &ids).unwrap();
    let robot = setup::robot::open(&problem).unwrap();
    let mut model = ModelSpec::without_prior(&problem, &robot)
        .unwrap()
        .build()
        .unwrap()
        .model;
    for p in 0..model.parameters().len() {
        let (name, scale) = (
            model.parameters()[p].name.clone(),
            model.parameters()[p].scale,
        );
        // Wide friction is smooth, and rotors and a platform give the joints that have no mass in the file one.
        let value = match name.rsplit('.').next() {
            Some("w") => 0.3,
            Some("Jm") => 0.02,
            Some("m") if name.starts_with("nacelle") => 1.0,
            Some("Izz") if name.starts_with("nacelle") => 0.003,
            Some("Fc" | "Fv") => scale,
            _ => continue,
        };
        let _ = model.fix(p, value);
    }
    let values = model.values();
    let mechanism = model.mechanism().unwrap();
    let rows = (0.5 * rate) as usize + 1;
    let n = model.joints().len();
    let mut motion: [Vec<Vec<f64>>; 3] = [0, 1, 2].map(|_| vec![vec![0.0; rows]; n]);
    for (m, &j) in mechanism.actuated().iter().enumerate() {
        let (w, a) = (std::f64::consts::TAU * (0.6 + 0.3 * m as f64), 0.1);
        for k in 0..rows {
            let (sine, cosine) = (w * k as f64 / rate + m as f64).sin_cos();
            motion[0][j][k] = mechanism.home()[j] + a * sine;
            motion[1][j][k] = a * w * cosine;
            motion[2][j][k] = -a * w * w * sine;
        }
    }
    let parts = motion.each_mut().map(Vec::as_mut_slice);
    mechanism.complete_motion(parts, 0..rows).unwrap();
    let [q, dq, ddq] = &motion;
    let mut evaluator = Evaluator::along(&model, &values, &[], rows);
    let block = evaluator.evaluate_whole(Segment::states(Trajectory { q, dq, ddq }, false));
    let mut forward = Forward::new(&model, &values, false, Accuracy::default()).unwrap();
    let motors = forward.motors().to_vec();
    let at =
        |series: &[Vec<f64>], k: usize| motors.iter().map(|&j| series[j][k]).collect::<Vec<_>>();
    let torque = |k: usize| -> Vec<f64> {
        let signals: Vec<f64> = motors.iter().map(|&j| block.value(j)[k]).collect();
        forward.motor_torques(&signals)
    };
    let torques: Vec<Vec<f64>> = (0..rows).map(torque).collect();
    forward.hold(&at_all(q, 0));
    forward.close_near(|joint| q[joint][0]);
    let mut state = forward.settled(&at(q, 0), &at(dq, 0));
    let mut most = 0.0_f64;
    for k in 0..rows - 1 {
        let driven = Driven::Torque {
            from: &torques[k],
            to: &torques[k + 1],
        };
        forward.advance(&mut state, driven, 1.0 / rate).unwrap();
        let pairs = state.position.iter().zip(at(q, k + 1));
        most = pairs.fold(most, |most, (x, q)| most.max((x - q).abs()));
    }
    most
}

fn at_all(series: &[Vec<f64>], k: usize) -> Vec<f64> {
    series.iter().map(|s| s[k]).collect()
}

#[test]
fn invariant_torques_of_a_mechanism_lead_along_its_motion() {
    for problem in ["parallelogram/problem.toml", "h4_parallel/problem.toml"] {
        let [coarse, fine] = [1000.0, 2000.0].map(|rate| distance_of_forward(problem, rate));
        eprintln!("{problem}: {coarse:.1e} rad at 1000 Hz, {fine:.1e} at 2000 Hz");
        // Torques that are linear between samples, and steps of order two: a quarter at twice the rate.
        assert!(
            fine < 0.35 * coarse && fine < 1e-5,
            "{problem}: {coarse} {fine}"
        );
    }
}

/// Runs `exid` in a folder and gives what it says, which has to end well.
fn said(folder: &Path, arguments: &[&str]) -> Value {
    let mut command = Command::new(env!("CARGO_BIN_EXE_exid"));
    command.current_dir(folder).args(arguments).arg("--json");
    let output = command.output().unwrap();
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {words}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The linkage with values for what acts in it, in a folder of its own.
fn linkage(folder: &Path, simulate: &str) -> PathBuf {
    let text = fs::read_to_string(shipped("parallelogram/problem.toml")).unwrap();
    let (text, _) = text.split_once("[simulate]").unwrap();
    // Forward dynamics wants friction that does not jump, and a fit of it the width.
    let text = text.replace(".w\" = 0.0", ".w\" = 0.01");
    let values = "[simulate.values]\n\"shoulder.coulomb_friction.Fc\" = 6.0\n\"lift.coulomb_friction.Fc\" = 4.0\n\
                  \"shoulder.viscous_friction.Fv\" = 9.0\n\"lift.viscous_friction.Fv\" = 7.0\n";
    let text = format!("{text}\n[simulate]\nnoise = [0.3, 0.2]\n{simulate}\n{values}");
    let robot = shipped("parallelogram/parallelogram.urdf");
    fs::copy(robot, folder.join("parallelogram.urdf")).unwrap();
    let path = folder.join("problem.toml");
    fs::write(&path, text).unwrap();
    path
}

#[test]
fn recovers_known_truth_of_a_linkage_that_is_simulated() {
    for mode in ["inverse", "closed_loop"] {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        linkage(folder, &format!("mode = \"{mode}\""));
        said(
            folder,
            &["simulate", "problem.toml", "--seed", "31", "--out", "made"],
        );
        let places = [
            "recordings.train=[\"made/train.csv.gz\"]",
            "recordings.validation=[\"made/validation.csv.gz\"]",
        ];
        let fit = [
            "fit",
            "problem.toml",
            "--set",
            places[0],
            "--set",
            places[1],
        ];
        let result = said(folder, &[&fit[..], &["--out", "fit"]].concat());
        for (name, truth) in [
            ("shoulder.coulomb_friction.Fc", 6.0),
            ("lift.coulomb_friction.Fc", 4.0),
            ("shoulder.viscous_friction.Fv", 9.0),
            ("lift.viscous_friction.Fv", 7.0),
        ] {
            let (value, sd) = parameter(&result, name);
            eprintln!("{mode}: {name} = {value:.3} ± {sd:.3}, {truth}");
            // A share of 1e-4 of truths lies further from an honest estimate: eight of them.
            assert!(
                (value - truth).abs() < 4.0 * sd,
                "{mode} {name}: {value} ± {sd} for {truth}"
            );
        }
    }
}

/// In a parallelogram the angles of joints without a motor are differences of those of the motors.
#[test]
fn predictions_have_the_motion_of_joints_without_a_motor() {
    let folder = tempfile::tempdir().unwrap();
    let problem = shipped("parallelogram/problem.toml");
    let arguments = ["fit", problem.to_str().unwrap(), "--out", "fit"];
    said(folder.path(), &arguments);
    let table = Predictions::read(&folder.path().join("fit/predictions.csv")).unwrap();
    let recording = &table.recordings[0];
    for quantity in [Quantity::Position, Quantity::Velocity] {
        let [shoulder, lift, elbow, coupling] = ["shoulder", "lift", "elbow", "coupling"]
            .map(|joint| &recording.values[table.column(joint, quantity).unwrap()]);
        for k in 0..recording.t.len() {
            let expected = lift[k] - shoulder[k];
            let error = (elbow[k] - expected)
                .abs()
                .max((coupling[k] + expected).abs());
            // Ten digits of numbers up to 3.
            assert!(
                error < 5e-9,
                "{quantity:?} at {} s: {error:e}",
                recording.t[k]
            );
        }
    }
    assert!(table.column("elbow", Quantity::Acceleration).is_some());
    assert!(table.column("elbow", Quantity::Recorded).is_none());
}

#[test]
fn a_linkage_is_diagnosed_rolled_out_and_exported() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let problem = shipped("parallelogram/problem.toml");
    let found = said(
        folder,
        &["diagnose", problem.to_str().unwrap(), "--out", "found"],
    );
    assert_eq!(
        found["findings"].as_array().map(Vec::len),
        Some(0),
        "{found}"
    );
    let page = fs::read_to_string(folder.join("found/report.html")).unwrap();
    for drawn in ["\"closures\":[{\"ends\":", "\"postures\":{\"t\":"] {
        assert!(
            page.contains(drawn),
            "the report draws the linkage: {drawn}"
        );
    }
    let rolled = said(folder, &["rollout", "found", "--out", "rolled"]);
    assert!(!rolled["horizons"].as_array().unwrap().is_empty());
    for format in ["urdf", "mjcf", "toml"] {
        let out = ["export", "found", "--to", format, "--out", format];
        let mut command = Command::new(env!("CARGO_BIN_EXE_exid"));
        let output = command.current_dir(folder).args(out).output().unwrap();
        let words = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{format}: {words}");
    }
    let model = fs::read_dir(folder.join("mjcf"))
        .unwrap()
        .next()
        .unwrap()
        .unwrap();
    let text = fs::read_to_string(model.path()).unwrap();
    assert_eq!(text.matches("<connect ").count(), 2, "{text}");
    let mut command = Command::new(env!("CARGO_BIN_EXE_exid"));
    let rust = ["export", "found", "--to", "rust", "--out", "rust"];
    let output = command.current_dir(folder).args(rust).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("close loops"));
}

/// Its motion does not repeat, and its rows are behind a filter: white noise of the samples is what is left of it there.
#[test]
fn the_noise_of_samples_attests_what_a_filter_leaves() {
    let folder = tempfile::tempdir().unwrap();
    let problem = shipped("h4_parallel/problem.toml");
    let asked = ["diagnose", problem.to_str().unwrap(), "--out", "found"];
    let found = said(folder.path(), &asked);
    assert_eq!(found["verdict"], "nothing_missing", "{found}");
    for joint in found["final"]["joints"].as_array().unwrap() {
        // The errors of differentiation are counted as if nothing filtered them.
        let lack = joint["lack_of_fit"].as_f64().unwrap();
        assert!((0.6..1.1).contains(&lack), "{joint}");
    }
}

#[test]
fn designs_of_a_linkage_keep_its_limits_and_beat_chance() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    linkage(folder, "");
    let settings = [
        "--set",
        "design.starts=1",
        "--set",
        "design.harmonics=3",
        "--seed",
        "3",
    ];
    let design = ["design", "problem.toml", "--out", "design"];
    let result = said(folder, &[&design[..], &settings].concat());
    let margins = result["worst_margins"].as_array().unwrap();
    assert!(
        margins
            .iter()
            .any(|m| m["constraint"] == "distance from a singularity"),
        "{result}"
    );
    for margin in margins {
        assert!(margin["relative"].as_f64().unwrap() > -1e-6, "{margin}");
    }
    let trajectory = fs::read_to_string(folder.join("design/trajectory.csv")).unwrap();
    let mut lines = trajectory.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let [elbow, shoulder, lift] = ["q_elbow", "q_shoulder", "q_lift"]
        .map(|name| header.iter().position(|h| *h == name).unwrap());
    for line in lines {
        let row: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        // The coupler keeps the forearm parallel to the crank, whose tilts are absolute.
        assert!(
            (row[elbow] - (row[lift] - row[shoulder])).abs() < 1e-9,
            "{line}"
        );
    }
}
