//! Tests of the whole way from a file to an experiment, with files written for the purpose.

use std::f64::consts::TAU;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use crate::fault::Fault;
use crate::recording::channels::column_map::ColumnMap;
use crate::recording::channels::columns::{RecordedJoint, read};
use crate::recording::channels::samples::{Recording, SignalKind};
use crate::recording::error::RecordingError;
use crate::recording::prepare::experiment::Experiment;
use crate::recording::prepare::periods::successive_periods::successive_periods;
use crate::recording::prepare::preprocess::prepare;
use crate::recording::prepare::settings::{Method, Preparation};

mod bounds;
mod columns;
mod containers;
mod damaged;
mod faults;
mod foreign;
mod joined;

fn joints() -> Vec<String> {
    vec!["hip".into(), "knee".into()]
}

fn write(name: &str, content: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, content).unwrap();
    (folder, path)
}

fn read_content(name: &str, content: &[u8]) -> Result<Recording, RecordingError> {
    let (_folder, path) = write(name, content);
    read(
        &path,
        &ColumnMap::default(),
        &RecordedJoint::all(&joints()),
        SignalKind::Torque,
    )
}

/// Thirty good rows under the header, the columns counting up.
fn rows(header: &str, separator: char) -> String {
    let fields = header.split(separator).count();
    let mut text = format!("{header}\n");
    for k in 0..30 {
        let row: Vec<String> = (0..fields).map(|c| format!("{}", k + 100 * c)).collect();
        text.push_str(&row.join(&separator.to_string()));
        text.push('\n');
    }
    text
}

fn gzip(content: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(content).unwrap();
    encoder.finish().unwrap()
}

const HEADER: &str = "t,q1,q2,tau1,tau2";

#[test]
fn joints_are_matched_by_name_before_number_and_in_any_order() {
    let text = rows("tau_knee,q_knee,q1,q2,tau_hip,q_hip,time", ',');
    let recording = read_content("a.csv", text.as_bytes()).unwrap();
    assert_eq!(recording.position[0][0], 500.0);
    assert_eq!(recording.position[1][0], 100.0);
    assert_eq!(recording.signal[0][2], 402.0);
    assert_eq!(recording.signal[1][2], 2.0);
    assert_eq!(recording.time.unwrap()[1], 601.0);
    assert_eq!(recording.velocity, None);
}

#[test]
fn separators_quotes_line_ends_and_compression_do_not_matter() {
    let plain = rows(HEADER, ',');
    let expected = read_content("a.csv", plain.as_bytes()).unwrap();
    let quoted = plain.replace(HEADER, "\"t\", \"q1\",\"q2\",\"tau1\",\"tau2\"");
    let variants = [
        ("b.csv", plain.replace(',', ";").into_bytes()),
        ("c.csv", plain.replace(',', "\t").into_bytes()),
        ("d.csv", plain.replace('\n', "\r\n").into_bytes()),
        ("e.csv", format!("\u{feff}# {plain}\n\n").into_bytes()),
        ("f.CSV", quoted.into_bytes()),
        ("g.csv.gz", gzip(plain.as_bytes())),
    ];
    for (name, content) in variants {
        let found = read_content(name, &content).unwrap();
        assert_eq!(found.position, expected.position, "{name}");
        assert_eq!(found.signal, expected.signal, "{name}");
        assert_eq!(found.first_line, 2, "{name}");
    }
}

