//! MuJoCo with the exported model and plugin moves as exid says: along its motion the chain gives the signals that drove
//! it, and the forward model, under the same controls from rest, moves the same, to the error of MuJoCo's integrator,
//! which shrinks with the step.

use super::drives::{Proof, proofs};
use super::*;

/// Steps of the simulator, s, each half of the one before.
const STEPS: [f64; 3] = [1e-3, 5e-4, 2.5e-4];

/// s
const DURATION: f64 = 0.25;

/// s that a motion takes to come in.
const BEGIN: f64 = 0.02;

/// Effects whose state at the start the chain, which comes from a motion, and the plugin, which comes from rest, have apart.
const REMEMBERING: [&str; 5] = [
    "presliding_hysteresis",
    "joint_elasticity",
    "backlash",
    "all together",
    "all of the motion together",
];

/// What the forward model, which knows motions alone, leaves out.
const OF_TIME: [&str; 4] = [
    "external_contact",
    "thermal_drift",
    "time_delay",
    "all together",
];

const SCRIPT: &str = r#"
import json, subprocess, sys, os
import numpy as np, mujoco
root = os.path.dirname(mujoco.__file__)
library = [f for f in os.listdir(root) if f.startswith('libmujoco.so.')][0]
if os.path.exists('exid_drive.c'):
    subprocess.run(['cc', '-O2', '-Wall', '-Wextra', '-Werror', '-shared', '-fPIC', f'-I{root}/include', 'exid_drive.c', '-o',
                    'libexid_drive.so', f'-L{root}', f'-l:{library}', '-lm'], check=True)
    mujoco.mj_loadPluginLibrary('./libexid_drive.so')
out = []
for h in json.loads(sys.argv[1]):
    model = mujoco.MjModel.from_xml_path(sys.argv[3])
    model.opt.timestep = h
    data = mujoco.MjData(model)
    rows = {'signal': [], 'q': [], 'dq': [], 'ddq': []}
    for k in range(round(float(sys.argv[2]) / h)):
        t = (k + 1) * h
        rise = t**2 / (t**2 + 0.02**2)
        data.ctrl[:] = [rise * 0.9 * np.sin(19 * t + 0.4), rise * 0.8 * np.sin(23 * t + 1.0), rise * 0.7 * np.cos(17 * t)]
        before = data.qvel.copy()
        mujoco.mj_step(model, data)
        for key, values in (('signal', data.ctrl), ('q', data.qpos), ('dq', data.qvel), ('ddq', (data.qvel - before) / h)):
            rows[key].append(values.tolist())
    out.append({key: np.array(values).T.tolist() for key, values in rows.items()})
print(json.dumps(out))
"#;

/// The controls of the script, which rise from nothing: the plugin begins with the twist that bears its first signal.
fn controls(t: f64) -> [f64; 3] {
    let rise = t * t / (t * t + 0.02 * 0.02);
    [
        rise * 0.9 * (19.0 * t + 0.4).sin(),
        rise * 0.8 * (23.0 * t + 1.0).sin(),
        rise * 0.7 * (17.0 * t).cos(),
    ]
}

fn series(run: &Value, key: &str) -> Vec<Vec<f64>> {
    serde_json::from_value(run[key].clone()).unwrap()
}

/// Root of the mean square by which the chain misses the signals, relative to that of the signals.
fn miss(proof: &Proof, run: &Value, step: f64) -> f64 {
    let encoders: Motion = ["q", "dq", "ddq"].map(|key| series(run, key));
    let predicted = proof.predicted(&encoders, step);
    let begin = (BEGIN / step) as usize;
    let (mut error, mut size) = (0.0, 0.0);
    for (predicted, signal) in predicted.iter().zip(series(run, "signal")) {
        for k in begin..signal.len() - begin {
            error += (predicted[k] - signal[k]).powi(2);
            size += signal[k].powi(2);
        }
    }
    (error / size).sqrt()
}

