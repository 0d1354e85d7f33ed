//! A run that is killed or interrupted at any moment, or that lacks memory or space, leaves the earlier result or its own, whole,
//! and nothing that the next run does not remove.
//!
//! `EXID_ENDINGS=200 cargo test --release --test whole_or_not -- --nocapture` kills and interrupts so many runs of each kind.

mod common;

use common::arm::{Arm, EVERY_SAMPLE, Noise};
use common::interrupting;
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Child, Command};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Kills without another word; interrupts are a quarter of them.
const KILLS: usize = 50;

/// s; a run that is interrupted ends within.
const SOON: f64 = 2.0;

/// The number of runs of a kind to be ended, a usual one unless the environment states another.
fn endings(usual: usize) -> usize {
    let stated = std::env::var("EXID_ENDINGS");
    stated.map_or(usual, |count| {
        count.parse().expect("EXID_ENDINGS is a number")
    })
}

/// Periods of 200 samples: enough that writing the tables takes a noticeable part of the run.
const PERIODS: usize = 40;

/// Evenly spread over 0 .. 1.
fn share(random: &mut Noise) -> f64 {
    0.5 + 0.5 * random.next()
}

/// The run of a version: its own seed, name and recording, so that each file tells whose it is.
fn run(arm: &Arm, version: usize) -> Command {
    let recording = format!("train_{version}.csv");
    if !arm.path(&recording).exists() {
        fs::hard_link(arm.path("train.csv"), arm.path(&recording)).unwrap();
    }
    let (seed, name) = (version.to_string(), format!("name=version {version}."));
    let train = format!("recordings.train=[\"{recording}\"]");
    let mut command = arm.fit("out", &["--seed", &seed, "--set", &name, "--set", &train]);
    command.args(["--set", EVERY_SAMPLE]);
    command
}

/// Version and rows of the table of a result that is whole; panics where files are missing, torn or of
/// several versions.
fn version_of(out: &Path) -> (usize, usize) {
    let read = |name: &str| {
        fs::read_to_string(out.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    };
    let result: Value = serde_json::from_str(&read("result.json")).unwrap();
    let version = result["seed"].as_u64().unwrap() as usize;
    assert_eq!(result["name"], format!("version {version}."));

    let table = read("predictions.csv");
    assert!(table.ends_with('\n'), "the last row is whole");
    let mut rows = table.lines();
    let fields = rows.next().unwrap().split(',').count();
    let own = format!("train_{version}.csv,train,");
    let mut count = 0;
    for row in rows {
        assert!(row.starts_with(&own), "{row} in version {version}");
        assert_eq!(row.split(',').count(), fields);
        count += 1;
    }

    let page = read("report.html");
    assert!(page.trim_end().ends_with("</html>"), "the page is whole");
    assert!(
        page.contains(&format!("version {version}.")),
        "the page is of version {version}"
    );
    let mut names: Vec<String> = (fs::read_dir(out).unwrap())
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, ["predictions.csv", "report.html", "result.json"]);
    (version, count)
}

/// Whether a partial folder beside the results holds files: the run is writing.
fn is_writing(folder: &Path) -> bool {
    let partial = |name: &str| name.starts_with(".out.partial-");
    (fs::read_dir(folder).unwrap().flatten())
        .filter(|entry| partial(&entry.file_name().to_string_lossy()))
        .any(|entry| fs::read_dir(entry.path()).is_ok_and(|mut files| files.next().is_some()))
}

/// Waits until the run is writing, or has ended.
fn wait_for_writing(child: &mut Child, folder: &Path) {
    while !is_writing(folder) && child.try_wait().unwrap().is_none() {
        sleep(Duration::from_micros(200));
    }
}

/// A folder in which runs are ended before their time.
struct Endings {
    arm: Arm,
    /// Of a run that is left to itself.
    duration: Duration,
    /// The version whose result is there.
    current: usize,
    rows: usize,
    /// Runs that left the earlier result.
    before: usize,
}

