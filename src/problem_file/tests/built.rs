//! A problem that a program states is the one that a file with the same keys states.

use super::{EFFECTS, parse};
use crate::fault::Fault;
use crate::problem_file::builder::ProblemBuilder;
use crate::problem_file::choices::{Estimator, Inertials, Signal};

const TOML: &str = r#"
name = "two joints"
[robot]
urdf = "r.urdf"
inertials = "known"
[recordings]
train = ["a.csv", "b.csv"]
validation = ["c.csv"]
signal = "torque"
rate = 100.0
period = 8.0
[drive]
torque_constant = 12.5
rotor_inertia = [0.5, 0.25]
effects = ["coulomb_friction", "viscous_friction"]
[drive.values]
"a1.coulomb_friction.w" = 0.004
[fit]
estimator = "wls"
[[fit.compare]]
name = "none"
effects = []
"#;

fn built() -> ProblemBuilder {
    ProblemBuilder::in_folder("folder")
        .name("two joints")
        .urdf("r.urdf")
        .inertials(Inertials::Known)
        .train("a.csv")
        .train("b.csv")
        .validation("c.csv")
        .signal(Signal::Torque)
        .rate(100.0)
        .period(8.0)
        .torque_constant(12.5)
        .rotor_inertia([0.5, 0.25])
        .effects(&["coulomb_friction", "viscous_friction"])
        .set("drive.values.a1.coulomb_friction.w", 0.004)
        .estimator(Estimator::WeightedLeastSquares)
        .set(
            "fit.compare",
            serde_json::json!([{ "name": "none", "effects": [] }]),
        )
}

#[test]
fn calls_state_what_a_file_states() {
    let (file, built) = (parse(TOML, &[]).unwrap(), built().build(EFFECTS).unwrap());
    assert_eq!(built.json, file.json);
    let train = |p: &crate::problem_file::ProblemFile| -> Vec<_> {
        let table = p.recordings().unwrap();
        table.train.iter().map(|r| r.resolved.clone()).collect()
    };
    assert_eq!(train(&built), train(&file));
    assert_eq!(train(&built)[1], std::path::Path::new("folder/b.csv"));
}

#[test]
fn the_last_value_of_a_key_holds_and_a_name_is_not_needed() {
    let built = ProblemBuilder::in_folder("folder")
        .mjcf("m.xml")
        .set("design.period", 3)
        .set("design.period", 4.5)
        .build(EFFECTS)
        .unwrap();
    assert_eq!(built.design.period.value, 4.5);
    assert_eq!(built.name.value, "problem");
}

#[test]
fn faults_name_the_key() {
    let urdf = || ProblemBuilder::in_folder("folder").urdf("r.urdf");
    for (builder, code, key) in [
        (urdf().set("fit..prior", 1), "override-key", "fit..prior"),
        (
            urdf().set("fit.estimatr", "wls"),
            "unknown-key",
            "fit.estimatr",
        ),
        (
            urdf().train("a.csv").rate(-1.0),
            "not-positive",
            "recordings.rate",
        ),
        (
            urdf().train("a.csv").rate(f64::NAN),
            "not-a-number",
            "recordings.rate",
        ),
        (
            urdf().effects(&["friktion"]),
            "unknown-effect",
            "drive.effects",
        ),
        (
            urdf().set("name", "x").set("name.y", 1),
            "override-below-value",
            "name.y",
        ),
        (ProblemBuilder::in_folder("folder"), "missing-key", "robot"),
    ] {
        let error = builder.build(EFFECTS).unwrap_err();
        assert_eq!(error.describe().code, code);
        assert_eq!(error.place().key.as_deref(), Some(key), "{error}");
    }
}
