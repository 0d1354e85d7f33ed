//! Inputs that would make an answer wrong, each from a good problem: `exid fit` says so of every one, and says nothing of
//! what is good.

use flate2::read::GzDecoder;
use rand::{RngExt, SeedableRng, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde_json::Value;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt::Write;
use std::fs;
use std::io::Read;
use std::ops::Range;
use std::path::Path;
use std::process::{Command, Output};

const TORQUE_CONSTANTS: &str = "[13.1, 13.0, 12.8, 9.2, 9.1, 9.3]";

/// Columns of the recordings.
const TIME: Range<usize> = 0..1;
const POSITIONS: Range<usize> = 1..7;
const SIGNALS: Range<usize> = 7..13;

/// Samples of two periods.
const ROWS: usize = 3000;

/// Seconds between two samples.
const STEP: f64 = 0.008;

/// The shipped six-axis arm with two periods of its recordings, to be made wrong.
struct Inputs {
    header: Vec<String>,
    train: Vec<Vec<f64>>,
    validation: Vec<Vec<f64>>,
    urdf: String,
    problem: String,
}

impl Inputs {
    fn good() -> Self {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/arm6");
        let text = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
        let problem = text("problem.toml").replace(".csv.gz", ".csv");
        let (problem, _) = problem.split_once("\n[simulate]").unwrap();
        let unpacked = |name: &str| {
            let mut text = String::new();
            let file = fs::File::open(folder.join(name)).unwrap();
            GzDecoder::new(file).read_to_string(&mut text).unwrap();
            text
        };
        let rows = |text: &str| -> Vec<Vec<f64>> {
            let lines = text.lines().skip(1).take(ROWS);
            lines
                .map(|line| line.split(',').map(|x| x.parse().unwrap()).collect())
                .collect()
        };
        let train = unpacked("train.csv.gz");
        Self {
            header: train
                .lines()
                .next()
                .unwrap()
                .split(',')
                .map(String::from)
                .collect(),
            train: rows(&train),
            validation: rows(&unpacked("validation.csv.gz")),
            urdf: text("arm6.urdf"),
            problem: problem.to_string(),
        }
    }

    fn both(&mut self, change: impl Fn(&mut Vec<Vec<f64>>)) {
        change(&mut self.train);
        change(&mut self.validation);
    }

    fn each(&mut self, columns: Range<usize>, change: impl Fn(f64) -> f64) {
        self.both(|rows| {
            for row in rows {
                row[columns.clone()]
                    .iter_mut()
                    .for_each(|x| *x = change(*x));
            }
        });
    }

    fn exchange(&mut self, a: usize, b: usize) {
        self.both(|rows| rows.iter_mut().for_each(|row| row.swap(a, b)));
    }

    /// The six columns from one on in the reverse order.
    fn reverse(&mut self, first: usize) {
        self.both(|rows| {
            rows.iter_mut()
                .for_each(|row| row[first..first + 6].reverse())
        });
    }

    fn problem(&mut self, from: &str, to: &str) {
        assert!(self.problem.contains(from), "{from}");
        self.problem = self.problem.replace(from, to);
    }

    fn robot(&mut self, from: &str, to: &str) {
        assert!(self.urdf.contains(from), "{from}");
        self.urdf = self.urdf.replace(from, to);
    }

    /// Every number of some attributes of an element, times a factor.
    fn robot_numbers(&mut self, element: &str, attributes: &[&str], factor: f64) {
        let mut text = String::new();
        for piece in self.urdf.split_inclusive('>') {
            let mut piece = piece.to_string();
            for attribute in attributes {
                let start = format!(" {attribute}=\"");
                if let (true, Some(at)) =
                    (piece.contains(&format!("<{element} ")), piece.find(&start))
                {
                    let (before, rest) = piece.split_at(at + start.len());
                    let (numbers, after) = rest.split_once('"').unwrap();
                    let scaled = numbers
                        .split(' ')
                        .map(|x| (factor * x.parse::<f64>().unwrap()).to_string());
                    let scaled: Vec<String> = scaled.collect();
                    piece = format!("{before}{}\"{after}", scaled.join(" "));
                }
            }
            text.push_str(&piece);
        }
        assert_ne!(self.urdf, text);
        self.urdf = text;
    }

    fn without_inertials(&mut self) {
        while let Some(from) = self.urdf.find("<inertial>") {
            let to = self.urdf.find("</inertial>").unwrap() + "</inertial>".len();
            self.urdf.replace_range(from..to, "");
        }
    }

    fn axis(&mut self, joint: &str, axis: &str) {
        let at = self.urdf.find(&format!("<joint name=\"{joint}\"")).unwrap();
        let (before, after) = self.urdf.split_at(at);
        let from = after.find("<axis xyz=\"").unwrap() + "<axis xyz=\"".len();
        let to = from + after[from..].find('"').unwrap();
        self.urdf = format!("{before}{}{axis}{}", &after[..from], &after[to..]);
    }

    fn without_rate(&mut self) {
        self.problem("rate = 125.0\n", "");
    }

    fn without_time(&mut self, rate: f64) {
        self.problem("rate = 125.0", &format!("rate = {rate:?}"));
        self.header.remove(0);
        self.both(|rows| {
            rows.iter_mut().for_each(|row| {
                row.remove(0);
            })
        });
    }

    fn currents_called_torques(&mut self) {
        self.problem(
            "period = 12.0",
            "period = 12.0\n[recordings.columns]\ntorque = \"i{n}\"",
        );
        self.problem("signal = \"current\"", "signal = \"torque\"");
        self.problem(&format!("torque_constant = {TORQUE_CONSTANTS}"), "");
    }

    fn bounds(&mut self, bound: &str) {
        write!(self.problem, "\n[fit.bounds]\n{bound}\n").unwrap();
    }

    /// Columns that stop at a share of their largest size.
    fn cut_off(&mut self, columns: Range<usize>, share: f64) {
        self.both(|rows| {
            for c in columns.clone() {
                let most = rows.iter().map(|row| row[c].abs()).fold(0.0, f64::max);
                rows.iter_mut()
                    .for_each(|row| row[c] = row[c].clamp(-share * most, share * most));
            }
        });
    }

    fn freeze(&mut self, column: usize) {
        self.both(|rows| {
            let value = rows[ROWS / 3][column];
            rows[ROWS / 3..ROWS / 2]
                .iter_mut()
                .for_each(|row| row[column] = value);
        });
    }

    fn shift(&mut self, columns: Range<usize>, samples: usize) {
        self.both(|rows| {
            let old = rows.clone();
            for (k, row) in rows.iter_mut().enumerate() {
                let from = &old[(k + ROWS - samples) % ROWS];
                row[columns.clone()].copy_from_slice(&from[columns.clone()]);
            }
        });
    }

    /// Thirty samples of each column changed.
    fn strike(&mut self, columns: Range<usize>, change: impl Fn(f64) -> f64) {
        self.both(|rows| {
            let mut rng = ChaCha8Rng::seed_from_u64(1);
            for c in columns.clone() {
                for _ in 0..30 {
                    let row = rng.random_range(0..ROWS);
                    rows[row][c] = change(rows[row][c]);
                }
            }
        });
    }

    fn hold(&mut self, columns: Range<usize>, samples: usize) {
        self.both(|rows| {
            for k in 0..rows.len() {
                let from = rows[k / samples * samples][columns.clone()].to_vec();
                rows[k][columns.clone()].copy_from_slice(&from);
            }
        });
    }

    /// Columns of speeds: differences of the positions over ten samples to each side, changed.
    fn with_velocity(&mut self, change: impl Fn(&[f64]) -> Vec<f64>) {
        self.both(|rows| {
            let old = rows.clone();
            for (k, row) in rows.iter_mut().enumerate() {
                let (before, after) = (&old[(k + ROWS - 2) % ROWS], &old[(k + 2) % ROWS]);
                let speed = |c: usize| (after[c] - before[c]) / (4.0 * STEP);
                let speeds: Vec<f64> = POSITIONS.map(speed).collect();
                row.extend(change(&speeds));
            }
        });
        self.header.extend((1..7).map(|n| format!("dq{n}")));
        self.problem(
            "period = 12.0",
            "period = 12.0\n[recordings.columns]\nvelocity = \"dq{n}\"",
        );
    }

    /// Everything but time in another order.
    fn shuffle(&mut self) {
        self.both(|rows| {
            let times: Vec<f64> = rows.iter().map(|row| row[0]).collect();
            rows.shuffle(&mut ChaCha8Rng::seed_from_u64(2));
            rows.iter_mut().zip(times).for_each(|(row, t)| row[0] = t);
        });
    }

    fn drop_rows(&mut self, is_missing: impl Fn(usize) -> bool) {
        self.both(|rows| {
            let mut k = 0;
            rows.retain(|_| {
                k += 1;
                !is_missing(k - 1)
            });
        });
    }

    fn noise_for_signals(&mut self) {
        self.both(|rows| {
            let mut rng = ChaCha8Rng::seed_from_u64(3);
            for row in rows {
                row[SIGNALS]
                    .iter_mut()
                    .for_each(|x| *x = rng.random_range(-1.0..1.0));
            }
        });
    }

    /// What a verb makes of them.
    fn run(&self, verb: &str) -> Output {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
        write("arm6.urdf", &self.urdf);
        write("problem.toml", &self.problem);
        for (name, rows) in [
            ("train.csv", &self.train),
            ("validation.csv", &self.validation),
        ] {
            let mut text = self.header.join(",") + "\n";
            for row in rows {
                let fields: Vec<String> = row.iter().map(f64::to_string).collect();
                writeln!(text, "{}", fields.join(",")).unwrap();
            }
            write(name, &text);
        }
        let mut command = Command::new(env!("CARGO_BIN_EXE_exid"));
        command.current_dir(folder.path());
        command.args([verb, "problem.toml", "--json", "--out", "out"]);
        command.output().unwrap()
    }

    /// What `exid fit` says that is not in every answer.
    fn said(&self) -> String {
        let output = self.run("fit");
        let mut said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(said.is_empty(), output.status.success(), "{said}");
        let Ok(result) = serde_json::from_slice::<Value>(&output.stdout) else {
            return said;
        };
        for mistake in result["mistakes"].as_array().unwrap() {
            if mistake["severity"] != "note" {
                writeln!(
                    said,
                    "{} [{}]",
                    mistake["message"],
                    mistake["code"].as_str().unwrap()
                )
                .unwrap();
            }
        }
        let always = [
            "The covariance across channels",
            "No recording was averaged",
        ];
        for note in result["notes"].as_array().unwrap() {
            let note = note.as_str().unwrap();
            if !always.iter().any(|known| note.starts_with(known)) {
                writeln!(said, "{note}").unwrap();
            }
        }
        said
    }
}

/// What is changed, by what name, and what is said of it.
struct Case {
    name: &'static str,
    says: &'static str,
    change: fn(&mut Inputs),
}

const fn case(name: &'static str, says: &'static str, change: fn(&mut Inputs)) -> Case {
    Case { name, says, change }
}

#[rustfmt::skip]
const MISTAKES: &[Case] = &[
    case("positions in degrees", "position-in-degrees", |x| x.each(POSITIONS, f64::to_degrees)),
    case("one position in degrees", "position-in-degrees", |x| x.each(3..4, f64::to_degrees)),
    case("positions in turns", "signal-scale", |x| x.each(POSITIONS, |q| q / TAU)),
    case("positions in milliradians", "position-beyond-limits", |x| x.each(POSITIONS, |q| 1e3 * q)),
    case("positions in counts", "position-beyond-limits", |x| x.each(POSITIONS, |q| (q * 65536.0 / TAU).round())),
    case("positions of the motors", "position-beyond-limits", |x| x.each(POSITIONS, |q| 100.0 * q)),
    case("position of joint 1 with the wrong sign", "position-sign", |x| x.each(1..2, |q| -q)),
    case("position of joint 2 with the wrong sign", "position-sign", |x| x.each(2..3, |q| -q)),
    case("position of joint 4 with the wrong sign", "signal-sign", |x| x.each(4..5, |q| -q)),
    case("all positions with the wrong sign", "signal-sign", |x| x.each(POSITIONS, |q| -q)),
    case("position of joint 2 a quarter turn off", "position", |x| x.each(2..3, |q| q + FRAC_PI_2)),
    case("position of joint 3 a quarter turn off", "position", |x| x.each(3..4, |q| q + FRAC_PI_2)),
    case("position of joint 4 a quarter turn off", "position-beyond-limits", |x| x.each(4..5, |q| q + FRAC_PI_2)),
    case("position of joint 5 a quarter turn off", "position-beyond-limits", |x| x.each(5..6, |q| q + FRAC_PI_2)),
    case("one position that goes round at half a turn", "position-jumps", |x| x.each(6..7, |q| (q + 1.2 + PI).rem_euclid(TAU) - PI)),
    case("positions of joints 2 and 3 exchanged", "joint-order", |x| x.exchange(2, 3)),
    case("positions of joints 4 and 5 exchanged", "joint-order", |x| x.exchange(4, 5)),
    case("positions of joints 1 and 2 exchanged", "position", |x| x.exchange(1, 2)),
    case("positions of joints 5 and 6 exchanged", "position", |x| x.exchange(5, 6)),
    case("positions of joints 1 and 6 exchanged", "position", |x| x.exchange(1, 6)),
    case("currents of joints 2 and 3 exchanged", "joint-order", |x| x.exchange(8, 9)),
    case("currents of joints 1 and 2 exchanged", "joint-order", |x| x.exchange(7, 8)),
    case("currents of joints 4 and 5 exchanged", "joint-order", |x| x.exchange(10, 11)),
    case("currents of joints 5 and 6 exchanged", "joint-order", |x| x.exchange(11, 12)),
    case("currents of joints 1 and 6 exchanged", "joint-order", |x| x.exchange(7, 12)),
    case("positions in the reverse order", "position", |x| x.reverse(1)),
    case("currents in the reverse order", "joint-order", |x| x.reverse(7)),
    case("joints in another order", "joint-order", |x| x.problem("urdf = \"arm6.urdf\"", "urdf = \"arm6.urdf\"\njoints = [\"a2\", \"a1\", \"a3\", \"a4\", \"a5\", \"a6\"]")),
    case("time in milliseconds", "time-unit", |x| x.each(TIME, |t| 1e3 * t)),
    case("time in microseconds", "time-unit", |x| x.each(TIME, |t| 1e6 * t)),
    case("time in nanoseconds", "time-unit", |x| x.each(TIME, |t| 1e9 * t)),
    case("time in milliseconds and no rate", "time-unit", |x| { x.without_rate(); x.each(TIME, |t| 1e3 * t) }),
    case("time in microseconds and no rate", "time-unit", |x| { x.without_rate(); x.each(TIME, |t| 1e6 * t) }),
    case("time in minutes", "the rate given is 125 Hz", |x| x.each(TIME, |t| t / 60.0)),
    case("time in minutes and no rate", "less than one period", |x| { x.without_rate(); x.each(TIME, |t| t / 60.0) }),
    case("time twice as fast", "velocity-beyond-limits", |x| { x.without_rate(); x.each(TIME, |t| 0.5 * t) }),
    case("time ten times as slow", "period-wrong", |x| { x.without_rate(); x.each(TIME, |t| 10.0 * t) }),
    case("a rate of 250.0 Hz", "the rate given is", |x| x.problem("rate = 125.0", "rate = 250.0")),
    case("a rate of 62.5 Hz", "the rate given is", |x| x.problem("rate = 125.0", "rate = 62.5")),
    case("no time and twice the rate", "velocity-beyond-limits", |x| x.without_time(250.0)),
    case("no time and half the rate", "period-wrong", |x| x.without_time(62.5)),
    case("no time and ten times the rate", "less than one period", |x| x.without_time(1250.0)),
    case("time that runs ever faster", "clock-drift", |x| { x.without_rate(); x.each(TIME, |t| t + 1e-3 * t * t / 72.0) }),
    case("a period of 6.0 s", "period-wrong", |x| x.problem("period = 12.0", "period = 6.0")),
    case("a period of 4.0 s", "period-wrong", |x| x.problem("period = 12.0", "period = 4.0")),
    case("a period of 1.0 s", "period-wrong", |x| x.problem("period = 12.0", "period = 1.0")),
    case("a period of 11.0 s", "period-wrong", |x| x.problem("period = 12.0", "period = 11.0")),
    case("a period of 13.0 s", "period-wrong", |x| x.problem("period = 12.0", "period = 13.0")),
    case("a period of 12.0036 s", "period-wrong", |x| x.problem("period = 12.0", "period = 12.0036")),
    case("a period of 12.012 s", "period-wrong", |x| x.problem("period = 12.0", "period = 12.012")),
    case("currents in milliamperes", "effort-beyond-limits", |x| x.each(SIGNALS, |i| 1e3 * i)),
    case("one current in milliamperes", "effort-beyond-limits", |x| x.each(9..10, |i| 1e3 * i)),
    case("currents ten times too large", "effort-beyond-limits", |x| x.each(SIGNALS, |i| 10.0 * i)),
    case("current of joint 2 with the wrong sign", "signal-sign", |x| x.each(8..9, |i| -i)),
    case("current of joint 6 with the wrong sign", "signal-sign", |x| x.each(12..13, |i| -i)),
    case("all currents with the wrong sign", "signal-sign", |x| x.each(SIGNALS, |i| -i)),
    case("currents without their sign", "effort-magnitude", |x| x.each(SIGNALS, f64::abs)),
    case("one current without its sign", "signal-sign", |x| x.each(9..10, f64::abs)),
    case("torque constants negative", "signal-sign", |x| x.problem(TORQUE_CONSTANTS, "[-13.1, -13.0, -12.8, -9.2, -9.1, -9.3]")),
    case("torque constants negative at joint 2", "signal-sign", |x| x.problem(TORQUE_CONSTANTS, "[13.1, -13.0, 12.8, 9.2, 9.1, 9.3]")),
    case("torque constants in thousandths", "signal-scale", |x| x.problem(TORQUE_CONSTANTS, "[0.0131, 0.0130, 0.0128, 0.0092, 0.0091, 0.0093]")),
    case("torque constants times the ratio twice", "effort-beyond-limits", |x| x.problem(TORQUE_CONSTANTS, "[1310, 1300, 1280, 920, 910, 930]")),
    case("torque constants of the motors", "signal-scale", |x| x.problem(TORQUE_CONSTANTS, "[0.131, 0.13, 0.128, 0.092, 0.091, 0.093]")),
    case("torque constants ten times too large at joint 2", "effort-beyond-limits", |x| x.problem(TORQUE_CONSTANTS, "[13.1, 130.0, 12.8, 9.2, 9.1, 9.3]")),
    case("torque constants of zero", "the value is 0", |x| x.problem(TORQUE_CONSTANTS, "[13.1, 0.0, 12.8, 9.2, 9.1, 9.3]")),
    case("torque constants of joints 3 and 4 exchanged", "misses something", |x| x.problem(TORQUE_CONSTANTS, "[13.1, 13.0, 9.2, 12.8, 9.1, 9.3]")),
    case("currents called torques", "signal-scale", |x| x.currents_called_torques()),
    case("one current cut off", "saturated", |x| x.cut_off(8..9, 0.7)),
    case("all currents cut off", "saturated", |x| x.cut_off(SIGNALS, 0.8)),
    case("one position cut off", "misses something", |x| x.cut_off(1..2, 0.7)),
    case("a current that stands still", "saturated", |x| x.each(9..10, |_| 0.4)),
    case("a current of zero", "saturated", |x| x.each(9..10, |_| 0.0)),
    case("currents of zero", "no solution", |x| x.each(SIGNALS, |_| 0.0)),
    case("a position that stands still", "explains next to nothing", |x| x.each(3..4, |_| 0.4)),
    case("a current that freezes for a while", "stuck", |x| x.freeze(8)),
    case("a position that freezes for a while", "position-jumps", |x| x.freeze(2)),
    case("currents that are late by 80 ms", "delay", |x| x.shift(SIGNALS, 10)),
    case("currents that are late by 24 ms", "delay", |x| x.shift(SIGNALS, 3)),
    case("positions that are late by 80 ms", "delay", |x| x.shift(POSITIONS, 10)),
    case("one current that is late by 80 ms", "delay", |x| x.shift(8..9, 10)),
    case("currents with spikes", "spikes", |x| x.strike(SIGNALS, |i| 50.0 * i)),
    case("one current of 1e308", "the value is", |x| x.train[100][8] = 1e308),
    case("one position of 1e300", "the value is", |x| x.train[100][3] = 1e300),
    case("one current of 1e30", "stand out", |x| x.train[100][8] = 1e30),
    case("one position of 1e30", "stand out", |x| x.train[100][3] = 1e30),
    case("positions that drop out to zero", "spikes", |x| x.strike(POSITIONS, |_| 0.0)),
    case("samples that are held", "samples-held", |x| x.hold(1..13, 5)),
    case("currents that are held", "samples-held", |x| x.hold(SIGNALS, 5)),
    case("gravity upside down", "gravity-direction", |x| x.problem("urdf = \"arm6.urdf\"", "urdf = \"arm6.urdf\"\ngravity = [0.0, 0.0, 9.81]")),
    case("gravity of zero", "gravity-size", |x| x.problem("urdf = \"arm6.urdf\"", "urdf = \"arm6.urdf\"\ngravity = [0.0, 0.0, 0.0]")),
    case("gravity along x", "gravity-direction", |x| x.problem("urdf = \"arm6.urdf\"", "urdf = \"arm6.urdf\"\ngravity = [9.81, 0.0, 0.0]")),
    case("gravity in millimetres", "gravity-size", |x| x.problem("urdf = \"arm6.urdf\"", "urdf = \"arm6.urdf\"\ngravity = [0.0, 0.0, -9810.0]")),
    case("gravity in units of itself", "gravity-size", |x| x.problem("urdf = \"arm6.urdf\"", "urdf = \"arm6.urdf\"\ngravity = [0.0, 0.0, -1.0]")),
    case("a link of 1500 kg", "outlying-mass", |x| x.robot("mass value=\"11\"", "mass value=\"1500\"")),
    case("masses in grams", "signal-scale", |x| x.robot_numbers("mass", &["value"], 1e3)),
    case("a negative mass", "not negative", |x| x.robot("mass value=\"11\"", "mass value=\"-11\"")),
    case("inertials that are known and absent", "no-mass", |x| { x.without_inertials(); x.problem("urdf = \"arm6.urdf\"", "urdf = \"arm6.urdf\"\ninertials = \"known\"") }),
    case("limits in degrees", "limits-in-degrees", |x| x.robot_numbers("limit", &["lower", "upper"], 180.0 / PI)),
    case("roll, pitch and yaw in degrees", "angles-in-degrees", |x| x.robot("<origin xyz=\"0 0 0.42\"/>", "<origin xyz=\"0 0 0.42\" rpy=\"90 0 0\"/>")),
    case("lengths in millimetres", "signal-scale", |x| x.robot_numbers("origin", &["xyz"], 1e3)),
    case("inertias in gram millimetres squared", "signal-scale", |x| x.robot_numbers("inertia", &["ixx", "iyy", "izz"], 1e9)),
    case("an axis that points the other way", "position-sign", |x| x.axis("a2", "0 -1 0")),
    case("the wrong axis of joint 3", "misses something", |x| x.axis("a3", "1 0 0")),
    case("the wrong axis of joint 5", "misses something", |x| x.axis("a5", "1 0 0")),
    case("a locked joint that moves", "locked-joint-moves", |x| x.problem("urdf = \"arm6.urdf\"", "urdf = \"arm6.urdf\"\nlocked = { a6 = 0.0 }")),
    case("a validation that is the training", "is not held out", |x| x.validation = x.train.clone()),
    case("a validation that is a part of the training", "is not held out", |x| x.validation = x.train[200..].to_vec()),
    case("a position side that is not that of the data", "misses something", |x| { x.problem("[drive]", "[drive]\nratio = [100.0, 100.0, 100.0, 100.0, 100.0, 100.0]"); x.problem("signal = \"current\"", "signal = \"current\"\nposition_side = \"motor\"") }),
    case("speeds in degrees per second", "velocity-factor", |x| x.with_velocity(|v| v.iter().map(|v| v.to_degrees()).collect())),
    case("speeds in turns per minute", "velocity-factor", |x| x.with_velocity(|v| v.iter().map(|v| v * 60.0 / TAU).collect())),
    case("speeds of other joints", "velocity-order", |x| x.with_velocity(|v| vec![v[1], v[0], v[2], v[3], v[4], v[5]])),
    case("speeds with the wrong sign at joint 3", "velocity-factor", |x| x.with_velocity(|v| vec![v[0], v[1], -v[2], v[3], v[4], v[5]])),
    case("speeds of the motors", "velocity-factor", |x| x.with_velocity(|v| v.iter().map(|v| 100.0 * v).collect())),
    case("a row that is not a number", "lack a value", |x| x.train[100][8] = f64::NAN),
    case("rows in any order", "explains next to nothing", |x| x.shuffle()),
    case("a third of the rows missing", "missing-samples", |x| x.drop_rows(|k| k % 10 < 3)),
    case("two seconds missing", "missing-samples", |x| x.drop_rows(|k| (400..650).contains(&k))),
    case("rotor inertias at the motor", "misses something", |x| x.problem("[1.40, 1.50, 1.10, 0.35, 0.34, 0.33]", "[1.4e-4, 1.5e-4, 1.1e-4, 3.5e-5, 3.4e-5, 3.3e-5]")),
    case("rotor inertias a thousand times too large", "misses something", |x| x.problem("[1.40, 1.50, 1.10, 0.35, 0.34, 0.33]", "[1400, 1500, 1100, 350, 340, 330]")),
    case("a validation with a load", "misses something", |x| x.validation.iter_mut().for_each(|row| { row[8] *= 1.5; row[9] *= 1.5; })),
    case("currents that are noise", "explains next to nothing", |x| x.noise_for_signals()),
    case("a bound that the estimator does not keep", "keep bounds on bodies", |x| x.bounds("\"link3.mass\" = [0.5, 1.0]")),
    case("a total mass that the estimator does not keep", "keep bounds on bodies", |x| x.bounds("total_mass = [0.5, 1.0]")),
    case("currents in steps of half an ampere", "coarse-signal", |x| x.each(SIGNALS, |i| (2.0 * i).round() / 2.0)),
    case("positions in steps of a degree", "coarse-position", |x| x.each(POSITIONS, |q| q.to_degrees().round().to_radians())),
];

#[rustfmt::skip]
const GOOD: &[Case] = &[
    case("as it is", "", |_| ()),
    case("without a rate", "", |x| x.without_rate()),
    case("without a period", "", |x| x.problem("period = 12.0\n", "")),
    case("time that starts late", "", |x| x.each(TIME, |t| t + 1.0e6)),
    case("without time", "", |x| x.without_time(125.0)),
    case("another estimator", "", |x| x.problem("maximum_likelihood", "wls")),
    case("no bodies in the robot file", "", |x| x.without_inertials()),
    case("with speeds", "", |x| x.with_velocity(<[f64]>::to_vec)),
    case("one period for validation", "", |x| x.validation.truncate(ROWS / 2)),
    case("without validation", "", |x| x.problem("validation = [\"validation.csv\"]\n", "")),
    case("a joint that is locked and stands", "", |x| { x.each(6..7, |_| 0.3); x.each(12..13, |_| 0.0); x.problem("urdf = \"arm6.urdf\"", "urdf = \"arm6.urdf\"\nlocked = { a6 = 0.3 }"); }),
    case("gravity of another town", "", |x| x.problem("urdf = \"arm6.urdf\"", "urdf = \"arm6.urdf\"\ngravity = [0.0, 0.0, -9.80665]")),
];

#[test]
fn no_mistake_is_answered_in_silence() {
    let silent: Vec<String> = MISTAKES
        .par_iter()
        .filter_map(|Case { name, says, change }| {
            let mut inputs = Inputs::good();
            change(&mut inputs);
            let said = inputs.said();
            let says_so = said.contains(says);
            (!says_so).then(|| format!("{name}: nothing of \"{says}\" in\n{said}"))
        })
        .collect();
    assert!(
        silent.is_empty(),
        "{} of {}:\n{}",
        silent.len(),
        MISTAKES.len(),
        silent.join("\n")
    );
}

#[test]
fn what_is_good_is_answered_without_a_warning() {
    for Case { name, change, .. } in GOOD {
        let mut inputs = Inputs::good();
        change(&mut inputs);
        let said = inputs.said();
        assert!(said.is_empty(), "{name}: {said}");
    }
}

/// Physics that is found in a signal with the wrong sign would be none.
#[test]
fn a_diagnosis_of_meaningless_figures_is_refused() {
    let mut inputs = Inputs::good();
    inputs.each(8..9, |i| -i);
    let output = inputs.run("diagnose");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(
        said.contains("signal-sign") && said.contains("--force"),
        "{said}"
    );
}
