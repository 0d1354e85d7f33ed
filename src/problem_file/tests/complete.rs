//! A file with every table and key gives the values written in it; a small one gives the defaults.

use std::path::Path;

use super::{FULL, parse};
use crate::problem_file::choices::{
    Criterion, DesignKind, DifferentiationMethod, Estimator, Inertials, Mechanism, PositionSide,
    PriorKind, Scaling, Signal, SimulationMode,
};
use crate::problem_file::design::{DesignParameters, Harmonics};
use crate::problem_file::diagnose::SoughtEffects;
use crate::problem_file::drive::CurrentLaw;
use crate::problem_file::fit::{Interval, PriorValue, RegularisationWeight};
use crate::problem_file::recordings::RecordingFiles;
use crate::problem_file::robot::{PayloadPlace, RobotSource};
use crate::problem_file::simulate::Trajectory;
use crate::problem_file::{Located, Named, PerJoint, ProblemFile};
use crate::recording::column_map::Column;

fn full() -> ProblemFile {
    parse(FULL, &[]).unwrap()
}

fn texts(list: &[Located<String>]) -> Vec<&str> {
    list.iter().map(|text| text.as_str()).collect()
}

fn named<T: Clone>(list: &[Named<T>]) -> Vec<(&str, T)> {
    list.iter()
        .map(|entry| (entry.name.as_str(), entry.value.value.clone()))
        .collect()
}

fn written(files: &[Located<RecordingFiles>]) -> Vec<&str> {
    files.iter().map(|file| file.written.as_str()).collect()
}

fn given<T>(value: &Option<Located<T>>) -> &T {
    &value.as_ref().unwrap().value
}

#[test]
fn robot_of_the_complete_file() {
    let file = full();
    assert_eq!(file.name.value, "kr150_payload");
    let robot = file.robot;
    let RobotSource::Urdf(urdf) = &robot.source else {
        panic!("not a URDF: {:?}", robot.source);
    };
    assert_eq!(urdf.written, "kr150.urdf");
    assert_eq!(urdf.resolved, Path::new("folder/kr150.urdf"));
    assert_eq!(*given(&robot.gravity), [0.0, 0.5, -9.81]);
    assert_eq!(texts(robot.joints.as_ref().unwrap()), ["a1", "a2", "a3"]);
    assert_eq!(named(&robot.locked), [("a4", 0.25)]);
    assert_eq!(robot.inertials.value, Inertials::Known);
    assert_eq!(texts(&robot.zero), ["link2.com_y", "link3.com_y"]);
    assert_eq!(
        given(&robot.parameters).written,
        "results/kr150/fit/result.json"
    );
    assert_eq!(
        *given(&robot.payload),
        PayloadPlace::Named("tool0".to_owned())
    );
}

#[test]
fn drive_of_the_complete_file() {
    let drive = full().drive;
    let each = |list: [f64; 3]| PerJoint::Each(list.to_vec());
    let Some(CurrentLaw::Constant(constant)) = &drive.current_law else {
        panic!("no torque constant: {:?}", drive.current_law);
    };
    assert_eq!(constant.value, each([310.0, 320.0, 205.5]));
    assert_eq!(*given(&drive.rotor_inertia), each([62.0, 60.0, 25.0]));
    assert_eq!(*given(&drive.ratio), each([32.0, -33.5, 28.0]));
    assert_eq!(*given(&drive.offset), each([0.0, 0.01, -0.02]));
    assert_eq!(
        *given(&drive.coupling),
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.125, 1.0]].map(Vec::from)
    );
    assert_eq!(
        texts(&drive.effects),
        ["coulomb_friction", "viscous_friction"]
    );
    assert_eq!(drive.effects_of.len(), 1);
    assert_eq!(drive.effects_of[0].name, "a3");
    assert_eq!(
        texts(&drive.effects_of[0].value),
        [
            "coulomb_friction",
            "viscous_friction",
            "transmission_efficiency"
        ]
    );
    // In the order of the file, which is not the alphabet's.
    assert_eq!(
        named(&drive.values),
        [("a3.coulomb_friction.w", 0.004), ("a1.Fc", 35.0)]
    );
}

