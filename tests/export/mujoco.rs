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
if os.path.exists('exid_drive.c') and not os.path.exists('libexid_drive.so'):
    subprocess.run(['cc', '-O2', '-Wall', '-Wextra', '-Werror', '-shared', '-fPIC', f'-I{root}/include', 'exid_drive.c', '-o',
                    'libexid_drive.so', f'-L{root}', f'-l:{library}', '-lm'], check=True)
if os.path.exists('libexid_drive.so'):
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

/// An export in a folder of its own, for a Python that has MuJoCo.
struct Exported {
    folder: TempDir,
    python: std::ffi::OsString,
    /// Name of the model's file.
    model: String,
}

impl Exported {
    /// `None`, recorded as a skip, without MuJoCo.
    fn new(proof: &Proof, format: Format) -> Option<Self> {
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
        Some(Self {
            folder,
            python,
            model: written.files[0].name.clone(),
        })
    }

    /// The simulator's motion with every step, or what it complains of. What was compiled once is not compiled again.
    fn run(&self) -> Result<Vec<Value>, String> {
        let output = Command::new(&self.python)
            .current_dir(self.folder.path())
            .args([
                "-c",
                SCRIPT,
                &json!(STEPS).to_string(),
                &DURATION.to_string(),
                &self.model,
            ])
            .output()
            .unwrap();
        match output.status.success() {
            true => Ok(serde_json::from_slice(&output.stdout).unwrap()),
            false => Err(String::from_utf8_lossy(&output.stderr).into_owned()),
        }
    }

    fn text(&self) -> String {
        fs::read_to_string(self.folder.path().join(&self.model)).unwrap()
    }

    fn rewrite(&self, text: &str) {
        fs::write(self.folder.path().join(&self.model), text).unwrap();
    }
}

/// What MuJoCo makes of a robot in this format with every step; `None`, recorded as a skip, without it.
fn runs(proof: &Proof, format: Format) -> Option<Vec<Value>> {
    let exported = Exported::new(proof, format)?;
    let runs = exported.run();
    Some(runs.unwrap_or_else(|words| panic!("{}: {words}", proof.effect)))
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

/// The line of the configuration that has a key.
fn config<'t>(text: &'t str, key: &str) -> &'t str {
    let start = format!("<config key=\"{key}\"");
    text.lines().find(|line| line.contains(&start)).unwrap()
}

/// The text of a model with another value, or without the key.
fn edited(text: &str, key: &str, value: Option<&str>) -> String {
    let line = value.map_or(String::new(), |value| {
        format!("<config key=\"{key}\" value=\"{value}\"/>")
    });
    text.replace(config(text, key), &line)
}

