//! A problem in a folder of its own, designed by the program, and its files as numbers.

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

pub struct Bench {
    folder: TempDir,
    problem: PathBuf,
}

impl Bench {
    /// A shipped problem.
    pub fn shipped(name: &str) -> Self {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        Self {
            folder: tempfile::tempdir().unwrap(),
            problem: root.join("problems").join(name).join("problem.toml"),
        }
    }

    /// A problem with its robot.
    pub fn new(problem: &str, urdf: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("arm.urdf"), urdf).unwrap();
        let path = folder.path().join("problem.toml");
        fs::write(&path, problem).unwrap();
        Self {
            folder,
            problem: path,
        }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// `exid design` into the folder `out`, with values of keys.
    pub fn command(&self, out: &str, keys: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_exid"));
        command
            .arg("design")
            .arg(&self.problem)
            .args(["--quiet", "--out"])
            .arg(self.path(out));
        for key in keys {
            command.args(["--set", key]);
        }
        command
    }

    /// Runs it, with the exit code that is expected; the result.
    pub fn design(&self, out: &str, keys: &[&str], code: i32) -> Value {
        let Output { status, stderr, .. } = self.command(out, keys).output().unwrap();
        let words = String::from_utf8_lossy(&stderr);
        assert_eq!(status.code(), Some(code), "{words}");
        self.result(out)
    }

    pub fn result(&self, out: &str) -> Value {
        let text = fs::read_to_string(self.path(out).join("result.json")).unwrap();
        serde_json::from_str(&text).unwrap()
    }

    /// Rows of a trajectory: t, positions, velocities, accelerations.
    pub fn trajectory(&self, out: &str, name: &str) -> Vec<Vec<f64>> {
        let text = fs::read_to_string(self.path(out).join(name)).unwrap();
        let row = |line: &str| line.split(',').map(|x| x.parse().unwrap()).collect();
        text.lines().skip(1).map(row).collect()
    }
}

/// The criterion's value.
pub fn value(result: &Value) -> f64 {
    result["criterion_value"].as_f64().unwrap()
}

/// Expected standard deviations of what the motion determines.
pub fn deviations(result: &Value) -> Vec<f64> {
    let all = result["expected_std_dev"].as_array().unwrap();
    all.iter().filter_map(|d| d["std_dev"].as_f64()).collect()
}

/// Whether every margin is nonnegative up to 0.1 % of its limit.
pub fn holds(result: &Value) -> bool {
    let margins = result["worst_margins"].as_array().unwrap();
    margins
        .iter()
        .all(|m| m["relative"].as_f64().unwrap() >= -1e-3)
}
