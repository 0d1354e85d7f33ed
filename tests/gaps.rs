//! Recordings with holes: twenty rows that lack a value, and 0.4 s that are missing, change no answer beyond its interval,
//! whether periods are averaged or the motion is smoothed.

use flate2::Compression;
use flate2::read::GzDecoder;
use flate2::write::GzEncoder;
use rand::{RngExt, SeedableRng};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::Path;
use std::process::Command;

/// Shares of its own deviation by which an answer may move where a hundredth of the rows is lost: of n rows a share s that is
/// left out moves an estimate by √s deviations, 0.1, and of a hundred estimates the farthest by 2.6 times as much.
const MOVED: f64 = 0.5;

type Lines = Vec<String>;

/// Empties one cell in twenty rows.
fn empty_cells(lines: &mut Lines) {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(11);
    let mut emptied = 0;
    while emptied < 20 {
        let (row, column) = (
            random.random_range(2..lines.len()),
            random.random_range(1..13),
        );
        let mut fields: Vec<&str> = lines[row].split(',').collect();
        if fields.contains(&"") {
            continue;
        }
        fields[column] = "";
        lines[row] = fields.join(",");
        emptied += 1;
    }
}

/// Takes 0.4 s of 72 s out, at 125 Hz.
fn missing_rows(lines: &mut Lines) {
    lines.drain(3331..3381);
}

/// Base parameters with their deviations.
fn answer(holes: &[fn(&mut Lines)], method: &str) -> (BTreeMap<String, [f64; 2]>, Value) {
    let folder = tempfile::tempdir().unwrap();
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/arm6");
    for name in ["problem.toml", "arm6.urdf"] {
        fs::copy(from.join(name), folder.path().join(name)).unwrap();
    }
    for name in ["train.csv.gz", "validation.csv.gz"] {
        let mut text = String::new();
        let packed = File::open(from.join(name)).unwrap();
        GzDecoder::new(packed).read_to_string(&mut text).unwrap();
        let mut lines: Lines = text.lines().map(String::from).collect();
        holes.iter().for_each(|hole| hole(&mut lines));
        let file = File::create(folder.path().join(name)).unwrap();
        let mut packed = GzEncoder::new(file, Compression::fast());
        packed.write_all(lines.join("\n").as_bytes()).unwrap();
        packed.finish().unwrap();
    }
    let mut text = fs::read_to_string(folder.path().join("problem.toml")).unwrap();
    if method == "smoother" {
        let kept = text.lines().filter(|line| !line.starts_with("period"));
        text = kept.collect::<Vec<_>>().join("\n");
    }
    fs::write(folder.path().join("problem.toml"), text).unwrap();
    let mut fit = Command::new(env!("CARGO_BIN_EXE_exid"));
    fit.current_dir(folder.path())
        .args(["fit", "problem.toml", "--quiet", "--out", "out"]);
    let set = format!("recordings.differentiation.method=\"{method}\"");
    let output = fit.args(["--set", &set]).output().unwrap();
    assert_eq!(
        output.status.code(),
        Some(0),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let text = fs::read_to_string(folder.path().join("out/result.json")).unwrap();
    let result: Value = serde_json::from_str(&text).unwrap();
    let parameters = result["base_parameters"].as_array().unwrap().iter();
    let values = parameters.map(|p| {
        let number = |key: &str| p[key].as_f64().unwrap();
        let name = p["expression"].as_str().unwrap().to_string();
        (name, [number("value"), number("std_dev")])
    });
    (values.collect(), result)
}

#[test]
fn holes_change_no_answer_beyond_its_interval_and_are_said() {
    for method in ["fourier", "smoother"] {
        let (whole, _) = answer(&[], method);
        assert!(whole.len() > 40);
        let holes: [fn(&mut Lines); 2] = [missing_rows, empty_cells];
        for (hole, gap, cells) in [
            (&holes[..1], true, false),
            (&holes[1..], false, true),
            (&holes[..], true, true),
        ] {
            let (found, result) = answer(hole, method);
            for (name, [value, deviation]) in &whole {
                let moved = (found[name][0] - value).abs() / deviation;
                assert!(
                    moved < MOVED,
                    "{method}: {name} moved by {moved} deviations"
                );
                let grown = found[name][1] / deviation;
                assert!((0.9..1.1).contains(&grown), "{method}: {name}: {grown}");
            }
            let mistakes = result["mistakes"].to_string();
            assert_eq!(mistakes.contains("missing-samples"), gap);
            assert_eq!(mistakes.contains("missing-values"), cells);
        }
    }
}