#[test]
fn invariant_a_value_that_is_changed_in_the_model_changes_the_motion_without_compiling() {
    let finest = STEPS[2];
    let mut failures = Vec::new();
    for (effect, parameter, value) in [
        ("stribeck_friction", "j2.stribeck_friction.vs", 3.0),
        (
            "transmission_efficiency",
            "j1.transmission_efficiency.R",
            0.4,
        ),
        ("joint_elasticity", "j3.joint_elasticity.K", 300.0),
        ("drive_gain", "j1.drive_gain.gain", 0.4),
        (
            "torque_current_nonlinearity",
            "j2.torque_current_nonlinearity.c1",
            5.0,
        ),
    ] {
        let before = drives::with_effect(effect);
        let Some(exported) = Exported::new(&before, Format::Mujoco) else {
            return;
        };
        let first = exported.run().unwrap();
        let library = exported.folder.path().join("libexid_drive.so");
        let compiled = fs::read(&library).unwrap();
        exported.rewrite(&edited(
            &exported.text(),
            parameter,
            Some(&format!("{value:?}")),
        ));
        let second = exported.run().unwrap();
        assert!(fs::read(&library).unwrap() == compiled);
        let after = drives::with_effect(effect).with(parameter, value);
        let changed = distance(&before, &second[2], finest);
        let own = distance(&before, &first[2], finest);
        println!("{effect}: {own:.1e} of the way apart, {changed:.1e} with another value");
        if changed < 10.0 * own {
            failures.push(format!(
                "{effect}: {changed:.1e} is nothing beside {own:.1e}"
            ));
        }
        failures.extend(shrinks(effect, &second, |run, h| distance(&after, run, h)));
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn invariant_numbers_of_the_plugin_read_back_to_the_same_bits() {
    for proof in &proofs() {
        let written = export(&proof.outcome, Format::Mujoco).unwrap();
        let [model, source] = &written.files[..] else {
            panic!("two files")
        };
        for joint in &proof.outcome.machine().unwrap().joints {
            let constant = joint
                .torque_constant
                .map(|value| ("torque_constant".to_string(), value));
            let of_effects = joint.effects.iter().flat_map(|effect| {
                let parameters = effect.parameters.iter();
                parameters.map(|p| (format!("{}.{}", effect.id, p.name), p.value))
            });
            for (name, value) in of_effects.chain(constant) {
                let key = format!("{}.{name}", joint.name);
                if !model.text.contains(&format!("key=\"{key}\"")) {
                    continue;
                }
                let line = config(&model.text, &key);
                let text = line.split('"').nth(3).unwrap();
                assert_eq!(
                    text.parse::<f64>().unwrap().to_bits(),
                    value.to_bits(),
                    "{line}"
                );
                assert!(source.text.contains(&format!("\"{key}\"")));
            }
        }
        // A robot of this kind with other numbers has the same source.
        let mut other = proof.outcome.clone();
        let Part::Fit(fit) = &mut other.part else {
            panic!("a fit")
        };
        let machine = fit.machine.as_mut().unwrap();
        for joint in &mut machine.joints {
            joint.offset *= 0.99;
            joint.torque_constant = joint.torque_constant.map(|constant| 0.99 * constant);
            let parameters = joint.effects.iter_mut().flat_map(|e| &mut e.parameters);
            parameters.for_each(|parameter| parameter.value *= 0.99);
        }
        let entries = machine.coupling.iter_mut().flatten().flatten();
        entries
            .filter(|entry| **entry != 1.0)
            .for_each(|entry| *entry *= 0.99);
        let written = export(&other, Format::Mujoco).unwrap();
        assert_eq!(written.files[1].text, source.text, "{}", proof.effect);
        assert_ne!(written.files[0].text, model.text, "{}", proof.effect);
    }
}

#[test]
fn what_is_wrong_with_a_value_is_said_with_key_joint_and_value() {
    let Some(exported) = Exported::new(&drives::with_effect("kinematic_coupling"), Format::Mujoco)
    else {
        return;
    };
    exported.run().unwrap();
    let text = exported.text();
    let constant = "j2.torque_constant";
    let key = |words: &str| format!("config key \"{constant}\" (joint j2) {words}");
    for (model, words) in [
        (
            edited(&text, constant, None),
            format!("config has no key \"{constant}\" (joint j2)"),
        ),
        (
            edited(&text, constant, Some("")),
            format!("config has no key \"{constant}\" (joint j2)"),
        ),
        (
            edited(&text, constant, Some("12,5")),
            format!("value \"12,5\" of {}", key("is no number")),
        ),
        (
            edited(&text, constant, Some("1 2")),
            format!("value \"1 2\" of {}", key("is no number")),
        ),
        (
            edited(&text, constant, Some("nan")),
            format!("value \"nan\" of {}", key("is no number")),
        ),
        (
            edited(&text, constant, Some("1e999")),
            format!("value \"1e999\" of {}", key("is no number")),
        ),
        (
            edited(&text, constant, Some("0x10")),
            format!("value \"0x10\" of {}", key("is no number")),
        ),
        (
            text.replace(constant, "j2.torque_konstant"),
            "j2.torque_konstant".to_string(),
        ),
    ] {
        exported.rewrite(&model);
        let said = exported.run().unwrap_err();
        assert!(said.contains(&words), "{words}: {said}");
    }
    // Numbers that a law does not allow.
    let key = "j2.stribeck_friction.vs";
    let exported =
        Exported::new(&drives::with_effect("stribeck_friction"), Format::Mujoco).unwrap();
    exported.rewrite(&edited(&exported.text(), key, Some("0")));
    let said = exported.run().unwrap_err();
    assert!(
        said.contains(key) && said.contains("from 1e-05 to 100"),
        "{said}"
    );
    exported.rewrite(&edited(&exported.text(), key, Some(" +1.5e-1 ")));
    exported.run().unwrap();
}
