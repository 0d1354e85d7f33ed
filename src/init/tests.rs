//! Names of columns as loggers write them, and units from numbers.

use std::path::Path;

use crate::init::channels::Channels;
use crate::init::named_column::NamedColumn;
use crate::recording::column_map::ColumnsAt;
use crate::recording::samples::SignalKind;

fn names(list: &[&str]) -> Vec<String> {
    list.iter().map(|name| (*name).to_owned()).collect()
}

/// Position, velocity and signal as patterns or lists of names, with their units.
fn found(present: &[&str], joints: &[&str]) -> [String; 3] {
    let channels =
        Channels::of(Path::new("run.csv"), &names(present), &names(joints), &[]).unwrap();
    let written = |channel: &crate::init::channels::Channel| {
        let unit = channel
            .unit
            .map_or(String::new(), |unit| format!(" in {unit}"));
        match &channel.at {
            ColumnsAt::Pattern(pattern) => format!("{pattern}{unit}"),
            _ => format!("[{}]{unit}", channel.columns.join(" ")),
        }
    };
    let velocity = channels
        .velocity
        .as_ref()
        .map_or("none".to_owned(), written);
    [
        written(&channels.position),
        velocity,
        written(&channels.signal),
    ]
}

#[test]
fn knows_how_loggers_name_columns() {
    let two = &["a1", "a2"];
    for (present, expected) in [
        (&["t", "q1", "q2", "i1", "i2"][..], ["q{n}", "none", "i{n}"]),
        (
            &["t", "q_a1", "q_a2", "dq_a1", "dq_a2", "tau_a1", "tau_a2"],
            ["q_{joint}", "dq_{joint}", "tau_{joint}"],
        ),
        (
            &[
                "actual_q_0",
                "actual_q_1",
                "target_q_0",
                "target_q_1",
                "actual_current_0",
                "actual_current_1",
            ],
            [
                "[actual_q_0 actual_q_1]",
                "none",
                "[actual_current_0 actual_current_1]",
            ],
        ),
        (
            &[
                "Zeit",
                "Winkel_1_deg",
                "Winkel_2_deg",
                "Drehzahl_1_rpm",
                "Drehzahl_2_rpm",
                "Strom_1_mA",
                "Strom_2_mA",
            ],
            [
                "Winkel_{n}_deg in deg",
                "Drehzahl_{n}_rpm in rpm",
                "Strom_{n}_mA in mA",
            ],
        ),
        (
            &[
                "time",
                "a1_pos",
                "a2_pos",
                "a1_effort",
                "a2_effort",
                "a1_effort_cmd",
                "a2_effort_cmd",
            ],
            ["{joint}_pos", "none", "{joint}_effort"],
        ),
        (
            &[
                "t",
                "jointPosition01",
                "jointPosition02",
                "jointTorque01",
                "jointTorque02",
            ],
            [
                "[jointPosition01 jointPosition02]",
                "none",
                "[jointTorque01 jointTorque02]",
            ],
        ),
        (
            &[
                "t", "q1", "q2", "q_vel1", "q_vel2", "i1", "i2", "tau1", "tau2",
            ],
            ["q{n}", "q_vel{n}", "tau{n}"],
        ),
        (
            &[
                "Zeit [s]",
                "AIPos.A1",
                "AIPos.A2",
                "SollPos.A1",
                "SollPos.A2",
                "MACur.A1",
                "MACur.A2",
            ],
            ["AIPos.A{n}", "none", "MACur.A{n}"],
        ),
        (
            &[
                "Achse 1 Istposition [°]",
                "Achse 2 Istposition [°]",
                "Achse 1 Sollposition [°]",
                "Achse 2 Sollposition [°]",
                "Achse 1 Motorstrom [A]",
                "Achse 2 Motorstrom [A]",
            ],
            [
                "Achse {n} Istposition [°] in deg",
                "none",
                "Achse {n} Motorstrom [A]",
            ],
        ),
    ] {
        assert_eq!(found(present, two), expected, "{present:?}");
    }
}

/// A robot of which not every joint is recorded.
#[test]
fn some_joints_may_have_no_columns() {
    let channels = Channels::of(
        Path::new("run.csv"),
        &names(&["t", "q3", "q4", "i3", "i4"]),
        &names(&["a1", "a2", "a3", "a4"]),
        &[],
    );
    assert_eq!(channels.unwrap().position.joints, [2, 3]);
}

#[test]
fn what_is_not_there_is_named_with_what_is() {
    let of = |present: &[&str]| {
        let error =
            Channels::of(Path::new("run.csv"), &names(present), &names(&["a1"]), &[]).unwrap_err();
        error.to_string()
    };
    assert!(
        of(&["t", "x1", "i1"])
            .starts_with("run.csv: no column is known by its name to hold positions")
    );
    let text = of(&["t", "q1", "x1"]);
    assert!(
        text.contains(
            "currents, torques or commanded positions of the joints a1; it has t, q1, x1."
        ) && text.contains("--column 'position=NAME{n}'"),
        "{text}"
    );
}

/// Columns whose names say nothing are named.
#[test]
fn columns_may_be_named() {
    let of = |columns: &[&str]| {
        let present = names(&[
            "clock",
            "x_1",
            "x_2",
            "y_one_deg",
            "y_two_deg",
            "amps1",
            "amps2",
        ]);
        let columns: Vec<NamedColumn> = columns.iter().map(|c| c.parse().unwrap()).collect();
        Channels::of(
            Path::new("run.csv"),
            &present,
            &names(&["one", "two"]),
            &columns,
        )
    };
    let found = of(&["time=clock", "position=x_{n}"]).unwrap();
    assert_eq!(found.time.unwrap().columns, ["clock"]);
    assert_eq!(found.position.columns, ["x_1", "x_2"]);
    assert_eq!(
        (found.kind, found.signal.columns),
        (SignalKind::Current, names(&["amps1", "amps2"]))
    );
    let found = of(&["position=y_{joint}_deg", "torque=x_1,x_2"]).unwrap();
    assert_eq!(found.position.columns, ["y_one_deg", "y_two_deg"]);
    assert_eq!(found.position.unit, Some("deg"));
    assert_eq!(
        (found.kind, found.signal.columns),
        (SignalKind::Torque, names(&["x_1", "x_2"]))
    );
    let error = of(&["position=z{n}"]).unwrap_err().to_string();
    assert!(
        error.starts_with("run.csv: it has no column `z{n}`; it has clock, x_1"),
        "{error}"
    );
    for wrong in ["position", "place=q{n}", "position="] {
        assert!(
            wrong
                .parse::<NamedColumn>()
                .unwrap_err()
                .contains("position=NAME{n}")
        );
    }
}
