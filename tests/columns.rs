//! Recordings with columns in other units, by number and without a header give the answer of those that are as exid
//! writes them.

mod common;

use common::arm::Arm;
use serde_json::Value;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fs;

/// Text that is rounded to fifteen digits changes nothing that matters.
const ROUNDING: f64 = 1e-6;

/// Values of all parameters that the recordings determine.
fn answer(arm: &Arm) -> BTreeMap<String, f64> {
    let output = arm.fit("out", &[]).output().unwrap();
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{words}");
    let text = fs::read_to_string(arm.path("out/result.json")).unwrap();
    let result: Value = serde_json::from_str(&text).unwrap();
    let parameters = result["parameters"].as_array().unwrap().iter();
    let determined =
        parameters.filter_map(|p| Some((p["name"].as_str()?.to_string(), p["value"].as_f64()?)));
    determined.collect()
}

/// The same recording written otherwise.
struct Written {
    what: &'static str,
    header: Option<&'static str>,
    /// What is written of time, positions and currents.
    row: fn([f64; 5]) -> Vec<f64>,
    columns: &'static str,
}

const WRITTEN: &[Written] = &[
    Written {
        what: "degrees, milliamperes and milliseconds",
        header: Some("Zeit,Winkel_1,Winkel_2,Strom_1,Strom_2"),
        row: |[t, a, b, i, j]| vec![1e3 * t, a.to_degrees(), b.to_degrees(), 1e3 * i, 1e3 * j],
        columns: "time = { column = \"Zeit\", unit = \"ms\" }\n\
                  position = { column = \"Winkel_{n}\", unit = \"deg\" }\n\
                  current = { column = \"Strom_{n}\", unit = \"mA\" }\n",
    },
    Written {
        what: "another unit for each joint",
        header: Some("t,q1,q2,i1,i2"),
        row: |[t, a, b, i, j]| vec![t, a.to_degrees(), b / TAU, i, 1e3 * j],
        columns: "position = { column = \"q{n}\", unit = [\"deg\", \"rev\"] }\n\
                  current = { column = \"i{n}\", unit = [\"A\", \"mA\"] }\n",
    },
    Written {
        what: "counts of an encoder",
        header: Some("t,q1,q2,i1,i2"),
        row: |[t, a, b, i, j]| vec![t, a * 1e9 / TAU, b * 1e9 / TAU, i, j],
        columns: "position = { column = \"q{n}\", unit = \"count\", per_turn = 1e9 }\ncurrent = \"i{n}\"\n",
    },
    Written {
        what: "names of its own for each joint",
        header: Some("t,left,right,il,ir"),
        row: |all| all.to_vec(),
        columns: "position = { column = [\"left\", \"right\"] }\ncurrent = { column = [\"il\", \"ir\"] }\n",
    },
    Written {
        what: "columns by number beside a header",
        header: Some("i2,i1,q2,q1,t"),
        row: |[t, a, b, i, j]| vec![j, i, b, a, t],
        columns: "time = { column = 5 }\nposition = { column = [4, 3] }\ncurrent = { column = [2, 1] }\n",
    },
    Written {
        what: "no header",
        header: None,
        row: |all| all.to_vec(),
        columns: "time = { column = 1, unit = \"s\" }\nposition = { column = [2, 3] }\ncurrent = { column = [4, 5] }\n",
    },
];

fn rewrite(arm: &Arm, written: &Written) {
    let text = fs::read_to_string(arm.path("train.csv")).unwrap();
    let mut lines: Vec<String> = written.header.map(String::from).into_iter().collect();
    for line in text.lines().skip(1) {
        let fields: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        let row = (written.row)(fields.try_into().unwrap());
        let row: Vec<String> = row.iter().map(f64::to_string).collect();
        lines.push(row.join(","));
    }
    arm.write("train.csv", lines.join("\n") + "\n");
    let columns = format!("[recordings.columns]\n{}\n[fit]", written.columns);
    arm.edit("problem.toml", "[fit]", &columns);
}

#[test]
fn units_and_numbers_that_are_said_give_the_same_answer() {
    let expected = answer(&Arm::new(4));
    assert!(!expected.is_empty());
    for written in WRITTEN {
        let arm = Arm::new(4);
        rewrite(&arm, written);
        let found = answer(&arm);
        assert_eq!(found.len(), expected.len(), "{}", written.what);
        for (name, value) in &expected {
            let error = (found[name] - value).abs();
            assert!(
                error <= ROUNDING * value.abs().max(1.0),
                "{}: {name}",
                written.what
            );
        }
    }
}

/// As a spreadsheet of another country saves it: semicolons, decimal commas, a row of units, and letters in Latin-1.
#[test]
fn spreadsheets_of_other_countries_give_the_same_answer() {
    let expected = answer(&Arm::new(4));
    let arm = Arm::new(4);
    let text = fs::read_to_string(arm.path("train.csv")).unwrap();
    let (_, rows) = text.split_once('\n').unwrap();
    let head = "Zeit;Größe_1;Größe_2;i1;i2\ns;rad;rad;A;A\n";
    let table = head.to_string() + &rows.replace(',', ";").replace('.', ",");
    // Every letter of it is one byte in Latin-1.
    let bytes: Vec<u8> = table.chars().map(|c| c as u8).collect();
    arm.write("train.csv", bytes);
    let columns = "[recordings.columns]\ntime = \"Zeit\"\nposition = \"Größe_{n}\"\ncurrent = \"i{n}\"\n\n[fit]";
    arm.edit("problem.toml", "[fit]", columns);
    assert_eq!(answer(&arm), expected);
}

