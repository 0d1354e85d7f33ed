//! An effect that a program brings along, in Rust: registered, it is fitted, simulated, searched for, explained and exported like
//! those of the vocabulary.
//!
//! ```text
//! torque = c·q²·sign(v)     drag that grows to either side of the middle
//! ```

mod common;

use exid::chain::effect::catalogue::register;
use exid::chain::effect::expression::{Expression, Variable};
use exid::chain::effect::knowledge::Knowledge;
use exid::chain::effect::{
    Contribution, Dependence, Effect, Law, Needs, ParameterInfo, Power, Samples, TorqueLaw, Unit,
    ids,
};
use exid::diagnose;
use exid::estimate::task as fit;
use exid::export::{self, Format};
use exid::outcome::provenance::Provenance;
use exid::outcome::run::Run;
use exid::outcome::{Outcome, Part};
use exid::problem::solution::Control;
use exid::problem_file::ProblemFile;
use exid::simulate::{self, write_csv};
use std::fs::{self, File};

#[derive(Debug)]
struct Drag;

impl TorqueLaw for Drag {
    fn add(&self, samples: Samples<'_>, parameters: &[f64], out: &mut Contribution<'_>) {
        for (k, (q, sign)) in samples.position.iter().zip(samples.sign).enumerate() {
            out.torque[k] += parameters[0] * q * q * sign;
            out.by_sign[k] += parameters[0] * q * q;
            out.by_parameter[0][k] = q * q * sign;
        }
    }

    fn power(&self) -> Power {
        Power::Exchanges
    }

    fn torque(&self) -> Expression {
        Expression::parameter(0) * Expression::from(Variable::Position).squared() * Variable::Sign
    }
}

static DRAG: Effect = Effect {
    id: "square_drag",
    sentence: "Drag grows to either side of the middle.",
    equation: "c·q²·sign(v)",
    source: "a test",
    parameters: &[ParameterInfo::linear(
        "c",
        Unit::Torque,
        "drag at 1 rad",
        1.0,
    )],
    depends_on: &[Dependence::Position, Dependence::Direction],
    confounded_with: &[],
    law: Law::Motor(&Drag),
    needs: Needs::NOTHING,
    knowledge: Knowledge::NONE,
};

fn problem(effects: &str) -> String {
    format!(
        "name = \"arm\"\n[robot]\nurdf = \"arm.urdf\"\ninertials = \"known\"\n[drive]\ntorque_constant = [12.0, 8.0]\n\
         effects = [\"coulomb_friction\", \"viscous_friction\"{effects}]\n[recordings]\ntrain = [\"train.csv\"]\n\
         validation = [\"validation.csv\"]\nsignal = \"current\"\nrate = 200.0\nperiod = 4.0\n[design]\nperiod = 4.0\n\
         [simulate]\ntrajectory = \"random\"\nmode = \"inverse\"\nperiods = 3\nnoise = [0.02, 0.02]\n\
         encoder_counts = 524288\n[simulate.values]\n\"shoulder.Fc\" = 3.0\n\"shoulder.Fv\" = 2.0\n\"elbow.Fc\" = 1.2\n\
         \"elbow.Fv\" = 0.8\n\"elbow.square_drag.c\" = 0.9\n"
    )
}

#[test]
fn an_effect_of_a_program_is_one_like_ours() {
    register(&DRAG).unwrap();
    register(&DRAG).unwrap();
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("arm.urdf"), common::arm::URDF).unwrap();
    let control = Control::default();
    let read = |effects: &str| {
        let path = folder.path().join("problem.toml");
        ProblemFile::parse(&path, &problem(effects), &[], &ids()).unwrap()
    };
    let made = simulate::run(&read(""), 4, &control).unwrap();
    for recording in &made.recordings {
        let file = File::create(folder.path().join(&recording.name)).unwrap();
        write_csv(file, recording).unwrap();
    }

    let fitted = fit::run(&read(", \"square_drag\""), &control, |_| ()).unwrap();
    let estimate = &fitted.fitted.estimate.parameters;
    let found = estimate.iter().find(|p| p.name == "elbow.square_drag.c");
    let found = found.unwrap();
    let (value, std_dev) = (found.value.unwrap(), found.std_dev.unwrap());
    assert!(
        (value - 0.9).abs() <= 4.0 * std_dev + 0.01,
        "{value} ± {std_dev}"
    );

    let diagnosed = diagnose::task::run(&read(""), &control, &|_| ()).unwrap();
    let first = &diagnosed.diagnosis.findings[0];
    assert_eq!(first.effect, "square_drag");
    assert_eq!(first.joints, ["elbow"]);
    assert!(
        first.sentence.contains("Drag grows to either side"),
        "{}",
        first.sentence
    );

    let outcome = Outcome {
        name: "arm".into(),
        run: Run {
            version: String::new(),
            seed: 0,
            problem: serde_json::Value::Null,
            inputs: Vec::new(),
            wall_s: 0.0,
            provenance: Provenance::default(),
        },
        mistakes: Vec::new(),
        estimate: fitted.fitted.estimate.clone(),
        part: Part::Fit(fitted.fitted.fit.clone()),
    };
    for format in [Format::Rust, Format::C, Format::NumPy, Format::Mujoco] {
        let written = export::export(&outcome, format).unwrap();
        assert!(!written.files.is_empty());
    }
}