impl Endings {
    fn new() -> Self {
        let arm = Arm::new(PERIODS);
        let started = Instant::now();
        assert!(run(&arm, 0).status().unwrap().success());
        let duration = started.elapsed();
        let (current, rows) = version_of(&arm.path("out"));
        assert_eq!(current, 0);
        assert!(rows > 0);
        Self {
            arm,
            duration,
            current,
            rows,
            before: 0,
        }
    }

    /// After the run of a version there is its result or the earlier one, whole; its own if it has finished.
    fn assert_whole(&mut self, version: usize, finished: bool) {
        let (left, rows) = version_of(&self.arm.path("out"));
        assert_eq!(rows, self.rows, "every version has the same samples");
        let is_one = left == self.current || left == version;
        assert!(is_one, "{left} after {version}");
        assert!(!finished || left == version, "a finished run is lost");
        self.before += usize::from(left == self.current);
        self.current = left;
    }

    /// The next run is like any other.
    fn assert_goes_on(&self, version: usize) {
        assert!(run(&self.arm, version).status().unwrap().success());
        assert_eq!(version_of(&self.arm.path("out")), (version, self.rows));
        assert_nothing_is_left_behind(&self.arm);
    }
}

#[test]
fn a_run_killed_at_any_moment_leaves_one_whole_result() {
    let mut all = Endings::new();
    let mut random = Noise(20_26);
    let mut while_writing = 0;
    let kills = endings(KILLS);
    for version in 1..=kills {
        let mut child = run(&all.arm, version).spawn().unwrap();
        let aims_at_writing = version % 2 == 0;
        if aims_at_writing {
            wait_for_writing(&mut child, all.arm.folder());
            sleep(all.duration.mul_f64(0.3 * share(&mut random)));
        } else {
            sleep(all.duration.mul_f64(1.1 * share(&mut random)));
        }
        let writing = is_writing(all.arm.folder());
        let ended = child.try_wait().unwrap().is_some();
        // The process may have ended by now: then there is nothing to kill.
        let _ = child.kill();
        child.wait().unwrap();
        all.assert_whole(version, ended);
        while_writing += usize::from(writing && !ended);
    }
    let before = all.before;
    eprintln!("{kills} kills: {while_writing} while writing, {before} left the earlier result");
    assert!(before > 0 && while_writing > 0, "kills come in time");
    all.assert_goes_on(kills + 1);
}

fn assert_nothing_is_left_behind(arm: &Arm) {
    let hidden: Vec<String> = (fs::read_dir(arm.folder()).unwrap())
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.starts_with('.'))
        .collect();
    assert!(hidden.is_empty(), "left behind: {hidden:?}");
}

/// While a file is read, while the search runs, while results are written.
#[test]
fn a_run_interrupted_at_any_moment_ends_soon_and_leaves_one_whole_result() {
    let mut all = Endings::new();
    let mut random = Noise(7_11);
    let mut latest = Duration::ZERO;
    let interrupts = endings(KILLS / 4);
    for version in 1..=interrupts {
        let mut child = run(&all.arm, version).spawn().unwrap();
        sleep(all.duration.mul_f64(1.1 * share(&mut random)));
        let sent = Instant::now();
        interrupting::send(&mut child);
        let code = child.wait().unwrap().code();
        latest = latest.max(sent.elapsed());
        // None is the signal's own end, before the program could listen to it.
        assert!([Some(130), Some(0), None].contains(&code), "{code:?}");
        all.assert_whole(version, code == Some(0));
    }
    let before = all.before;
    eprintln!(
        "{interrupts} interrupts: {before} left the earlier result, the slowest ended after {latest:?}"
    );
    assert!(latest.as_secs_f64() < SOON, "{latest:?}");
    all.assert_goes_on(interrupts + 1);
}