#[test]
fn recordings_of_the_complete_file() {
    let file = full();
    let recordings = file.recordings().unwrap();
    assert_eq!(
        written(&recordings.train),
        ["train.csv", "/data/train2.csv"]
    );
    assert_eq!(recordings.train[1].resolved, Path::new("/data/train2.csv"));
    assert_eq!(written(&recordings.validation), ["validation.csv"]);
    assert_eq!(written(&recordings.loaded), ["with_load.csv"]);
    assert_eq!(recordings.signal.value, Signal::MotorTorque);
    assert_eq!(recordings.position_side.value, PositionSide::Motor);
    assert_eq!(*given(&recordings.rate), 200.0);
    assert_eq!(*given(&recordings.period), 12.0);
    let columns = &recordings.columns;
    assert_eq!(*given(&columns.time), Column::from("t"));
    assert_eq!(*given(&columns.position), Column::from("q{n}"));
    assert_eq!(*given(&columns.velocity), Column::from("dq{n}"));
    assert_eq!(*given(&columns.acceleration), Column::from("ddq_{joint}"));
    assert_eq!(*given(&columns.current), Column::from("i{n}"));
    assert_eq!(*given(&columns.torque), Column::from("tau{n}"));
    assert_eq!(
        *given(&columns.wrench),
        ["fx", "fy", "fz", "mx", "my", "mz"].map(str::to_owned)
    );
    assert_eq!(*given(&columns.temperature), Column::from("temp{n}"));
    assert_eq!(*given(&columns.mask), Column::from("valid"));
    let differentiation = &recordings.differentiation;
    assert_eq!(
        *given(&differentiation.method),
        DifferentiationMethod::Fourier
    );
    assert_eq!(*given(&differentiation.cutoff_hz), 10.0);
    assert_eq!(*given(&differentiation.parallel_hz), 8.0);
}

#[test]
fn fit_of_the_complete_file() {
    let fit = full().fit;
    assert_eq!(fit.estimator.value, Estimator::Feasible);
    assert_eq!(*given(&fit.prior.kind), PriorKind::Pullback);
    assert_eq!(fit.prior.strength.value, RegularisationWeight::Number(0.5));
    let mass = PriorValue {
        value: 120.0,
        std_dev: 5.0,
    };
    assert_eq!(named(&fit.prior.values), [("payload.mass", mass)]);
    let between = |lower, upper| Interval { lower, upper };
    assert_eq!(
        named(&fit.bounds),
        [
            ("link3.mass", between(0.5, 6.0)),
            ("a1.Fc", between(0.0, 100.0))
        ]
    );
    assert_eq!(*given(&fit.total_mass), between(900.0, f64::INFINITY));
    assert_eq!(fit.compare.len(), 2);
    assert_eq!(fit.compare[0].name.value, "Stribeck");
    assert_eq!(texts(&fit.compare[0].effects)[2], "stribeck_friction");
    assert_eq!(fit.compare[1].name.value, "rigid");
    assert!(fit.compare[1].effects.is_empty());
}

