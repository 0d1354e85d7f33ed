//! `exid fleet` from outside: killed at any moment it goes on where it was, and its table is the same bit for bit.

mod common;

use common::arm::Arm;
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

const ITEMS: usize = 24;

/// Kills before a run is left alone.
const KILLS: u64 = 12;

/// A fleet of three arms over eight nights: one recording, each time with other last digits.
fn fleet() -> Arm {
    let arm = Arm::new(2);
    let recording = fs::read_to_string(arm.path("train.csv")).unwrap();
    let mut manifest = String::from("robot,type,recordings,problem,time\n");
    for n in 0..ITEMS {
        let name = format!("night_{n}.csv");
        let (head, rows) = recording.split_once('\n').unwrap();
        let rows = rows.lines().enumerate().map(|(k, row)| {
            let (before, last) = row.rsplit_once(',').unwrap();
            let last: f64 = last.parse().unwrap();
            format!("{before},{}\n", last + 1e-3 * ((k * (n + 7)) as f64).sin())
        });
        arm.write(&name, format!("{head}\n{}", rows.collect::<String>()));
        manifest.push_str(&format!(
            "r{},arm,{name},problem.toml,2026-01-{:02}\n",
            n % 3,
            n / 3 + 1
        ));
    }
    arm.write("nights.csv", manifest);
    arm
}

fn command(arm: &Arm, out: &str, further: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_exid"));
    command
        .current_dir(arm.folder())
        .args(["fleet", "nights.csv", "--out", out])
        .args(further);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn says(mut command: Command, code: i32) -> String {
    let output = command.output().unwrap();
    let [out, err] = [output.stdout, output.stderr].map(|t| String::from_utf8(t).unwrap());
    assert_eq!(output.status.code(), Some(code), "{out}{err}");
    out + &err
}

/// Item files with what tells whether they were written again.
fn kept(items: &Path) -> BTreeMap<PathBuf, u64> {
    let mut files = BTreeMap::new();
    for folder in fs::read_dir(items).into_iter().flatten() {
        for file in fs::read_dir(folder.unwrap().path()).unwrap() {
            let path = file.unwrap().path();
            if path.extension().is_some_and(|e| e == "json") {
                files.insert(path.clone(), fs::metadata(&path).unwrap().ino());
            }
        }
    }
    files
}

#[test]
fn killed_runs_go_on_and_give_the_same_table() {
    let arm = fleet();
    says(command(&arm, "whole", &["--threads", "1", "--quiet"]), 0);
    let items = arm.path("killed.items");
    for kill in 0..KILLS {
        let before = kept(&items);
        let mut child = command(&arm, "killed", &["--threads", "2", "--quiet"])
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(30 + 37 * kill % 150));
        child.kill().unwrap();
        child.wait().unwrap();
        let after = kept(&items);
        assert!(
            before
                .iter()
                .all(|(file, inode)| after.get(file) == Some(inode)),
            "an item was done again"
        );
    }
    let said = says(command(&arm, "killed", &["--threads", "2"]), 0);
    assert!(said.contains("0 set aside"), "{said}");
    assert_eq!(kept(&items).len(), ITEMS);
    let table = |out: &str| fs::read(arm.path(out).join("summary.parquet")).unwrap();
    assert!(table("whole") == table("killed"));
    let said = says(command(&arm, "killed", &[]), 0);
    assert!(
        said.contains(&format!("0 worked on, {ITEMS} done before")),
        "{said}"
    );
    let page = fs::read_to_string(arm.path("killed/fleet.html")).unwrap();
    assert!(
        page.contains(
            "shoulder.coulomb_friction.Fc"
                .replace('.', ".<wbr>")
                .replace('_', "_<wbr>")
                .as_str()
        )
    );
}

#[test]
fn parts_write_items_alone_and_the_rest_makes_the_table() {
    let arm = fleet();
    for part in ["1/2", "2/2"] {
        says(
            command(&arm, "out", &["--shard", part, "--items", "items"]),
            0,
        );
        assert!(!arm.path("out").exists());
    }
    let said = says(command(&arm, "out", &["--items", "items", "--json"]), 0);
    let result: serde_json::Value = serde_json::from_str(&said).unwrap();
    assert_eq!(
        (result["verb"].as_str(), result["items"].as_u64()),
        (Some("fleet"), Some(ITEMS as u64))
    );
    assert_eq!(result["types"][0]["robots"], 3);
    let report = Command::new(env!("CARGO_BIN_EXE_exid"))
        .current_dir(arm.folder())
        .args(["report", "out"])
        .output()
        .unwrap();
    assert!(
        String::from_utf8(report.stdout)
            .unwrap()
            .contains("fleet.html")
    );
}

#[test]
fn wrong_use_is_said() {
    let arm = fleet();
    for (further, words) in [
        (&["--shard", "3/2"][..], "1 ≤ i ≤ n"),
        (&["--rate", "2"][..], "between 0 and 1"),
        (&["--timeout", "0"][..], "above 0"),
    ] {
        let said = says(command(&arm, "out", further), 2);
        assert!(said.contains(words), "{said}");
    }
    arm.edit("nights.csv", "recordings", "recording");
    let said = says(command(&arm, "out", &[]), 2);
    assert!(said.contains("did you mean `recordings`?"), "{said}");
}