#[test]
fn a_path_without_a_file_is_told_from_a_directory_and_from_a_pipe() {
    let code = |path: &Path| {
        let result = read(
            path,
            &ColumnMap::default(),
            &RecordedJoint::all(&joints()),
            SignalKind::Torque,
        );
        result.unwrap_err().describe().code
    };
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(code(folder.path()), "recording-is-directory");
    assert_eq!(code(&folder.path().join("a.csv")), "recording-not-found");
    #[cfg(target_os = "linux")]
    {
        use rustix::fs::{CWD, FileType, Mode, mknodat};
        let pipe = folder.path().join("pipe.csv");
        mknodat(CWD, &pipe, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
        // It would be waited for until somebody writes.
        assert_eq!(code(&pipe), "recording-is-pipe");
    }
}

#[test]
fn faults_of_the_column_map_are_told_apart() {
    let (_folder, path) = write("a.csv", rows(HEADER, ',').as_bytes());
    let code = |map: ColumnMap| {
        let result = read(
            &path,
            &map,
            &RecordedJoint::all(&joints()),
            SignalKind::Torque,
        );
        result.unwrap_err()
    };
    let position = |pattern: &str| ColumnMap {
        position: Some(pattern.into()),
        ..ColumnMap::default()
    };
    let missing = code(position("qq{n}"));
    assert_eq!(missing.describe().code, "missing-column");
    assert!(
        missing.to_string().contains("did you mean \"q1\"?"),
        "{missing}"
    );
    assert_eq!(
        code(position("q1")).describe().code,
        "pattern-not-per-joint"
    );
    assert_eq!(
        code(position("q{k}")).describe().code,
        "unknown-placeholder"
    );
    assert_eq!(
        code(position("tau{n}")).describe().code,
        "column-used-twice"
    );
}

const PERIOD: f64 = 4.0;

fn motion(t: f64) -> [f64; 3] {
    [(1.0, 0.8), (3.0, 0.2), (7.0, 0.02)]
        .iter()
        .fold([0.0; 3], |sum, (h, amplitude)| {
            let omega = TAU * h / PERIOD;
            let (sine, cosine) = (omega * t + h).sin_cos();
            let [q, v, a] = sum;
            [
                q + amplitude * sine,
                v + amplitude * omega * cosine,
                a - amplitude * omega * omega * sine,
            ]
        })
}

/// One joint at the stamps, with white noise on position and signal; the signal is the velocity.
fn periodic_recording(time: Vec<f64>, sd: [f64; 2]) -> Recording {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(11);
    let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
    let position = time
        .iter()
        .map(|t| motion(*t)[0] + sd[0] * draw())
        .collect();
    let signal = time
        .iter()
        .map(|t| motion(*t)[1] + sd[1] * draw())
        .collect();
    Recording {
        time: Some(time),
        ..Recording::of_samples("made.csv", vec![position], vec![signal])
    }
}

fn with_period() -> Preparation {
    Preparation {
        period: Some(PERIOD),
        ..Preparation::default()
    }
}

fn acceleration_error(experiment: &Experiment) -> f64 {
    let pairs = experiment.t.iter().zip(&experiment.motion.acceleration[0]);
    let squares: f64 = pairs.map(|(t, a)| (a - motion(*t)[2]).powi(2)).sum();
    (squares / experiment.rows() as f64).sqrt()
}

#[test]
fn recovers_known_noise_and_motion_of_a_periodic_recording() {
    let time: Vec<f64> = (0..5100).map(|k| f64::from(k) / 200.0).collect();
    let experiment = prepare(periodic_recording(time, [1e-5, 0.3]), &with_period()).unwrap();
    let periods = experiment.periods.unwrap();
    assert_eq!((periods.count, periods.samples), (6, 800));
    let noise = experiment.noise.as_ref().unwrap();
    // A variance of 5 x 800 degrees of freedom: relative standard error sqrt(2 / 4000) = 2.2 %.
    let ratio = noise.signal_covariance[(0, 0)] * 6.0 / 0.09;
    assert!((ratio - 1.0).abs() < 4.0 * 0.022, "{ratio}");
    assert!((noise.recorded_position_sd[0] / 1e-5 - 1.0).abs() < 4.0 * 0.011);
    assert!((noise.autocovariance[0][0] / noise.signal_covariance[(0, 0)] - 1.0).abs() < 1e-9);
    // White: a correlation of 4800 products has standard error 1.4 %.
    assert!((noise.autocovariance[0][1] / noise.autocovariance[0][0]).abs() < 4.0 * 0.0145);
    // The stated standard deviation covers the error, and is not far above it: its own comes from
    // bands of 16 harmonics, and the error from 2 H coefficients.
    let ratio = acceleration_error(&experiment)
        / experiment
            .motion_error
            .as_ref()
            .unwrap()
            .acceleration
            .deviation(0);
    assert!((0.5..2.0).contains(&ratio), "{ratio}");
}

#[test]
fn every_recorded_sample_finds_its_row() {
    let even: Vec<f64> = (0..2500).map(|k| f64::from(k) / 200.0).collect();
    let uneven: Vec<f64> = even.iter().map(|t| t + 0.001 * (300.0 * t).sin()).collect();
    for (time, preparation, first) in [
        (even.clone(), with_period(), 0),
        (even.clone(), with_period(), 137),
        (uneven.clone(), with_period(), 0),
        (even, Preparation::default(), 0),
        (uneven, Preparation::default(), 0),
    ] {
        let recording = Recording {
            mask: (first > 0).then(|| (0..time.len()).map(|k| k >= first).collect()),
            ..periodic_recording(time, [0.0, 0.0])
        };
        let experiment = prepare(recording, &preparation).unwrap();
        let raw = &experiment.raw;
        for (k, t) in raw.t.iter().enumerate() {
            let found = experiment.motion.position[0][raw.row_of(k)];
            // What cubics over 5 ms and the smoother leave of a motion without noise.
            assert!((found - motion(*t)[0]).abs() < 2e-6, "{:?} at {t}", raw.map);
        }
        for period in 0..experiment.periods.map_or(0, |periods| periods.count) {
            let signal = experiment.period_signal(0, period);
            for (row, value) in signal.iter().enumerate() {
                assert!((value - motion(experiment.t[row])[1]).abs() < 1e-9);
            }
        }
    }
}

#[test]
fn a_stated_period_that_is_a_little_off_is_mended_and_said() {
    let time = || {
        (0..4000)
            .map(|k| f64::from(k) / 200.0)
            .collect::<Vec<f64>>()
    };
    let right = prepare(periodic_recording(time(), [1e-6, 0.0]), &with_period()).unwrap();
    assert!(right.remarks.is_empty());
    let period = right.periods.unwrap().period;
    let mut off = with_period();
    off.period = Some(1.001 * period);
    let mended = prepare(periodic_recording(time(), [1e-6, 0.0]), &off).unwrap();
    assert!((mended.periods.unwrap().period / period - 1.0).abs() < 1e-4);
    assert_eq!(mended.remarks.len(), 1);
    off.period = None;
    let found = prepare(periodic_recording(time(), [1e-6, 0.0]), &off).unwrap();
    assert!((found.periods.unwrap().period / period - 1.0).abs() < 1e-4);
}

#[test]
fn low_pass_and_fourier_agree_on_a_period() {
    let time = || {
        (0..4000)
            .map(|k| f64::from(k) / 200.0)
            .collect::<Vec<f64>>()
    };
    let prepared = |method: Method, sd: f64| {
        let mut preparation = with_period();
        preparation.differentiation.method = Some(method);
        preparation.differentiation.cutoff_hz = Some(20.0);
        prepare(periodic_recording(time(), [sd, 0.0]), &preparation).unwrap()
    };
    for method in [Method::Fourier, Method::Lowpass] {
        let experiment = prepared(method, 0.0);
        // The low-pass of 20 Hz takes (1.75 / 20)⁸ of the 7th harmonic.
        assert!(acceleration_error(&experiment) < 1e-7, "{method:?}");
    }
    // A low-pass leaves about as much of white noise as a sharp end of the band at its cut-off.
    let [sharp, soft] = [Method::Fourier, Method::Lowpass].map(|method| {
        let error = prepared(method, 1e-4).motion_error.unwrap();
        error.position.deviation(0)
    });
    // 20 Hz of 100 Hz in five periods.
    let expected = 1e-4 * f64::sqrt(0.2 / 5.0);
    assert!((sharp / expected - 1.0).abs() < 0.2, "{sharp}");
    assert!((soft / expected - 1.0).abs() < 0.2, "{soft}");
}

/// Two periods are an average already; one is none.
#[test]
fn periods_one_after_another_are_what_was_recorded() {
    let of = |rows: i32| {
        let time = (0..rows).map(|k| f64::from(k) / 200.0).collect();
        prepare(periodic_recording(time, [0.0, 0.1]), &with_period()).unwrap()
    };
    let two = of(1600);
    let all = successive_periods(&two).unwrap();
    assert_eq!((two.rows(), all.rows(), all.periods), (800, 1600, None));
    assert_eq!(all.signal[0][..800], two.period_signal(0, 0));
    assert_eq!(all.signal[0][800..], two.period_signal(0, 1));
    assert_eq!(all.motion.velocity[0][800..], two.motion.velocity[0]);
    assert!(successive_periods(&of(801)).is_none());
}

#[test]
fn parallel_filter_leaves_its_edges_masked() {
    let time = (0..4000).map(|k| f64::from(k) / 200.0).collect();
    let mut preparation = Preparation::default();
    preparation.differentiation.method = Some(Method::Lowpass);
    preparation.differentiation.cutoff_hz = Some(20.0);
    preparation.differentiation.parallel_hz = Some(5.0);
    let experiment = prepare(periodic_recording(time, [0.0, 0.0]), &preparation).unwrap();
    let mask = experiment.mask.as_ref().unwrap();
    assert_eq!(mask.iter().filter(|&&valid| !valid).count(), 2 * 80);
    let mut model = experiment.motion.velocity[0].clone();
    experiment.apply_parallel(&mut model);
    for (k, value) in model.iter().enumerate().filter(|(k, _)| mask[*k]) {
        // Signal and model went through the same filters; their differentiation is of sixth order.
        assert!((value - experiment.signal[0][k]).abs() < 1e-4);
    }
}

#[test]
fn faults_of_time_base_and_settings_have_their_codes() {
    let time = || (0..400).map(|k| f64::from(k) / 200.0).collect::<Vec<f64>>();
    let recording = |time| periodic_recording(time, [1e-5, 0.1]);
    let set = |change: fn(&mut Preparation)| {
        let mut preparation = Preparation::default();
        change(&mut preparation);
        preparation
    };
    let code = |recording: Recording, preparation: Preparation| {
        prepare(recording, &preparation)
            .unwrap_err()
            .describe()
            .code
    };
    type Change = fn(&mut Preparation);
    let cases: [(&str, Change); 8] = [
        ("rate-contradicts-time", |p| p.rate = Some(100.0)),
        ("invalid-setting", |p| p.rate = Some(-1.0)),
        ("invalid-setting", |p| p.period = Some(f64::NAN)),
        ("invalid-setting", |p| p.period = Some(0.01)),
        ("shorter-than-period", |p| p.period = Some(1e300)),
        ("invalid-setting", |p| {
            p.differentiation.cutoff_hz = Some(100.0)
        }),
        ("too-short-for-filter", |p| {
            p.differentiation.cutoff_hz = Some(1e-300)
        }),
        ("fourier-without-period", |p| {
            p.differentiation.method = Some(Method::Fourier)
        }),
    ];
    for (expected, change) in cases {
        assert_eq!(code(recording(time()), set(change)), expected);
    }
    let mut untimed = recording(time());
    untimed.time = None;
    assert_eq!(code(untimed, Preparation::default()), "no-time-base");
    let mut back = time();
    back[200] = 0.5;
    let error = prepare(recording(back), &Preparation::default()).unwrap_err();
    assert_eq!(error.describe().code, "time-not-increasing");
    assert_eq!(error.place.line, Some(202));
    let mut far = time();
    far[399] = 1e12;
    assert_eq!(code(recording(far), Preparation::default()), "gap-too-long");
    let mut masked = recording(time());
    masked.mask = Some(vec![false; 400]);
    assert_eq!(
        code(masked.clone(), Preparation::default()),
        "nothing-unmasked"
    );
    assert_eq!(
        code(masked, set(|p| p.period = Some(1.0))),
        "nothing-unmasked"
    );
}

/// The folder of published recordings and trials, if it is there.
fn published(path: &str) -> Option<PathBuf> {
    let root = std::env::var("EXID_DATA").unwrap_or_else(|_| "../shared".into());
    let file = Path::new(&root).join(path);
    if !file.exists() {
        eprintln!("skipped: {} is absent", file.display());
    }
    file.exists().then_some(file)
}

fn numbered(count: usize) -> Vec<String> {
    (1..=count).map(|n| format!("joint{n}")).collect()
}

#[test]
fn a_published_positioning_axis_gets_the_published_cutoff() {
    let Some(file) = published("data/emps/tracking.csv") else {
        return;
    };
    let map = ColumnMap {
        torque: Some("voltage{n}".into()),
        ..ColumnMap::default()
    };
    let recording = read(
        &file,
        &map,
        &RecordedJoint::all(&numbered(1)),
        SignalKind::Torque,
    )
    .unwrap();
    let mut preparation = Preparation::default();
    preparation.differentiation.method = Some(Method::Lowpass);
    let experiment = prepare(recording, &preparation).unwrap();
    // Its authors differentiate at 100 Hz; the error of the acceleration is flat about its least.
    let cutoff = experiment.bandwidth[0].cutoff_hz;
    assert!((50.0..200.0).contains(&cutoff), "{cutoff} Hz");
}

#[test]
fn a_trial_with_equal_periods_keeps_quantisation_out_of_the_acceleration() {
    let Some(file) = published("trials/p01/train.csv") else {
        return;
    };
    let map = ColumnMap::default();
    let recording = read(
        &file,
        &map,
        &RecordedJoint::all(&numbered(6)),
        SignalKind::Current,
    )
    .unwrap();
    let preparation = Preparation {
        period: Some(12.0),
        ..Preparation::default()
    };
    let experiment = prepare(recording, &preparation).unwrap();
    let (noise, error) = (experiment.noise.unwrap(), experiment.motion_error.unwrap());
    for joint in 0..6 {
        let acceleration = &experiment.motion.acceleration[joint];
        let squares: f64 = acceleration.iter().map(|a| a * a).sum();
        let rms = (squares / acceleration.len() as f64).sqrt();
        // The steps of 2^19 counts a turn have a standard deviation of 3.5e-6 rad, which becomes
        // 0.24 rad/s² at full bandwidth, a tenth of the motion; the series must stay below 2 %.
        assert!(error.acceleration.deviation(joint) < 0.02 * rms);
        assert!(noise.recorded_position_sd[joint] < 1e-12);
    }
}
