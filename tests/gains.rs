//! Gains of amplifiers from the static force at a clamped platform: over thirty recordings that were made anew their
//! intervals cover the truth as often as they say, without a bias.
//!
//! Recordings are those of `problems/h4_parallel/make.py`: closed-form inverse kinematics, central differences of it,
//!
//! ```text
//! M (ẍ − G) = f + J⁻ᵀ (Γ − s),   Γ = G_T V        at rest; s: what is left of dry friction, anew at every step
//! ```

use exid::robot::random::{generator, symmetric};
use nalgebra::{Matrix4, Vector3, Vector4};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::prelude::*;
use serde_json::Value;
use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::Command;

const SEEDS: u64 = 30;
/// m, of gains.toml.
const LEVER: f64 = 0.26;
const ROD: f64 = 0.48;
const HALF_BAR: f64 = 0.06;
const HALF_WIDTH: f64 = 0.06;
const RADIUS: f64 = 0.14;
/// Signs of the bar's side and of its end at every motor, and the motors' directions.
const SIDE: [f64; 4] = [1.0, -1.0, -1.0, 1.0];
const END: [f64; 4] = [1.0, 1.0, -1.0, -1.0];
const ALPHA: [f64; 4] = [0.0, PI, 1.5 * PI, 1.5 * PI];
/// kg
const MASS: f64 = 0.984;
/// N·m
const COULOMB: [f64; 4] = [1.2186, 1.0252, 0.7902, 1.0394];
/// N·m/V: Table 1 of the paper.
const GAIN: [f64; 4] = [2.85, 2.65, 2.70, 2.87];
/// V, of the steps.
const LEVELS: [f64; 6] = [0.5, 1.0, 1.5, -1.5, -1.0, -0.5];
const ROUNDS: usize = 5;
/// Samples at 100 Hz that count of a step, and that do not on either side of it.
const STEADY: usize = 30;
const BESIDE: usize = 10;
/// rad, of the motors' encoders.
const TICK: f64 = TAU / 131_072.0;
/// N and N·m, of the force sensor; V, of the references.
const SENSOR: [f64; 4] = [0.2, 0.2, 0.2, 0.01];
const REFERENCE: f64 = 0.005;

/// Motor positions at a pose (x, y, z, θ) of the platform.
fn inverse(pose: &Vector4<f64>) -> Vector4<f64> {
    Vector4::from_fn(|i, _| {
        let (sine, cosine) = pose[3].sin_cos();
        let bar = Vector3::new(SIDE[i] * HALF_BAR, END[i] * HALF_WIDTH, 0.0);
        let turned = Vector3::new(bar.x * cosine, bar.y + bar.x * sine, 0.0);
        let out = Vector3::new(ALPHA[i].cos(), ALPHA[i].sin(), 0.0);
        let reach = pose.xyz() + turned - bar - RADIUS * out;
        let (u, w) = (reach.dot(&out), -reach.z);
        let wanted = (reach.norm_squared() + LEVER * LEVER - ROD * ROD) / (2.0 * LEVER);
        w.atan2(u) - (wanted / u.hypot(w)).acos()
    })
}

/// ∂q/∂x by central differences.
fn rates(pose: &Vector4<f64>) -> Matrix4<f64> {
    const STEP: f64 = 1e-4;
    let column = |axis: usize| {
        let away = Vector4::ith(axis, STEP);
        (inverse(&(pose + away)) - inverse(&(pose - away))) / (2.0 * STEP)
    };
    Matrix4::from_columns(&[0, 1, 2, 3].map(column))
}

