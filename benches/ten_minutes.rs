//! The whole of `exid fit` on ten minutes of a seven-joint arm at 1 kHz, a table of 170 MB: reading, bandwidth,
//! maximum likelihood with transition speeds, intervals, predictions and report. Nothing is said of the period, and
//! positions are exact, so that no row can be left out. Prints the most memory that the program held (Linux).

use criterion::{Criterion, criterion_group, criterion_main};
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;
use tempfile::TempDir;

const JOINTS: usize = 7;

/// The arm with what both problem files say; `more` goes into the tables that follow.
fn problem(recording: &str, more: &str) -> String {
    format!(
        "name = \"ten_minutes\"\n[robot]\nmdh = \"panda_like.mdh.toml\"\n[drive]\n\
         effects = [\"coulomb_friction\", \"viscous_friction\", \"torque_offset\"]\n\
         rotor_inertia = [0.6, 0.6, 0.5, 0.5, 0.2, 0.2, 0.15]\n[recordings]\ntrain = [\"{recording}\"]\n\
         signal = \"torque\"\nrate = 1000.0\n{more}"
    )
}

fn simulated() -> String {
    let values: String = (1..=JOINTS)
        .map(|j| {
            format!(
                "\"joint{j}.Fc\" = 1.{j}\n\"joint{j}.coulomb_friction.w\" = 0.005\n\"joint{j}.Fv\" = 0.5\n\
                 \"joint{j}.torque_offset.offset\" = 0.1\n"
            )
        })
        .collect();
    problem(
        "train.csv",
        &format!(
            "period = 20.0\n[simulate]\ntrajectory = \"random\"\nmode = \"inverse\"\nperiods = 30\n\
             noise = [0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2]\n[simulate.values]\n{values}"
        ),
    )
}

fn exid(folder: &Path, arguments: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_exid"))
        .current_dir(folder)
        .args(arguments)
        .stdout(Stdio::null())
        .spawn()
        .expect("the program starts")
}

/// Waits for a program; most memory that it was seen to hold, in megabytes.
fn most_memory(mut child: Child) -> f64 {
    let status = format!("/proc/{}/status", child.id());
    let mut most: f64 = 0.0;
    loop {
        if let Ok(text) = fs::read_to_string(&status) {
            let line = text.lines().find_map(|l| l.strip_prefix("VmHWM:"));
            let kib = line.and_then(|l| l.trim().trim_end_matches(" kB").parse().ok());
            most = most.max(kib.unwrap_or(0.0) * 1024e-6);
        }
        match child.try_wait().expect("the program can be waited for") {
            Some(status) => {
                assert!(status.success(), "the fit succeeds");
                return most;
            }
            None => std::thread::sleep(Duration::from_millis(5)),
        }
    }
}

fn fit_of_ten_minutes(criterion: &mut Criterion) {
    let folder = TempDir::new().expect("a folder for the recording");
    let at = folder.path();
    let robot =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/panda_like/panda_like.mdh.toml");
    fs::copy(robot, at.join("panda_like.mdh.toml")).expect("the robot is copied");
    fs::write(at.join("simulate.toml"), simulated()).expect("a problem file");
    fs::write(at.join("fit.toml"), problem("made/train.csv", "")).expect("a problem file");
    most_memory(exid(at, &["simulate", "simulate.toml", "--out", "made"]));
    let fit = || most_memory(exid(at, &["fit", "fit.toml", "--out", "fit"]));
    println!("ten_minutes: {:.0} MB at most", fit());
    let mut group = criterion.benchmark_group("ten_minutes");
    group.sample_size(10);
    group.bench_function("fit", |bencher| bencher.iter(fit));
    group.finish();
}

criterion_group!(benches, fit_of_ten_minutes);
criterion_main!(benches);
