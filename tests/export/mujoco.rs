//! MuJoCo with the exported model and plugin moves as the chain says: along its motion the chain gives the signals that
//! drove it, to the error of its integrator, which shrinks with the step.

use super::drives::{Proof, proofs};
use super::*;

/// Steps of the simulator, s, each half of the one before.
const STEPS: [f64; 3] = [1e-3, 5e-4, 2.5e-4];

/// s
const DURATION: f64 = 0.25;

/// s that a motion takes to come in.
const BEGIN: f64 = 0.02;

/// Effects whose state at the start the chain, which comes from a motion, and the plugin, which comes from rest, have apart.
const REMEMBERING: [&str; 4] = [
    "presliding_hysteresis",
    "joint_elasticity",
    "backlash",
    "all together",
];

const SCRIPT: &str = r#"
import json, subprocess, sys, os
import numpy as np, mujoco
root = os.path.dirname(mujoco.__file__)
library = [f for f in os.listdir(root) if f.startswith('libmujoco.so.')][0]
subprocess.run(['cc', '-O2', '-Wall', '-Wextra', '-Werror', '-shared', '-fPIC', f'-I{root}/include', 'exid_drive.c', '-o',
                'libexid_drive.so', f'-L{root}', f'-l:{library}', '-lm'], check=True)
mujoco.mj_loadPluginLibrary('./libexid_drive.so')
out = []
for h in json.loads(sys.argv[1]):
    model = mujoco.MjModel.from_xml_path('model.xml')
    model.opt.timestep = h
    data = mujoco.MjData(model)
    rows = {'signal': [], 'q': [], 'dq': [], 'ddq': []}
    for k in range(round(float(sys.argv[2]) / h)):
        t = (k + 1) * h
        data.ctrl[:] = [0.9 * np.sin(19 * t + 0.4), 0.8 * np.sin(23 * t + 1.0), 0.7 * np.cos(17 * t)]
        before = data.qvel.copy()
        mujoco.mj_step(model, data)
        for key, values in (('signal', data.ctrl), ('q', data.qpos), ('dq', data.qvel), ('ddq', (data.qvel - before) / h)):
            rows[key].append(values.tolist())
    out.append({key: np.array(values).T.tolist() for key, values in rows.items()})
print(json.dumps(out))
"#;

/// Root of the mean square by which the chain misses the signals, relative to that of the signals.
fn miss(proof: &Proof, run: &Value, step: f64) -> f64 {
    let series = |key: &str| -> Vec<Vec<f64>> { serde_json::from_value(run[key].clone()).unwrap() };
    let encoders: Motion = [series("q"), series("dq"), series("ddq")];
    let predicted = proof.predicted(&encoders, step);
    let begin = (BEGIN / step) as usize;
    let (mut error, mut size) = (0.0, 0.0);
    for (predicted, signal) in predicted.iter().zip(series("signal")) {
        for k in begin..signal.len() - begin {
            error += (predicted[k] - signal[k]).powi(2);
            size += signal[k].powi(2);
        }
    }
    (error / size).sqrt()
}

#[test]
fn invariant_mujoco_with_the_plugin_moves_as_the_chain_says() {
    let Some(python) = drives::python() else {
        return;
    };
    let has = |program: &std::ffi::OsStr, arguments: &[&str]| {
        let asked = Command::new(program).args(arguments).output();
        asked.is_ok_and(|output| output.status.success())
    };
    if !has(&python, &["-c", "import mujoco"]) || !has("cc".as_ref(), &["--version"]) {
        common::skip("no Python with MuJoCo (EXID_PYTHON names one), or no cc");
        return;
    }
    let mut failures = Vec::new();
    for proof in proofs().iter().filter(|p| !REMEMBERING.contains(&p.effect)) {
        let folder = tempfile::tempdir().unwrap();
        for file in export(&proof.outcome, Format::Mujoco).unwrap().files {
            fs::write(folder.path().join(&file.name), &file.text).unwrap();
        }
        let output = Command::new(&python)
            .current_dir(folder.path())
            .args([
                "-c",
                SCRIPT,
                &json!(STEPS).to_string(),
                &DURATION.to_string(),
            ])
            .output()
            .unwrap();
        let words = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{}: {words}", proof.effect);
        let runs: Vec<Value> = serde_json::from_slice(&output.stdout).unwrap();
        let misses: Vec<f64> = runs
            .iter()
            .zip(STEPS)
            .map(|(run, h)| miss(proof, run, h))
            .collect();
        println!("MuJoCo {}: {misses:?}", proof.effect);
        // Of first order: a quarter of the error with a quarter of the step, less where friction turns over.
        let [first, _, last] = misses[..] else {
            panic!("three")
        };
        if !(last <= 0.4 * first && last <= 0.02) {
            failures.push(format!("{}: {misses:?}", proof.effect));
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}
