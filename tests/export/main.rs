//! Exports of a robot give its torques: read back, compiled, or loaded by the simulators they are for.
//!
//! The reference is the measurement chain itself, at states without symmetry.

mod code;
#[path = "../common/mod.rs"]
mod common;
mod drives;
mod loops;
mod mujoco;

use exid::chain::evaluate::{Evaluator, Segment};
use exid::chain::model::Model;
use exid::chain::parameter::Role;
use exid::export::table::Table;
use exid::export::{Export, Format, export};
use exid::outcome::estimate::Estimate;
use exid::outcome::fit::Fit;
use exid::outcome::machine::Machine;
use exid::outcome::provenance::Provenance;
use exid::outcome::run::Run;
use exid::outcome::{Outcome, Part};
use exid::problem::solution::Control;
use exid::problem_file::ProblemFile;
use exid::robot::batch::Trajectory;
use exid::robot::newton_euler::NewtonEuler;
use exid::robot::random::{body, generator, symmetric};
use exid::robot::tree::Tree;
use exid::setup;
use exid::setup::model_spec::ModelSpec;
use nalgebra::DVector;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// Promised difference of torques, relative to the largest: decimals read back exactly, and what is left is
/// the rounding of some thousand operations in another order.
const TORQUES: f64 = 1e-9;

/// Promised difference from simulators, which turn frames into quaternions and tensors into principal axes.
const SIMULATORS: f64 = 1e-8;

const STATES: usize = 16;

/// A robot with its drives at values without symmetry, in a folder of its own.
struct Case {
    folder: TempDir,
    model: Model,
    values: DVector<f64>,
    outcome: Outcome,
}

/// Motion of every joint: `[order][joint][state]`.
type Motion = [Vec<Vec<f64>>; 3];

impl Case {
    fn new(robot: &str, problem: &str, seed: u64) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(robot);
        let name = file.file_name().unwrap();
        fs::copy(&file, folder.path().join(name)).unwrap();
        let path = folder.path().join("problem.toml");
        fs::write(&path, problem).unwrap();
        let (problem, robot, model) = open(&path);
        let values = drawn_values(&model, seed);
        let declared = ModelSpec::without_prior(&problem, &robot).unwrap();
        let machine = setup::machine::record(&declared, &robot, &model, &values, None);
        Self {
            folder,
            model,
            values,
            outcome: outcome(machine),
        }
    }

    fn machine(&self) -> &Machine {
        self.outcome.machine().unwrap()
    }

    /// Writes an export into the folder; gives it with the path of its first file.
    fn export(&self, format: Format) -> (Export, PathBuf) {
        let export = export(&self.outcome, format).unwrap();
        for file in &export.files {
            fs::write(self.folder.path().join(&file.name), &file.text).unwrap();
        }
        let first = self.folder.path().join(&export.files[0].name);
        (export, first)
    }

    fn signal(&self, motors: &Motion, loaded: bool) -> Vec<Vec<f64>> {
        signal(&self.model, &self.values, motors, loaded)
    }

    /// `q = V m + offset` and its derivatives.
    fn joints(&self, motors: &Motion) -> Motion {
        let coupling = self.model.coupling(&self.values);
        let mut joints = motors.clone();
        for (order, series) in joints.iter_mut().enumerate() {
            for state in 0..STATES {
                let moved = DVector::from_fn(series.len(), |j, _| motors[order][j][state]);
                let moved = &coupling * moved;
                for (j, joint) in series.iter_mut().enumerate() {
                    let offset = if order == 0 {
                        self.model.offset()[j]
                    } else {
                        0.0
                    };
                    joint[state] = moved[j] + offset;
                }
            }
        }
        joints
    }
}

