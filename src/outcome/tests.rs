//! The result file: names and order of its keys, round trips, numbers that are not finite.

use serde_json::{Value, json};

use crate::outcome::check::{Check, Mistake, Severity};
use crate::outcome::estimate::{Covariance, Estimate, Solver};
use crate::outcome::fit::{BaseParameter, Fit};
use crate::outcome::input::Input;
use crate::outcome::joint::JointFigures;
use crate::outcome::parameter::{Parameter, Source};
use crate::outcome::provenance::{Provenance, VERSION};
use crate::outcome::run::Run;
use crate::outcome::simulation::{RealisedNoise, RecordedPosition, Simulation};
use crate::outcome::{Outcome, Part};

/// Figures of a joint with a held-out recording.
pub(crate) fn joint_figures(joint: &str, rmse_validation: f64) -> JointFigures {
    JointFigures {
        joint: joint.to_string(),
        unit: "A".to_string(),
        rmse_train: 0.25,
        rmse_validation: Some(rmse_validation),
        rmse_train_raw: 0.5,
        rmse_validation_raw: Some(0.625),
        mae_train: 0.125,
        mae_validation: Some(0.1875),
        relative_train: 0.03125,
        relative_validation: Some(0.0625),
        noise_rms: Some(0.1875),
        lack_of_fit: Some(1.5),
    }
}

/// A small result of `fit` with each kind of parameter.
pub(crate) fn fit_outcome() -> Outcome {
    Outcome {
        name: "arm".to_string(),
        run: Run {
            version: VERSION.to_string(),
            seed: 7,
            problem: json!({"name": "arm", "fit": {"estimator": "wls"}}),
            inputs: vec![Input {
                path: "train.csv".to_string(),
                sha256: "0".repeat(64),
            }],
            wall_s: 1.5,
            provenance: Provenance::default(),
        },
        mistakes: Vec::new(),
        estimate: Estimate {
            parameters: vec![
                Parameter {
                    value: Some(1.5),
                    std_dev: Some(0.25),
                    ci95: Some([1.0, 2.0]),
                    source: Source::Data,
                    ..Parameter::undetermined("joint1.coulomb_friction.Fc", "N·m")
                },
                Parameter::known("joint1.coulomb_friction.w", "rad/s", 0.5),
                Parameter::undetermined("link1.mass", "kg"),
            ],
            joints: vec![joint_figures("joint1", 0.375)],
            covariance: Covariance {
                parameters: vec!["joint1.coulomb_friction.Fc".to_string()],
                matrix: vec![vec![0.0625]],
            },
            solver: Some(Solver {
                name: "linear".to_string(),
                stop: "optimal".to_string(),
                converged: true,
                iterations: 1,
                evaluations: 2,
                cost: 3.5,
            }),
        },
        part: Part::Fit(Fit {
            base_parameters: vec![BaseParameter {
                expression: "link1.com_x*link1.mass".to_string(),
                unit: "kg·m".to_string(),
                value: Some(0.75),
                std_dev: Some(0.125),
                ci95: None,
            }],
            rank: 2,
            condition_number: 12.5,
            ..Fit::default()
        }),
    }
}

/// Keys of a JSON object in their order, separated by spaces.
fn keys(value: &Value) -> String {
    let object = value.as_object().unwrap();
    object
        .keys()
        .map(String::as_str)
        .collect::<Vec<_>>()
        .join(" ")
}

#[test]
fn writes_the_promised_keys_in_their_order() {
    let value: Value = serde_json::from_str(&fit_outcome().to_json().unwrap()).unwrap();
    assert_eq!(value["verb"], "fit");
    for (object, promised) in [
        (
            &value,
            "name verb version seed problem inputs wall_s provenance mistakes parameters joints covariance solver \
             base_parameters joint_torque_parameters rank condition_number feasible min_pseudo_inertia_eigenvalue \
             comparison unknowns posterior realization machine preprocessing notes",
        ),
        (&value["inputs"][0], "path sha256"),
        (
            &value["parameters"][0],
            "name unit value std_dev ci95 source description",
        ),
        (
            &value["joints"][0],
            "joint unit rmse_train rmse_validation rmse_train_raw rmse_validation_raw mae_train \
             mae_validation relative_train relative_validation noise_rms lack_of_fit",
        ),
        (
            &value["solver"],
            "name stop converged iterations evaluations cost",
        ),
        (&value["covariance"], "parameters matrix"),
        (
            &value["base_parameters"][0],
            "expression unit value std_dev ci95",
        ),
    ] {
        assert_eq!(keys(object), promised);
    }
}