#[test]
fn design_of_the_complete_file() {
    let design = full().design;
    assert_eq!(design.kind.value, DesignKind::ConstantVelocity);
    assert_eq!(design.harmonics.value, Harmonics::Each(vec![7, 5, 3]));
    assert_eq!(design.harmonics.value.most(), 7);
    assert_eq!(design.period.value, 20.0);
    assert_eq!(design.criterion.value, Criterion::EOptimal);
    assert_eq!(design.scaling.value, Scaling::Whitened);
    let DesignParameters::Listed(names) = &design.parameters.value else {
        panic!("not a list: {:?}", design.parameters);
    };
    assert_eq!(texts(names), ["payload.mass", "payload.com_x"]);
    assert_eq!(design.samples.value, 400);
    let each = |list: [f64; 3]| PerJoint::Each(list.to_vec());
    assert_eq!(*given(&design.noise), each([0.5, 0.6, 0.7]));
    assert!(!design.rest_to_rest.value);
    assert_eq!(design.trajectories.value, 3);
    assert_eq!(*given(&design.budget_s), 60.0);
    assert_eq!(*given(&design.starts), 20);
    let limits = &design.limits;
    assert_eq!(*given(&limits.position_lower), each([-2.9, -2.0, -1.0]));
    assert_eq!(*given(&limits.position_upper), each([2.9, 0.5, 2.5]));
    assert_eq!(*given(&limits.velocity), each([1.5, 1.6, 1.7]));
    assert_eq!(*given(&limits.acceleration), PerJoint::All(15.0));
    assert_eq!(*given(&limits.jerk), each([150.0, 160.0, 170.0]));
    assert_eq!(*given(&limits.torque), each([9000.0, 9100.0, 4000.0]));
    let halfspace = &design.workspace.halfspace[0];
    assert_eq!(halfspace.frame.value, "tool0");
    assert_eq!(halfspace.normal.value, [0.0, 0.0, 1.0]);
    assert_eq!(halfspace.offset.value, 0.1);
    let clearance = &design.workspace.clearance[0];
    assert_eq!(clearance.links.value, ["link2", "link6"].map(str::to_owned));
    assert_eq!(clearance.distance.value, 0.05);
}

#[test]
fn simulate_and_diagnose_of_the_complete_file() {
    let file = full();
    let simulate = file.simulate;
    let Trajectory::File(trajectory) = &simulate.trajectory.value else {
        panic!("not a file: {:?}", simulate.trajectory);
    };
    assert_eq!(
        trajectory.resolved,
        Path::new("folder/design/trajectory.csv")
    );
    assert_eq!(simulate.mode.value, SimulationMode::ClosedLoop);
    assert_eq!(simulate.periods.value, 4);
    assert_eq!(simulate.warmup_periods.value, 0);
    assert_eq!(*given(&simulate.rate), 250.0);
    assert_eq!(*given(&simulate.noise), PerJoint::Each(vec![0.5, 0.5, 0.0]));
    assert_eq!(simulate.noise_correlation.value, 0.9);
    assert_eq!(*given(&simulate.encoder_counts), PerJoint::All(524288.0));
    assert_eq!(
        named(&simulate.values),
        [("a3.transmission_efficiency.R", 0.84)]
    );
    let SoughtEffects::Listed(effects) = &file.diagnose.effects.value else {
        panic!("not a list: {:?}", file.diagnose.effects);
    };
    assert_eq!(texts(effects), ["time_delay", "base_tilt"]);
    assert_eq!(file.diagnose.significance.value, 0.01);
}

#[test]
fn a_file_with_a_robot_alone_has_the_documented_defaults() {
    let file = parse("robot.urdf = \"r.urdf\"", &[]).unwrap();
    assert_eq!(file.name.value, "p");
    assert!(file.robot.gravity.is_none());
    assert_eq!(file.robot.inertials.value, Inertials::Estimate);
    assert!(file.robot.joints.is_none() && file.robot.payload.is_none());
    assert!(file.drive.current_law.is_none() && file.drive.effects.is_empty());
    assert_eq!(file.fit.estimator.value, Estimator::MaximumLikelihood);
    assert!(file.fit.prior.kind.is_none());
    assert_eq!(file.design.kind.value, DesignKind::Fourier);
    assert_eq!(file.design.harmonics.value, Harmonics::All(5));
    assert_eq!(file.design.period.value, 10.0);
    assert_eq!(file.design.criterion.value, Criterion::DOptimal);
    assert_eq!(file.design.scaling.value, Scaling::Columns);
    assert_eq!(file.design.parameters.value, DesignParameters::All);
    assert_eq!(file.design.samples.value, 200);
    assert!(file.design.rest_to_rest.value);
    assert_eq!(file.design.trajectories.value, 1);
    assert_eq!(file.simulate.trajectory.value, Trajectory::Random);
    assert_eq!(file.simulate.mode.value, SimulationMode::Inverse);
    assert_eq!(file.simulate.noise_correlation.value, 0.0);
    assert_eq!(file.diagnose.effects.value, SoughtEffects::All);
    assert_eq!(file.diagnose.significance.value, 0.001);
    let error = file.recordings().unwrap_err().to_string();
    assert!(error.starts_with("folder/p.toml: recordings: "), "{error}");
}