fn open(path: &Path) -> (ProblemFile, setup::robot::Robot, Model) {
    let ids = exid::chain::effect::ids();
    let problem = ProblemFile::read(path, &[], &ids).unwrap_or_else(|e| panic!("{e}"));
    let robot = setup::robot::open(&problem).unwrap_or_else(|e| panic!("{e}"));
    let declared = ModelSpec::without_prior(&problem, &robot);
    let built = declared.and_then(|declared| declared.build());
    let model = built.unwrap_or_else(|e| panic!("{e}")).model;
    (problem, robot, model)
}

/// Known bodies as they are, a load, and parameters of effects near their typical values.
fn drawn_values(model: &Model, seed: u64) -> DVector<f64> {
    let mut rng = generator(seed);
    let mut values = model.values();
    for (value, parameter) in values.iter_mut().zip(model.parameters()) {
        if let (Role::Effect { .. }, true) = (parameter.role, parameter.is_free()) {
            *value = parameter.scale * (1.0 + symmetric(&mut rng, 0.5));
        }
    }
    if let Some((_, first)) = model.payload() {
        let load = body(&mut rng);
        values.as_mut_slice()[first..first + 10].copy_from_slice(&load.0);
    }
    values
}

fn outcome(machine: Machine) -> Outcome {
    Outcome {
        name: "robot".to_string(),
        run: Run {
            version: String::new(),
            seed: 0,
            problem: Value::Null,
            inputs: Vec::new(),
            wall_s: 0.0,
            provenance: Provenance::default(),
        },
        mistakes: Vec::new(),
        estimate: Estimate::default(),
        part: Part::Fit(Fit {
            machine: Some(machine),
            ..Fit::default()
        }),
    }
}

/// Gives a parameter of an effect of the identified robot another value.
fn set(outcome: &mut Outcome, name: &str, value: f64) {
    let Part::Fit(fit) = &mut outcome.part else {
        panic!("a fit")
    };
    let joints = &mut fit.machine.as_mut().unwrap().joints;
    let all = joints.iter_mut().flat_map(|joint| {
        let of = joint.name.clone();
        let effects = joint.effects.iter_mut();
        effects.flat_map(move |effect| {
            let head = format!("{of}.{}", effect.id);
            let parameters = effect.parameters.iter_mut();
            parameters.map(move |p| (format!("{head}.{}", p.name), p))
        })
    });
    let mut found = all.filter(|(other, _)| other == name);
    found.next().unwrap().1.value = value;
}

fn motion(joints: usize) -> Motion {
    let mut rng = generator(99);
    [1.5, 2.0, 8.0].map(|range| {
        let mut series = || (0..STATES).map(|_| symmetric(&mut rng, range)).collect();
        (0..joints).map(|_| series()).collect()
    })
}

fn signal(model: &Model, values: &DVector<f64>, motors: &Motion, loaded: bool) -> Vec<Vec<f64>> {
    let [q, dq, ddq] = motors;
    let motors = Trajectory { q, dq, ddq };
    let mut evaluator = Evaluator::new(model, values, &[]);
    let block = evaluator.evaluate(Segment::states(motors, loaded), 0..STATES);
    (0..model.channels().len())
        .map(|c| block.value(c).to_vec())
        .collect()
}

fn torques(tree: &Tree, [q, dq, ddq]: &Motion) -> Vec<Vec<f64>> {
    let n = tree.len();
    let (mut out, mut torque) = (vec![vec![0.0; STATES]; n], vec![0.0; n]);
    let parameters = tree.parameters();
    let mut dynamics = NewtonEuler::new(tree);
    for state in 0..STATES {
        let at = |series: &[Vec<f64>]| series.iter().map(|s| s[state]).collect::<Vec<f64>>();
        let (q, dq, ddq) = (at(q), at(dq), at(ddq));
        dynamics.torque(tree, &parameters, [&q, &dq, &ddq], &mut torque);
        for (series, value) in out.iter_mut().zip(&torque) {
            series[state] = *value;
        }
    }
    out
}