/// Root of the mean square distance from the motion of the forward model, relative to its way.
fn distance(proof: &Proof, run: &Value, step: f64) -> f64 {
    let expected = proof.simulated(controls, [STEPS[2] / 2.0, DURATION]);
    let every = (2.0 * step / STEPS[2]).round() as usize;
    let (mut error, mut size) = (0.0, 0.0);
    for (found, expected) in series(run, "q").iter().zip(expected) {
        for (found, expected) in found
            .iter()
            .zip(expected.iter().skip(every - 1).step_by(every))
        {
            error += (found - expected).powi(2);
            size += expected.powi(2);
        }
    }
    (error / size).sqrt()
}

/// What MuJoCo makes of a robot in this format with every step; `None`, recorded as a skip, without it.
fn runs(proof: &Proof, format: Format) -> Option<Vec<Value>> {
    let python = drives::python()?;
    let has = |program: &std::ffi::OsStr, arguments: &[&str]| {
        let asked = Command::new(program).args(arguments).output();
        asked.is_ok_and(|output| output.status.success())
    };
    if !has(&python, &["-c", "import mujoco"]) || !has("cc".as_ref(), &["--version"]) {
        common::skip("no Python with MuJoCo (EXID_PYTHON names one), or no cc");
        return None;
    }
    let folder = tempfile::tempdir().unwrap();
    let written = export(&proof.outcome, format).unwrap();
    for file in &written.files {
        fs::write(folder.path().join(&file.name), &file.text).unwrap();
    }
    let output = Command::new(&python)
        .current_dir(folder.path())
        .args([
            "-c",
            SCRIPT,
            &json!(STEPS).to_string(),
            &DURATION.to_string(),
            &written.files[0].name,
        ])
        .output()
        .unwrap();
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}: {words}", proof.effect);
    Some(serde_json::from_slice(&output.stdout).unwrap())
}

/// Of first order: a quarter of the error with a quarter of the step, less where friction turns over.
fn shrinks(what: &str, runs: &[Value], of: impl Fn(&Value, f64) -> f64) -> Option<String> {
    let pairs = runs.iter().zip(STEPS);
    let errors: Vec<f64> = pairs.map(|(run, h)| of(run, h)).collect();
    println!("MuJoCo {what}: {errors:?}");
    let [first, _, last] = errors[..] else {
        panic!("three")
    };
    let is_fine = last <= 0.4 * first && last <= 0.02;
    (!is_fine).then(|| format!("{what}: {errors:?}"))
}

#[test]
fn invariant_mujoco_with_the_plugin_moves_as_exid_says() {
    let mut failures = Vec::new();
    for proof in &proofs() {
        let Some(runs) = runs(proof, Format::Mujoco) else {
            return;
        };
        if !REMEMBERING.contains(&proof.effect) {
            let what = format!("{}, signal", proof.effect);
            failures.extend(shrinks(&what, &runs, |run, h| miss(proof, run, h)));
        }
        if !OF_TIME.contains(&proof.effect) {
            let what = format!("{}, motion", proof.effect);
            failures.extend(shrinks(&what, &runs, |run, h| distance(proof, run, h)));
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn invariant_position_controllers_move_robots_in_mujoco_as_in_the_forward_model() {
    let smooth = [
        "rotor_inertia",
        "viscous_friction",
        "drive_gain",
        "time_delay",
    ];
    let rough = [&smooth[..], &["coulomb_friction"]].concat();
    let mut failures = Vec::new();
    for (effects, format) in [(&rough[..], Format::Mujoco), (&smooth, Format::Mjcf)] {
        let proof = drives::controlled(effects);
        let Some(runs) = runs(&proof, format) else {
            return;
        };
        let what = format!("{format:?}, controlled");
        failures.extend(shrinks(&what, &runs, |run, h| distance(&proof, run, h)));
    }
    assert!(failures.is_empty(), "{failures:#?}");
}
