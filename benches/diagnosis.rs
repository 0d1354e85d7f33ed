//! The whole of `exid diagnose` on a seven-joint arm: every hypothesis on every joint, six periods of 12 s at 200 Hz
//! to fit and as many held out. Nothing, a gear that loses torque, a gear that twists or a gear with play is left out of
//! the declared model; with nothing left out also twice as many periods, to see how the time grows with samples.

use criterion::{Criterion, criterion_group, criterion_main};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use tempfile::TempDir;

const JOINTS: usize = 7;

/// What is left out of the declared model: its name, the effect, and its values on one joint.
const LEFT_OUT: [(&str, &str, &str); 4] = [
    ("nothing", "", ""),
    (
        "transmission_efficiency",
        "joint4 = [\"coulomb_friction\", \"viscous_friction\", \"transmission_efficiency\"]",
        "\"joint4.transmission_efficiency.R\" = 0.85",
    ),
    (
        "joint_elasticity",
        "joint2 = [\"coulomb_friction\", \"viscous_friction\", \"joint_elasticity\"]",
        "\"joint2.joint_elasticity.K\" = 8000.0\n\"joint2.joint_elasticity.D\" = 8.0",
    ),
    (
        "backlash",
        "joint4 = [\"coulomb_friction\", \"viscous_friction\", \"backlash\"]",
        "\"joint4.backlash.gap\" = 0.004",
    ),
];

/// The arm; `tables` follow.
fn problem(effects: &str, tables: &str) -> String {
    let friction: String = (1..=JOINTS)
        .map(|j| format!("\"joint{j}.coulomb_friction.w\" = 0.01\n"))
        .collect();
    format!(
        "name = \"seven_joints\"\n[robot]\nmdh = \"panda_like.mdh.toml\"\n[drive]\n\
         effects = [\"coulomb_friction\", \"viscous_friction\"]\n\
         rotor_inertia = [0.6, 0.6, 0.5, 0.5, 0.2, 0.2, 0.15]\n[drive.values]\n{friction}\
         [drive.effects_of]\n{effects}\n[recordings]\nsignal = \"torque\"\nrate = 200.0\nperiod = 12.0\n{tables}"
    )
}

/// What is recorded.
fn truth(effects: &str, values: &str, periods: usize) -> String {
    let friction: String = (1..=JOINTS)
        .map(|j| format!("\"joint{j}.Fc\" = 1.{j}\n\"joint{j}.Fv\" = 1.{j}\n"))
        .collect();
    let simulate = format!(
        "train = [\"train.csv\"]\n[simulate]\ntrajectory = \"random\"\nperiods = {periods}\n\
         noise = [0.3, 0.3, 0.3, 0.3, 0.1, 0.1, 0.1]\n[simulate.values]\n{friction}{values}\n"
    );
    problem(effects, &simulate)
}

fn exid(folder: &Path, arguments: &[&str]) {
    let status = Command::new(env!("CARGO_BIN_EXE_exid"))
        .current_dir(folder)
        .args(arguments)
        .arg("--quiet")
        .stdout(Stdio::null())
        .status()
        .expect("the program starts");
    assert!(status.success(), "{arguments:?}");
}

/// A folder with recordings and the declared model.
fn recorded((effects, values): (&str, &str), periods: usize) -> TempDir {
    let folder = TempDir::new().expect("a folder for the recordings");
    let at = folder.path();
    let robot =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/panda_like/panda_like.mdh.toml");
    fs::copy(robot, at.join("panda_like.mdh.toml")).expect("the robot is copied");
    fs::write(at.join("truth.toml"), truth(effects, values, periods)).expect("a problem file");
    let files = "train = [\"1/train.csv\"]\nvalidation = [\"2/train.csv\"]\n";
    fs::write(at.join("declared.toml"), problem("", files)).expect("a problem file");
    for seed in ["1", "2"] {
        exid(
            at,
            &["simulate", "truth.toml", "--seed", seed, "--out", seed],
        );
    }
    folder
}

fn diagnosis(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("diagnosis");
    group.sample_size(10);
    let mut measure = |name: &str, truth: (&str, &str), periods: usize| {
        let folder = recorded(truth, periods);
        let diagnose = || exid(folder.path(), &["diagnose", "declared.toml"]);
        group.bench_function(name, |bencher| bencher.iter(diagnose));
    };
    for (name, effects, values) in LEFT_OUT {
        measure(name, (effects, values), 6);
    }
    measure("nothing, 12 periods", ("", ""), 12);
    group.finish();
}

criterion_group!(benches, diagnosis);
criterion_main!(benches);