fn assert_close(found: &[Vec<f64>], expected: &[Vec<f64>], bound: f64, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let largest = expected
        .iter()
        .flatten()
        .fold(0.0_f64, |m, x| m.max(x.abs()));
    for (j, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert_eq!(found.len(), expected.len(), "{what}");
        for (found, expected) in found.iter().zip(expected) {
            let difference = (found - expected).abs() / largest;
            assert!(difference <= bound, "{what}: joint {j} by {difference:.1e}");
        }
    }
}

/// Every effect of the vocabulary that acts on a drive, couplings, offsets, a load, currents.
fn industrial() -> Case {
    let effects: Vec<&str> = exid::chain::effect::ids()
        .into_iter()
        .filter(|id| SIMPLE.contains(id))
        .collect();
    let problem = format!(
        "name = \"robot\"\n[robot]\nurdf = \"arm6.urdf\"\ninertials = \"known\"\npayload = \"last\"\n\
         gravity = [1.0, -2.0, -9.0]\n[drive]\n\
         torque_constant = [13.1, -13.0, 12.8, 9.2, 9.1, 9.3]\noffset = [0.1, 0.0, -0.2, 0.0, 0.3, 0.0]\n\
         coupling = [[1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, -0.5, 1, 0, 0, 0], [0, 0, 0, 1, 0, 0],\n\
         [0, 0, 0, 0.02, 1, 0], [0, 0, 0, 0.01, 0.03, 1]]\neffects = {effects:?}\n"
    );
    Case::new("problems/arm6/arm6.urdf", &problem, 1)
}

/// Effects whose torque has a formula in exported code, and the gain.
const SIMPLE: &[&str] = &[
    "coulomb_friction",
    "viscous_friction",
    "asymmetric_friction",
    "torque_offset",
    "rotor_inertia",
    "drive_gain",
];

fn tables() -> Case {
    let problem = "name = \"robot\"\n[robot]\nmdh = \"panda_like.mdh.toml\"\ninertials = \"known\"\n\
                   [drive]\nrotor_inertia = 0.3\neffects = [\"coulomb_friction\", \"viscous_friction\"]\n";
    Case::new("problems/panda_like/panda_like.mdh.toml", problem, 2)
}

fn tree() -> Case {
    let problem = "name = \"robot\"\n[robot]\nurdf = \"tree8.urdf\"\ninertials = \"known\"\n\
                   [drive]\neffects = [\"viscous_friction\", \"rotor_inertia\"]\n";
    Case::new("tests/reference/robots/tree8.urdf", problem, 3)
}

fn cases() -> [Case; 3] {
    [industrial(), tables(), tree()]
}

#[test]
fn invariant_urdf_and_its_side_file_read_back_to_the_same_signal() {
    for case in cases() {
        let (export, _) = case.export(Format::Urdf);
        let (_, _, model) = open(&case.folder.path().join(&export.files[1].name));
        let motors = motion(model.tree().len());
        for loaded in [false, true] {
            let found = signal(&model, &model.values(), &motors, loaded);
            assert_close(&found, &case.signal(&motors, loaded), TORQUES, "URDF");
        }
    }
}

/// Least squares without the limits of physics may leave friction that drives.
#[test]
fn invariant_what_a_fit_leaves_beyond_physics_reads_back_with_a_warning() {
    let mut case = tree();
    let name = "viscous_friction.Fv";
    let index = case
        .model
        .parameters()
        .iter()
        .position(|p| p.name.ends_with(name));
    case.values[index.unwrap()] = -0.3;
    let parameter = case.model.parameters()[index.unwrap()].name.clone();
    set(&mut case.outcome, &parameter, -0.3);

    let (export, _) = case.export(Format::Urdf);
    let notes = export.notes.join("\n");
    assert!(notes.contains("drives where it should brake"), "{notes}");
    let side = case.folder.path().join(&export.files[1].name);
    let (problem, robot, model) = open(&side);
    let motors = motion(model.tree().len());
    let found = signal(&model, &model.values(), &motors, false);
    assert_close(&found, &case.signal(&motors, false), TORQUES, "URDF");
    let truth = exid::simulate::truth::build(&problem, &robot).unwrap_or_else(|e| panic!("{e}"));
    let simulated = signal(&truth.plant, &truth.plant.values(), &motors, false);
    assert_close(&simulated, &found, TORQUES, "simulated");
    let warned: Vec<_> = exid::check::run(&problem, &Control::default())
        .into_iter()
        .filter(|finding| finding.code == "value-beyond-physics")
        .collect();
    assert_eq!(warned.len(), 1, "{warned:?}");
    assert_eq!(warned[0].channel.as_ref(), Some(&parameter));
}