#[test]
fn undetermined_has_no_numbers() {
    let value = serde_json::to_value(fit_outcome()).unwrap();
    let parameter = &value["parameters"][2];
    assert_eq!(parameter["source"], "undetermined");
    for key in ["value", "std_dev", "ci95"] {
        assert_eq!(parameter[key], Value::Null, "{key}");
    }
}

#[test]
fn invariant_every_verb_reads_back_what_was_written() {
    let fit = fit_outcome();
    let check = Outcome {
        part: Part::Check(Check {
            findings: vec![Mistake {
                code: "sign".to_string(),
                severity: Severity::Warning,
                file: Some("train.csv".to_string()),
                channel: Some("i2".to_string()),
                message: "the current opposes the motion".to_string(),
                remedy: "change its sign".to_string(),
                line: Some(3),
            }],
        }),
        ..fit.clone()
    };
    let simulate = Outcome {
        mistakes: Vec::new(),
        estimate: Estimate::default(),
        part: Part::Simulate(Simulation {
            files: vec!["train.csv".to_string()],
            realised_noise: vec![RealisedNoise {
                channel: "i1".to_string(),
                unit: "A".to_string(),
                std_dev: 0.5,
            }],
            positions: vec![RecordedPosition {
                joint: "joint1".to_string(),
                channel: "i1".to_string(),
                column: "q1".to_string(),
                unit: "rad".to_string(),
                factor: 1.0,
            }],
            notes: Vec::new(),
        }),
        ..fit.clone()
    };
    for outcome in [fit, check, simulate] {
        let read: Outcome = serde_json::from_str(&outcome.to_json().unwrap()).unwrap();
        assert_eq!(read, outcome);
    }
}

#[test]
fn numbers_that_are_not_finite_become_null_and_still_read() {
    let mut outcome = fit_outcome();
    outcome.run.wall_s = f64::INFINITY;
    outcome.estimate.parameters[0].std_dev = Some(f64::NAN);
    outcome.estimate.parameters[0].ci95 = Some([f64::NEG_INFINITY, 2.0]);
    outcome.estimate.joints[0].rmse_train = f64::NAN;
    outcome.estimate.joints[0].noise_rms = Some(f64::INFINITY);
    outcome.estimate.covariance.matrix[0][0] = f64::NAN;
    let text = outcome.to_json().unwrap();
    let value: Value = serde_json::from_str(&text).unwrap();
    for pointer in [
        "/wall_s",
        "/parameters/0/std_dev",
        "/parameters/0/ci95",
        "/joints/0/rmse_train",
        "/joints/0/noise_rms",
        "/covariance/matrix/0/0",
    ] {
        assert_eq!(value.pointer(pointer), Some(&Value::Null), "{pointer}");
    }
    let read: Outcome = serde_json::from_str(&text).unwrap();
    assert!(read.run.wall_s.is_nan());
    assert!(read.estimate.covariance.matrix[0][0].is_nan());
    assert_eq!(read.estimate.parameters[0].std_dev, None);
    assert_eq!(read.estimate.joints[0].noise_rms, None);
}

#[test]
fn a_verb_of_another_version_is_named() {
    let text = fit_outcome()
        .to_json()
        .unwrap()
        .replace("\"fit\",", "\"dance\",");
    let error = serde_json::from_str::<Outcome>(&text).unwrap_err();
    assert!(error.to_string().contains("`dance`"), "{error}");
}

#[test]
fn reads_a_folder_or_its_file_and_refuses_other_json() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("result.json");
    std::fs::write(&file, fit_outcome().to_json().unwrap()).unwrap();
    assert_eq!(Outcome::read(folder.path()).unwrap(), fit_outcome());
    assert_eq!(Outcome::read(&file).unwrap(), fit_outcome());
    std::fs::write(&file, "{\"name\": \"arm\"}").unwrap();
    let error = Outcome::read(&file).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("result.json: not the result of a run")
    );
    assert!(!error.concerns_output());
}
