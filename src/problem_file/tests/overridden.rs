//! Overrides replace keys of the file, and their faults name the override.

use super::{FULL, parse};
use crate::fault::Fault;
use crate::problem_file::PerJoint;
use crate::problem_file::choices::Estimator;
use crate::problem_file::drive::CurrentLaw;
use crate::problem_file::robot::RobotSource;

const ROBOT: &str = "[robot]\nurdf = \"r.urdf\"\n";

#[test]
fn bare_words_and_toml_values_replace_keys() {
    let overrides = [
        "fit.estimator=wls",
        "drive.torque_constant=[1,2]",
        "recordings.period = 12",
        "recordings.train=[\"a.csv\"]",
        "robot.urdf=../other robot.urdf",
        "design.rest_to_rest=false",
    ];
    let file = parse(ROBOT, &overrides).unwrap();
    assert_eq!(file.fit.estimator.value, Estimator::WeightedLeastSquares);
    let Some(CurrentLaw::Constant(constant)) = &file.drive.current_law else {
        panic!("no torque constant");
    };
    assert_eq!(constant.value, PerJoint::Each(vec![1.0, 2.0]));
    let recordings = file.recordings().unwrap();
    assert_eq!(recordings.period.as_ref().unwrap().value, 12.0);
    assert_eq!(recordings.train[0].written, "a.csv");
    let RobotSource::Urdf(urdf) = &file.robot.source else {
        panic!("not a URDF");
    };
    assert_eq!(urdf.written, "../other robot.urdf");
    assert!(!file.design.rest_to_rest.value);
    assert_eq!(file.json["fit"]["estimator"], "wls");
    assert_eq!(file.json["recordings"]["period"], 12);
}

#[test]
fn names_with_dots_need_no_quotes_in_an_override() {
    for text in [
        "drive.values.\"a5.coulomb_friction.w\"=0.004",
        "drive.values.a5.coulomb_friction.w=0.004",
        "drive.values.'a5.coulomb_friction.w' = 0.004",
    ] {
        let file = parse(ROBOT, &[text]).unwrap();
        assert_eq!(file.drive.values.len(), 1, "{text}");
        assert_eq!(file.drive.values[0].name, "a5.coulomb_friction.w");
        assert_eq!(file.drive.values[0].value.value, 0.004);
    }
}

#[test]
fn the_last_override_of_a_key_holds() {
    let overrides = ["design.period=3", "design.period=4.5"];
    assert_eq!(parse(FULL, &overrides).unwrap().design.period.value, 4.5);
}

/// Override, code, key, and a part of the message or remedy.
#[rustfmt::skip]
const FAULTS: &[(&str, &str, &str, &str)] = &[
    ("fit.estimatr=wls", "unknown-key", "fit.estimatr", "\"estimator\""),
    ("ftt.estimator=wls", "unknown-key", "ftt.estimator", "\"fit\""),
    ("fit.estimator=wlz", "unknown-estimator", "fit.estimator", "\"wls\""),
    ("recordings.period=-1", "not-positive", "recordings.period", "-1"),
    ("recordings.period=1e", "wrong-type", "recordings.period", "1e"),
    ("drive.ratio=[1, 0]", "zero", "drive.ratio", "0"),
    ("drive.ratio=[1, 2", "override-value", "drive.ratio", "[1, 2"),
    ("drive.ratio", "override-form", "drive.ratio", "key=value"),
    ("drive.ratio=", "override-form", "drive.ratio", "key=value"),
    ("=3", "override-form", "", "key=value"),
    ("drive..ratio=3", "override-form", "drive..ratio", "key=value"),
    ("", "override-form", "", "key=value"),
    ("name.first=x", "override-below-value", "name.first", "\"name\" is a text"),
    ("robot.mdh=r.toml", "conflict", "robot.mdh", "urdf"),
    ("fit=3", "wrong-type", "fit", "a table"),
    ("design.harmonics=2.5", "wrong-type", "design.harmonics", "whole"),
];

#[test]
fn a_key_as_long_as_a_command_line_is_refused_at_once() {
    let text = format!("{}a=1", "a.".repeat(60_000));
    let error = parse(ROBOT, &[&text]).unwrap_err();
    assert_eq!(error.describe().code, "override-too-deep");
    assert!(error.to_string().len() < 200, "{error}");
}

#[test]
fn faults_of_overrides_name_the_override() {
    for (text, code, key, says) in FAULTS {
        let error = parse(FULL, &[text]).expect_err(text);
        assert_eq!(error.describe().code, *code, "{text}: {error}");
        let place = error.place();
        assert_eq!(place.key, Some(format!("--set {key}")), "{text}: {error}");
        assert_eq!((place.line, place.column), (None, None), "{text}");
        assert!(error.to_string().contains(says), "{text}: {error}");
    }
}
