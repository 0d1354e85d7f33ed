//! Commands in files: `exid simulate` and `exid fit`, and what a simulator's file says of gains.

use crate::{
    COULOMB, INERTIA, KD, KP, LEVER, MASS, NOISE, PENDULUM, USUAL, VISCOUS, command, folder,
    motion, times,
};
use exid::robot::random::generator;
use rand::RngExt;
use rand_distr::StandardNormal;
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Runs a verb on a problem and gives its result.
pub fn run(folder: &Path, verb: &str) -> Value {
    run_problem(folder, verb, "problem.toml")
}

fn run_problem(folder: &Path, verb: &str, problem: &str) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_exid"))
        .current_dir(folder)
        .args([verb, problem, "--json", "--quiet", "--threads", "1"])
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{verb}: {errors}");
    serde_json::from_slice(&output.stdout).unwrap()
}

pub fn parameter<'a>(result: &'a Value, name: &str) -> &'a Value {
    let all = result["parameters"].as_array().unwrap();
    all.iter().find(|p| p["name"] == name).unwrap()
}

/// `exid simulate` records commands, `exid fit` finds the gains behind them again.
#[test]
fn recovers_known_truth_from_simulated_commands() {
    let folder = folder("simulated");
    fs::write(folder.join("pendulum.urdf"), PENDULUM).unwrap();
    let text = r#"
[robot]
urdf = "pendulum.urdf"
inertials = "known"
[drive]
effects = ["coulomb_friction", "viscous_friction"]
[recordings]
train = ["train.csv"]
signal = "position_command"
[controller]
kp = "estimate"
kd = 1.2
[simulate]
noise = 2e-4
periods = 3
[simulate.values]
"hinge.controller.kp" = 30.0
"hinge.coulomb_friction.Fc" = 0.3
"hinge.coulomb_friction.w" = 0.05
"hinge.viscous_friction.Fv" = 0.25
"#;
    fs::write(folder.join("problem.toml"), text).unwrap();
    run(&folder, "simulate");
    let made = folder.join("results/problem/simulate/train.csv");
    fs::copy(made, folder.join("train.csv")).unwrap();
    let result = run(&folder, "fit");
    for (name, truth) in [
        ("hinge.controller.kp", 30.0),
        ("hinge.coulomb_friction.Fc", 0.3),
        ("hinge.viscous_friction.Fv", 0.25),
    ] {
        let of = parameter(&result, name);
        let (value, deviation) = (
            of["value"].as_f64().unwrap(),
            of["std_dev"].as_f64().unwrap(),
        );
        assert!((value - truth).abs() < 4.0 * deviation, "{of}");
        assert!(deviation < 0.1 * truth, "{of}");
    }
    // In closed loop, the errors of the position are those that the noise makes.
    let rolled = run_problem(&folder, "rollout", "results/problem/fit");
    assert!(
        rolled["summary"].to_string().contains("commands"),
        "{rolled}"
    );
    for horizon in rolled["horizons"].as_array().unwrap() {
        let errors = &horizon["joints"][0];
        let [after, noise] =
            ["after", "noise"].map(|kind| errors[kind]["median"].as_f64().unwrap());
        assert_eq!(errors["after"]["lost"], 0);
        assert!(after < 2.0 * noise && after < 5e-4, "{errors}");
    }
}