#[test]
fn recordings_without_further_keys_hold_currents_in_joint_units() {
    let text = "robot.mdh = \"r.toml\"\nrecordings.train = [\"a.csv\"]";
    let file = parse(text, &[]).unwrap();
    assert!(matches!(file.robot.source, RobotSource::Mdh(_)));
    let recordings = file.recordings().unwrap();
    assert_eq!(recordings.signal.value, Signal::Current);
    assert_eq!(recordings.position_side.value, PositionSide::Joint);
    assert!(recordings.rate.is_none() && recordings.period.is_none());
    assert!(recordings.columns.position.is_none());
}

#[test]
fn a_mechanism_keeps_its_own_table() {
    let text = "[robot]\nmechanism = \"h4\"\n[robot.h4]\narm = 0.3\n";
    let file = parse(text, &[]).unwrap();
    let RobotSource::Mechanism { mechanism, table } = &file.robot.source else {
        panic!("not a mechanism: {:?}", file.robot.source);
    };
    assert_eq!(mechanism.value, Mechanism::H4);
    assert_eq!(table.get("arm").and_then(toml::Value::as_float), Some(0.3));
}

#[test]
fn polynomials_of_the_current_have_four_coefficients_per_joint() {
    let text = "robot.urdf = \"r\"\n\
                drive.current_polynomial = [[0.0, 310.0, 0.5, -0.01], [0, 320, 0, 0]]";
    let file = parse(text, &[]).unwrap();
    let Some(CurrentLaw::Polynomial(polynomials)) = &file.drive.current_law else {
        panic!("no polynomial: {:?}", file.drive.current_law);
    };
    assert_eq!(
        polynomials.value,
        [[0.0, 310.0, 0.5, -0.01], [0.0, 320.0, 0.0, 0.0]]
    );
}

#[test]
fn json_is_the_file_as_read() {
    let json = full().json;
    assert_eq!(json["robot"]["locked"]["a4"], 0.25);
    assert_eq!(json["design"]["harmonics"], serde_json::json!([7, 5, 3]));
    assert_eq!(json["drive"]["rotor_inertia"][1], 60);
    assert_eq!(json["fit"]["compare"][0]["name"], "Stribeck");
    assert_eq!(json["fit"]["bounds"]["total_mass"][1], "inf");
    assert_eq!(json["design"]["rest_to_rest"], false);
    // In the order of the file.
    let tables: Vec<&String> = json.as_object().unwrap().keys().collect();
    assert_eq!(
        tables,
        [
            "name",
            "robot",
            "drive",
            "recordings",
            "fit",
            "design",
            "simulate",
            "diagnose"
        ]
    );
}

#[test]
fn values_know_where_they_stand() {
    let file = full();
    let line = |fragment: &str| FULL.lines().position(|l| l.starts_with(fragment)).unwrap() + 1;
    let place = &file.drive.values[0].value.place;
    assert_eq!(place.line, Some(line("\"a3.coulomb_friction.w\"")));
    assert_eq!(place.column, Some("\"a3.coulomb_friction.w\" = ".len() + 1));
    assert_eq!(
        place.key.as_deref(),
        Some("drive.values.\"a3.coulomb_friction.w\"")
    );
    let zero = &file.robot.zero[1].place;
    assert_eq!(zero.line, Some(line("zero")));
    assert_eq!(zero.column, Some("zero = [\"link2.com_y\", ".len() + 1));
}