/// A run under limits of the shell, and what it said.
fn limited(arm: &Arm, version: usize, limits: &str) -> (Option<i32>, String) {
    let whole = run(arm, version);
    let mut command = Command::new("sh");
    command
        .current_dir(arm.folder())
        .args(["-c", &format!("{limits}; exec \"$0\" \"$@\"")])
        .arg(whole.get_program())
        .args(whole.get_args());
    let output = command.output().unwrap();
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code(), words)
}

/// Under each limit the run ends with its result, or with words and the earlier one; gives how many of them failed.
fn assert_failures_are_said(arm: &Arm, limits: &[String], words: &str) -> usize {
    let out = arm.path("out");
    let (mut current, _) = version_of(&out);
    let mut failed = 0;
    for (version, limit) in (current + 1..).zip(limits) {
        let (code, said) = limited(arm, version, limit);
        let (left, _) = version_of(&out);
        match code {
            Some(0) => assert_eq!(left, version, "{limit}: a finished run is lost"),
            _ => {
                assert_eq!(left, current, "{limit}: {said}");
                assert!(said.contains(words), "{limit}: {code:?} {said}");
                failed += 1;
            }
        }
        current = left;
    }
    assert!(run(arm, current + 1).status().unwrap().success());
    assert_nothing_is_left_behind(arm);
    failed
}

/// Address space from less than the program needs to more than it needs, in KiB.
#[test]
fn a_run_without_memory_says_so_and_leaves_the_earlier_result() {
    if !cfg!(target_os = "linux") {
        common::skip("limits of address space are those of Linux");
        return;
    }
    let arm = Arm::new(PERIODS);
    assert!(run(&arm, 0).status().unwrap().success());
    // A process that cannot map its own program ends before its first word.
    let least = (60_000..4_000_000).step_by(20_000).find(|kib| {
        let version = format!("ulimit -v {kib}; exec \"$0\" --version");
        let program = env!("CARGO_BIN_EXE_exid");
        let output = Command::new("sh").args(["-c", &version, program]).output();
        output.unwrap().status.success()
    });
    let least = least.expect("the program starts");
    let limits = (0..24).map(|k| format!("ulimit -v {}", least + 8_000 * k));
    let limits: Vec<String> = limits.collect();
    let failed = assert_failures_are_said(&arm, &limits, "memory");
    eprintln!("{failed} of {} runs lacked memory", limits.len());
    assert!(failed > 0, "limits are tight enough");
}

/// Files that may not become so long, in blocks of the shell's.
#[test]
fn a_result_for_which_there_is_no_space_is_said_and_the_earlier_one_stays() {
    let arm = Arm::new(PERIODS);
    assert!(run(&arm, 0).status().unwrap().success());
    let blocks = [4, 16, 64, 128, 256, 512, 1024];
    let limits = blocks.map(|count| format!("trap '' XFSZ; ulimit -f {count}"));
    let failed = assert_failures_are_said(&arm, &limits, "could not write");
    eprintln!("{failed} of {} runs lacked space", limits.len());
    assert!(failed > 0, "limits are tight enough");
}

#[test]
fn an_output_that_cannot_be_written_is_said_and_a_reader_that_went_away_is_not() {
    let print = |word: &str, to: fs::File| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_exid"));
        command.arg(word).stdout(to).output().unwrap()
    };
    if Path::new("/dev/full").exists() {
        for word in ["effects", "--help", "--version"] {
            let full = fs::File::options().write(true).open("/dev/full").unwrap();
            let output = print(word, full);
            let words = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(1), "{word}: {words}");
            assert!(words.contains("standard output"), "{word}: {words}");
        }
    }
    let mut command = Command::new(env!("CARGO_BIN_EXE_exid"));
    let pipe = std::process::Stdio::piped();
    let mut child = command.arg("effects").stdout(pipe).spawn().unwrap();
    drop(child.stdout.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
}