/// A joint that moves alone about the vertical: all of its torque scales with the gain where rotor inertia takes up that of the
/// known link. The friction in the ratio is still told, and gravity on the axis tells the gain.
#[test]
fn gravity_on_the_axis_determines_the_gain_of_a_joint_that_moves_alone() {
    let folder = folder("alone");
    fs::write(folder.join("pendulum.urdf"), PENDULUM).unwrap();
    // The hinge turns about y.
    for (name, gravity, is_determined) in [
        ("along", "[0.0, -9.81, 0.0]", false),
        ("across", "[0.0, 0.0, -9.81]", true),
    ] {
        let text = format!(
            r#"
[robot]
urdf = "pendulum.urdf"
gravity = {gravity}
inertials = "known"
[drive]
effects = ["rotor_inertia", "coulomb_friction", "viscous_friction", "torque_offset"]
[recordings]
train = ["{name}.csv"]
signal = "position_command"
[controller]
kp = "estimate"
kd = 1.2
[simulate]
noise = 2e-4
periods = 3
[simulate.values]
"hinge.controller.kp" = 30.0
"hinge.rotor_inertia.Jm" = 0.05
"hinge.coulomb_friction.Fc" = 0.3
"hinge.coulomb_friction.w" = 0.05
"hinge.viscous_friction.Fv" = 0.25
"hinge.torque_offset.offset" = 0.1
"#
        );
        let problem = format!("{name}.toml");
        fs::write(folder.join(&problem), text).unwrap();
        run_problem(&folder, "simulate", &problem);
        let made = folder.join(format!("results/{name}/simulate/{name}.csv"));
        fs::copy(made, folder.join(format!("{name}.csv"))).unwrap();
        let result = run_problem(&folder, "fit", &problem);
        let kp = parameter(&result, "hinge.controller.kp");
        let base = result["base_parameters"].as_array().unwrap();
        let notes = result["notes"].to_string();
        if is_determined {
            let (value, deviation) = (
                kp["value"].as_f64().unwrap(),
                kp["std_dev"].as_f64().unwrap(),
            );
            assert!((value - 30.0).abs() < 4.0 * deviation, "{kp}");
            assert!(deviation < 1.0, "{kp}");
            assert!(!notes.contains("is not determined"), "{notes}");
        } else {
            assert_eq!(kp["source"], "undetermined", "{kp}");
            assert!(kp["ci95"].is_null(), "{kp}");
            // The known link turns with the rotor, and the known derivative gain brakes with viscous friction.
            let link = INERTIA + MASS * LEVER * LEVER;
            for (sum, value) in [
                ("(hinge.rotor_inertia.Jm + 0.1)", 0.05 + link),
                ("hinge.coulomb_friction.Fc", COULOMB),
                ("(hinge.viscous_friction.Fv + 1.2)", VISCOUS + KD),
                ("hinge.torque_offset.offset", 0.1),
            ] {
                let expression = format!("{sum} / hinge.controller.kp");
                let ratio = base.iter().find(|b| b["expression"] == expression.as_str());
                let ratio = ratio.unwrap_or_else(|| panic!("{expression} is not among {base:#?}"));
                let (own, deviation) = (
                    ratio["value"].as_f64().unwrap(),
                    ratio["std_dev"].as_f64().unwrap(),
                );
                assert!((own - value / KP).abs() < 4.0 * deviation, "{ratio}");
                assert!(deviation < 0.01 * value / KP, "{ratio}");
            }
            assert!(
                notes.contains("hinge.controller.kp is not determined"),
                "{notes}"
            );
            assert!(
                notes.contains("gravity acts on the axis of hinge"),
                "{notes}"
            );
        }
    }
}

/// Gains of position actuators are those of the controllers where the problem file says nothing.
#[test]
fn actuators_of_the_simulators_file_give_the_gains() {
    let folder = folder("actuators");
    let robot = r#"<mujoco><worldbody><body name="arm"><joint name="hinge" axis="0 1 0"/>
<inertial pos="0.2 0 0" mass="2" diaginertia="0.005 0.02 0.02"/></body></worldbody>
<actuator><position joint="hinge" gear="2" kp="7.5" kv="0.3"/></actuator></mujoco>"#;
    fs::write(folder.join("arm.xml"), robot).unwrap();
    let mut csv = String::from("t,q_hinge,command_hinge\n");
    let mut rng = generator(9);
    for t in times() {
        let q = motion(t)[0] + NOISE * rng.sample::<f64, _>(StandardNormal);
        csv += &format!("{t},{q},{}\n", command(t, USUAL, [0.0; 2]));
    }
    fs::write(folder.join("train.csv"), csv).unwrap();
    let text = "[robot]\nmjcf = \"arm.xml\"\ninertials = \"known\"\n[drive]\neffects = [\"coulomb_friction\", \
                \"viscous_friction\"]\n[recordings]\ntrain = [\"train.csv\"]\nsignal = \"position_command\"\n";
    fs::write(folder.join("problem.toml"), text).unwrap();
    let result = run(&folder, "fit");
    // gear² kp and gear² kv, MuJoCo's position actuator.
    assert_eq!(parameter(&result, "hinge.controller.kp")["value"], 30.0);
    assert_eq!(parameter(&result, "hinge.controller.kd")["value"], 1.2);
    let friction = parameter(&result, "hinge.coulomb_friction.Fc");
    let deviation = friction["std_dev"].as_f64().unwrap();
    assert!(
        (friction["value"].as_f64().unwrap() - COULOMB).abs() < 4.0 * deviation,
        "{friction}"
    );
}