/// A recording at one pose, as CSV: each amplifier in turn gets steps of its reference.
fn recording(rng: &mut ChaCha8Rng) -> String {
    let home = Vector4::new(0.0, 0.0, -0.42, 0.0);
    let away = [0.08, 0.08, 0.06, 0.4].map(|size| symmetric(rng, size));
    let pose = home + Vector4::from(away);
    let (rates, q) = (rates(&pose), inverse(&pose));
    let mut text = "t,valid,q1,q2,q3,q4,v1,v2,v3,v4,fx,fy,fz,mz\n".to_string();
    let mut row = 0;
    for (motor, level) in (0..ROUNDS * 4).flat_map(|k| LEVELS.map(|level| (k % 4, level))) {
        let volts = Vector4::ith(motor, level);
        let stuck = Vector4::from(COULOMB.map(|friction| symmetric(rng, friction / 10.0)));
        let torque = volts.component_mul(&Vector4::from(GAIN)) - stuck;
        let force = Vector4::new(0.0, 0.0, MASS * 9.81, 0.0) - rates.transpose() * torque;
        for sample in 0..STEADY + 2 * BESIDE {
            let valid = (BESIDE..BESIDE + STEADY).contains(&sample);
            let mut noise = || -> f64 { rng.sample(StandardNormal) };
            write!(text, "{},{}", row as f64 / 100.0, u8::from(valid)).unwrap();
            q.iter()
                .for_each(|q| write!(text, ",{:.6}", (q / TICK).round() * TICK).unwrap());
            volts
                .iter()
                .for_each(|v| write!(text, ",{:.4}", v + REFERENCE * noise()).unwrap());
            for (f, size) in force.iter().zip(SENSOR) {
                write!(text, ",{:.3}", f + size * noise()).unwrap();
            }
            text.push('\n');
            row += 1;
        }
    }
    text
}

/// Errors of the four gains in standard deviations, of a fit of two recordings at two poses.
fn standardised(seed: u64) -> [f64; 4] {
    let folder = tempfile::tempdir().unwrap();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/h4_parallel/gains.toml");
    let text = fs::read_to_string(shipped).unwrap();
    assert!(text.contains(".csv.gz"));
    let problem = folder.path().join("problem.toml");
    fs::write(&problem, text.replace(".csv.gz", ".csv")).unwrap();
    let mut rng = generator(seed);
    for name in ["static1.csv", "static2.csv"] {
        fs::write(folder.path().join(name), recording(&mut rng)).unwrap();
    }
    let mut command = Command::new(env!("CARGO_BIN_EXE_exid"));
    command.current_dir(folder.path()).arg("fit").arg(&problem);
    let output = command.args(["--json", "--threads", "1"]).output().unwrap();
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{words}");
    let result: Value = serde_json::from_slice(&output.stdout).unwrap();
    let parameters = result["parameters"].as_array().unwrap();
    [0, 1, 2, 3].map(|motor| {
        let name = format!("motor{}.drive_gain.gain", motor + 1);
        let found = parameters.iter().find(|p| p["name"] == name).unwrap();
        let number = |key: &str| found[key].as_f64().unwrap();
        (number("value") - GAIN[motor]) / number("std_dev")
    })
}

#[test]
fn intervals_of_gains_cover_the_truth_as_often_as_they_say() {
    let all: Vec<[f64; 4]> = (0..SEEDS).into_par_iter().map(standardised).collect();
    let every: Vec<f64> = all.iter().flatten().copied().collect();
    let count = every.len() as f64;
    let covered = every.iter().filter(|z| z.abs() < 1.96).count() as f64 / count;
    let spread = (every.iter().map(|z| z * z).sum::<f64>() / count).sqrt();
    let means = [0, 1, 2, 3].map(|k| all.iter().map(|z| z[k]).sum::<f64>() / SEEDS as f64);
    eprintln!(
        "{SEEDS} seeds: 95 % intervals cover {:.1} %; errors in standard deviations: root mean square {spread:.2}, \
         means {means:.2?}",
        100.0 * covered
    );
    // Three standard deviations of a share, of a mean and of a root mean square of normal errors.
    assert!(
        (covered - 0.95).abs() < 3.0 * (0.95 * 0.05 / count).sqrt(),
        "{covered}"
    );
    assert!(
        (spread - 1.0).abs() < 3.0 / (2.0 * count).sqrt(),
        "{spread}"
    );
    for mean in means {
        assert!(mean.abs() < 3.0 / (SEEDS as f64).sqrt(), "{means:?}");
    }
}