#[test]
fn invariant_a_urdf_without_robot_file_gives_the_same_torques() {
    for case in cases() {
        let mut machine = case.machine().clone();
        machine.description = None;
        let written = export(&outcome(machine), Format::Urdf).unwrap();
        let path = case.folder.path().join("plain.urdf");
        fs::write(&path, &written.files[0].text).unwrap();
        let read = exid::robot::urdf::read(&path).unwrap_or_else(|e| panic!("{e}"));
        let tree = case.machine().tree(false);
        let names =
            |tree: &Tree| -> Vec<String> { tree.joints().iter().map(|j| j.name.clone()).collect() };
        assert_eq!(names(&read), names(&tree));
        let read = read.with_gravity(tree.gravity().into());
        let motion = motion(tree.len());
        let (found, expected) = (torques(&read, &motion), torques(&tree, &motion));
        assert_close(&found, &expected, TORQUES, "plain URDF");
    }
}

#[test]
fn invariant_a_robot_file_keeps_what_is_not_inertial() {
    let case = industrial();
    let original = &case.machine().description.as_ref().unwrap().text;
    let (export, _) = case.export(Format::Urdf);
    let strip = |text: &str| -> Vec<String> {
        let document = roxmltree::Document::parse(text).unwrap();
        let all = document.descendants().filter(|n| n.is_element());
        let kept = all.filter(|n| {
            let mut own = n.ancestors();
            !own.any(|a| a.has_tag_name("inertial") || a.has_tag_name("dynamics"))
        });
        kept.map(|n| {
            format!(
                "{:?} {:?}",
                n.tag_name(),
                n.attributes().collect::<Vec<_>>()
            )
        })
        .collect()
    };
    assert_eq!(strip(original), strip(&export.files[0].text));
}

#[test]
fn invariant_the_table_reads_back_to_the_same_bodies_and_drives() {
    for case in cases() {
        let (export, _) = case.export(Format::Toml);
        let table: Table = toml::from_str(&export.files[0].text).unwrap();
        let machine = case.machine();
        let mut rebuilt = machine.clone();
        for (joint, row) in rebuilt.joints.iter_mut().zip(&table.joint) {
            joint.body = row.body.about_origin().0;
            joint.pose = row.pose;
            for effect in &joint.effects {
                for parameter in &effect.parameters {
                    assert_eq!(row.drive[&effect.id][&parameter.name], parameter.value);
                }
            }
        }
        if let (Some(load), Some(row)) = (&mut rebuilt.payload, &table.load) {
            load.body = row.body.about_origin().0;
        }
        let motion = motion(machine.joints.len());
        let found = torques(&rebuilt.tree(true), &motion);
        assert_close(
            &found,
            &torques(&machine.tree(true), &motion),
            TORQUES,
            "TOML",
        );
    }
}

#[test]
fn invariant_principal_moments_and_axes_of_the_load_make_its_tensor() {
    let case = industrial();
    let (export, _) = case.export(Format::Toml);
    let table: Table = toml::from_str(&export.files[0].text).unwrap();
    let load = table.load.unwrap();
    assert_eq!(load.frame, "link6");
    let axes = nalgebra::Matrix3::from_fn(|r, c| load.principal_axes[c][r]);
    assert!((axes.determinant() - 1.0).abs() < 1e-12);
    let moments = nalgebra::Matrix3::from_diagonal(&load.principal_moments.into());
    let [xx, xy, xz, yy, yz, zz] = load.body.inertia;
    let tensor = nalgebra::Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let difference = (axes * moments * axes.transpose() - tensor).amax();
    assert!(difference <= 1e-12 * tensor.amax(), "{difference:.1e}");
}