#[test]
fn what_cannot_be_meant_is_refused_with_the_remedy() {
    let cases = [
        (
            "position = { column = \"q{n}\", unit = \"grad\" }",
            2,
            ["unknown unit \"grad\"", "deg"],
        ),
        (
            "position = { column = \"q{n}\", unit = \"count\" }",
            2,
            ["count", "per_turn"],
        ),
        (
            "current = { column = \"i{n}\", unit = \"deg\" }",
            2,
            ["unknown unit \"deg\"", "mA"],
        ),
        ("position = { unit = \"deg\" }", 2, ["column", "number"]),
        ("position = { column = [2, 9] }", 3, ["9", "elbow"]),
        (
            "position = { column = [2] }",
            2,
            ["number of values is 1", "one per joint, 2"],
        ),
        (
            "position = { column = \"q{n}\", unit = [\"deg\"] }",
            2,
            ["number of values is 1", "one per joint, 2"],
        ),
        (
            "position = { column = \"q{n}\", unit = \"deg\", per_turn = 4096 }",
            2,
            ["per_turn", "unit = \"count\""],
        ),
        (
            "mask = { column = \"q1\", unit = \"deg\" }",
            2,
            ["unit of what has none", "leave the unit out"],
        ),
    ];
    for (columns, code, words) in cases {
        let arm = Arm::new(4);
        let table = format!("[recordings.columns]\n{columns}\n[fit]");
        arm.edit("problem.toml", "[fit]", &table);
        let output = arm.fit("out", &[]).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{columns}: {said}");
        for word in words {
            assert!(said.contains(word), "{columns}: no {word} in {said}");
        }
    }
}

/// Positions in one file in degrees and milliseconds, currents in another, listed in a table with maps of their own.
#[test]
fn files_joined_by_time_give_the_same_answer() {
    let expected = answer(&Arm::new(4));
    let arm = Arm::new(4);
    let text = fs::read_to_string(arm.path("train.csv")).unwrap();
    let (mut positions, mut currents) = ("ms,a1,a2\n".to_string(), "t,i1,i2\n".to_string());
    for line in text.lines().skip(1) {
        let fields: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        let [t, a, b, i, j] = fields[..] else {
            panic!()
        };
        positions += &format!("{},{},{}\n", 1e3 * t, a.to_degrees(), b.to_degrees());
        currents += &format!("{t},{i},{j}\n");
    }
    arm.write("positions.csv", positions);
    arm.write("currents.csv", currents);
    let files = "train = [{ files = [\"currents.csv\", { file = \"positions.csv\", columns = { \
                 time = { column = \"ms\", unit = \"ms\" }, position = { column = \"a{n}\", unit = \"deg\" } } }] }]";
    arm.edit("problem.toml", "train = [\"train.csv\"]", files);
    let found = answer(&arm);
    assert_eq!(found.len(), expected.len());
    for (name, value) in &expected {
        assert!(
            (found[name] - value).abs() <= ROUNDING * value.abs().max(1.0),
            "{name}"
        );
    }
    let text = fs::read_to_string(arm.path("out/result.json")).unwrap();
    assert!(text.contains("positions.csv") && text.contains("currents.csv"));
}

#[test]
fn what_a_file_holds_is_shown() {
    let arm = Arm::new(4);
    let mut check = std::process::Command::new(env!("CARGO_BIN_EXE_exid"));
    check.current_dir(arm.folder());
    let output = check
        .args([
            "check",
            "--columns",
            "train.csv",
            "validation.csv",
            "--json",
        ])
        .output();
    let output = output.unwrap();
    assert_eq!(output.status.code(), Some(0));
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found.as_array().unwrap().len(), 2);
    assert_eq!(found[0]["rate_hz"].as_f64().map(f64::round), Some(100.0));
    assert_eq!(found[0]["columns"][1]["name"], "q1");
    assert_eq!(found[0]["columns"][1]["unit_guessed"], "rad");
    let mut absent = std::process::Command::new(env!("CARGO_BIN_EXE_exid"));
    let absent = absent
        .current_dir(arm.folder())
        .args(["check", "--columns", "none.csv"]);
    assert_eq!(absent.output().unwrap().status.code(), Some(3));
}

#[test]
fn more_rows_than_the_limit_are_refused() {
    let arm = Arm::new(4);
    let output = arm.fit("out", &["--max-rows", "100"]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(
        said.contains("more than 100 rows") && said.contains("--max-rows"),
        "{said}"
    );
}

#[test]
fn a_file_without_a_header_says_that_columns_have_numbers() {
    let arm = Arm::new(4);
    let text = fs::read_to_string(arm.path("train.csv")).unwrap();
    arm.write("train.csv", text.split_once('\n').unwrap().1);
    let output = arm.fit("out", &[]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(
        said.contains("train.csv:1") && said.contains("column = [2, 3]"),
        "{said}"
    );
}
