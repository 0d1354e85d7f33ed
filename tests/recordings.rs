//! Recordings that are not what their files seem, through the program itself, made from those of `problems/arm6`: a held-out
//! file with rows of the fitted one, and samples that are repeated or interpolated to a higher rate.

use flate2::read::GzDecoder;
use serde_json::Value;
use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::{Command, Output};

/// Rows of the file for one sample.
const FACTOR: usize = 4;

/// The arm with `train.csv` and `validation.csv` in a folder, its recordings as rows of numbers.
struct Arm {
    folder: tempfile::TempDir,
    header: String,
    train: Vec<Vec<f64>>,
}

impl Arm {
    fn new() -> Self {
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/arm6");
        let folder = tempfile::tempdir().unwrap();
        let problem = fs::read_to_string(source.join("problem.toml")).unwrap();
        let problem = problem.replace(".csv.gz", ".csv");
        fs::write(folder.path().join("problem.toml"), problem).unwrap();
        fs::copy(source.join("arm6.urdf"), folder.path().join("arm6.urdf")).unwrap();
        let text = |name: &str| {
            let mut text = String::new();
            let file = fs::File::open(source.join(name)).unwrap();
            GzDecoder::new(file).read_to_string(&mut text).unwrap();
            text
        };
        fs::write(
            folder.path().join("validation.csv"),
            text("validation.csv.gz"),
        )
        .unwrap();
        let train = text("train.csv.gz");
        let (header, rows) = train.split_once('\n').unwrap();
        let row = |line: &str| line.split(',').map(|x| x.parse().unwrap()).collect();
        Self {
            header: header.to_string(),
            train: rows.lines().map(row).collect(),
            folder,
        }
    }

    /// Writes rows, their first column the time, with so many digits.
    fn write(&self, name: &str, rows: &[Vec<f64>], digits: usize) {
        let mut text = self.header.clone();
        for row in rows {
            let row: Vec<String> = row.iter().map(|x| format!("{x:.digits$e}")).collect();
            text.push('\n');
            text.push_str(&row.join(","));
        }
        fs::write(self.folder.path().join(name), text + "\n").unwrap();
    }

    fn run(&self, verb: &str, further: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_exid"));
        command.args([verb, "problem.toml", "--quiet", "--json", "--out", "out"]);
        command.args(further).current_dir(self.folder.path());
        command.output().unwrap()
    }

    fn fit(&self) -> Value {
        let output = self.run("fit", &[]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{said}");
        serde_json::from_slice(&output.stdout).unwrap()
    }
}

#[test]
fn what_is_fitted_is_not_held_out() {
    let arm = Arm::new();
    arm.write("train.csv", &arm.train[..6000], 16);
    // A piece of the same run, from its own start on, and with fewer digits.
    let mut piece = arm.train[5000..].to_vec();
    let start = piece[0][0];
    piece.iter_mut().for_each(|row| row[0] -= start);
    arm.write("validation.csv", &piece, 8);
    for verb in ["fit", "diagnose"] {
        let output = arm.run(verb, &[]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{verb}: {said}");
        for part in [
            "validation.csv:2: 8.0000 s of it (25.0 % of its samples) are also in train.csv",
            "samples 1 to 1000 are those of the other from 5001 on",
            "leave recordings.validation out",
        ] {
            assert!(said.contains(part), "{verb}: {said}");
        }
        assert!(!arm.folder.path().join("out").exists());
    }
    let output = arm.run("check", &[]);
    let said = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(3));
    assert!(said.contains("held-out-is-fitted"), "{said}");
}

/// An encoder that slips is no physics: it stops a diagnosis where one recording alone has it, too.
#[test]
fn a_position_that_jumps_is_refused() {
    let arm = Arm::new();
    let mut slipped = arm.train.clone();
    slipped[4000..].iter_mut().for_each(|row| row[1] += 0.3);
    arm.write("train.csv", &slipped, 16);
    for verb in ["fit", "diagnose"] {
        let output = arm.run(verb, &[]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{verb}: {said}");
        assert!(
            said.contains("train.csv:4002: a1:") && said.contains("[position-jumps]"),
            "{verb}: {said}"
        );
    }
}

#[test]
fn a_recording_counts_once() {
    let arm = Arm::new();
    arm.write("train.csv", &arm.train, 16);
    let path = |name: &str| arm.folder.path().join(name);
    std::os::unix::fs::symlink(path("train.csv"), path("again.csv")).unwrap();
    let train = "recordings.train=[\"train.csv\", \"./again.csv\"]";
    let output = arm.run("fit", &["--set", train]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(
        said.contains("100.0 % of its samples) are given twice"),
        "{said}"
    );
}

#[test]
fn recovers_the_fit_of_the_samples_from_files_with_more_rows() {
    let arm = Arm::new();
    arm.write("train.csv", &arm.train, 16);
    let plain = arm.fit();
    let step = arm.train[1][0] / FACTOR as f64;
    let written = |between: fn(f64, f64, f64) -> f64| -> Vec<Vec<f64>> {
        let pairs = arm.train.windows(2);
        let rows = pairs.flat_map(|pair| {
            (0..FACTOR).map(move |part| {
                let part = part as f64 / FACTOR as f64;
                let values = pair[0].iter().zip(&pair[1]);
                values.map(|(a, b)| between(*a, *b, part)).collect()
            })
        });
        let mut rows: Vec<Vec<f64>> = rows.chain(arm.train.last().cloned()).collect();
        let stamps = rows.iter_mut().enumerate();
        stamps.for_each(|(k, row)| row[0] = step * k as f64);
        rows
    };
    let repeated = written(|a, _, _| a);
    let interpolated = written(|a, b, part| a + part * (b - a));
    for (rows, how) in [(repeated, "repeated"), (interpolated, "straight lines")] {
        arm.write("train.csv", &rows, 9);
        let found = arm.fit();
        let notes = found["notes"].to_string();
        assert!(
            notes.contains("were taken at 125.0000 Hz") && notes.contains(how),
            "{notes}"
        );
        let all = |of: &Value| of["parameters"].as_array().unwrap().clone();
        for (a, b) in all(&plain).iter().zip(&all(&found)) {
            let Some(deviation) = a["std_dev"].as_f64().filter(|_| a["source"] == "data") else {
                continue;
            };
            // Nine digits of every number, where the plain file has all.
            let value = |of: &Value| of["value"].as_f64().unwrap();
            assert!(
                (value(a) - value(b)).abs() <= 0.01 * deviation,
                "{how}: {a} {b}"
            );
            let width = b["std_dev"].as_f64().unwrap();
            assert!((width / deviation - 1.0).abs() <= 0.01, "{how}: {a} {b}");
        }
    }
}