/// What a simulator makes of a case: torques by name of the joint.
fn simulated(python: &std::ffi::OsStr, case: &Case, motion: &Motion) -> Value {
    let machine = case.machine();
    let names: Vec<&str> = machine.joints.iter().map(|j| j.name.as_str()).collect();
    let (_, urdf) = case.export(Format::Urdf);
    let (_, mjcf) = case.export(Format::Mjcf);
    let request = json!({
        "urdf": urdf, "mjcf": mjcf, "gravity": machine.gravity, "joints": names, "motion": motion,
    });
    let path = case.folder.path().join("request.json");
    fs::write(&path, request.to_string()).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/simulators.py");
    let output = Command::new(python).arg(script).arg(path).output().unwrap();
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{words}");
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn invariant_simulators_give_the_same_torques() {
    let Some(python) = std::env::var_os("EXID_PYTHON") else {
        common::skip("EXID_PYTHON does not name a Python with Pinocchio and MuJoCo (pin, mujoco)");
        return;
    };
    for case in cases() {
        let machine = case.machine();
        let motion = motion(machine.joints.len());
        let found = simulated(&python, &case, &motion);
        let series =
            |key: &str| -> Vec<Vec<f64>> { serde_json::from_value(found[key].clone()).unwrap() };
        let bodies = torques(&machine.tree(false), &motion);
        assert_close(&series("pinocchio"), &bodies, SIMULATORS, "Pinocchio");
        let mut driven = torques(&machine.tree(true), &motion);
        for (j, joint) in machine.joints.iter().enumerate() {
            let value = |effect, parameter| joint.value(effect, parameter).unwrap_or(0.0);
            for (state, torque) in driven[j].iter_mut().enumerate() {
                *torque += value("rotor_inertia", "Jm") * motion[2][j][state]
                    + value("viscous_friction", "Fv") * motion[1][j][state];
            }
        }
        assert_close(&series("mujoco"), &driven, SIMULATORS, "MuJoCo");
        let losses = machine
            .joints
            .iter()
            .map(|j| j.value("coulomb_friction", "Fc"));
        let losses: Vec<f64> = losses.map(|fc| fc.unwrap_or(0.0)).collect();
        assert_eq!(found["frictionloss"], json!(losses));
    }
}

#[test]
fn a_results_folder_is_all_that_an_export_needs() {
    let arm = common::arm::Arm::new(4);
    assert!(arm.fit("out", &[]).status().unwrap().success());
    fs::remove_file(arm.path("arm.urdf")).unwrap();
    fs::remove_file(arm.path("problem.toml")).unwrap();
    for format in ["urdf", "mjcf", "mujoco", "toml", "rust", "c", "numpy"] {
        let output = Command::new(env!("CARGO_BIN_EXE_exid"))
            .current_dir(arm.folder())
            .args(["export", "out", "--to", format, "--json"])
            .output()
            .unwrap();
        let words = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{words}");
        let said: Value = serde_json::from_slice(&output.stdout).unwrap();
        for file in said["files"].as_array().unwrap() {
            assert!(arm.path(file.as_str().unwrap()).is_file());
        }
    }
    let (_, _, model) = open(&arm.path("out/arm.problem.toml"));
    assert_eq!(model.tree().len(), 2);
}

#[test]
fn a_result_without_robot_is_refused() {
    let mut other = industrial().outcome;
    other.part = Part::Fit(Fit::default());
    let error = export(&other, Format::Urdf).unwrap_err().to_string();
    assert!(error.contains("holds no identified robot"), "{error}");
}
