//! Every effect of the vocabulary in exported code: motion to signal and signal to joint torque, compiled or run in each
//! language, against the chain along the same course.

use super::*;
use exid::chain::effect::{EFFECTS, Effect, Law, Memory, Samples, Surroundings, find};
use exid::chain::forward::{Accuracy, Driven, Forward, State, Told, acts};
use exid::outcome::machine::{MachineEffect, MachineJoint};

/// s between samples.
const STEP: f64 = 0.002;

const SAMPLES: usize = 60;

/// Whole samples by which the signal is late where the effect is a delay: it acts after it is given.
const LATE: isize = -3;

const ROBOT: &str = r#"<robot name="three">
  <link name="base"/>
  <link name="l1"><inertial><origin xyz="0.05 0.02 0.1" rpy="0.1 0.2 0.3"/><mass value="4"/>
    <inertia ixx="0.05" iyy="0.06" izz="0.04" ixy="0.003" ixz="-0.002" iyz="0.001"/></inertial></link>
  <link name="l2"><inertial><origin xyz="0.2 -0.03 0.01"/><mass value="3"/>
    <inertia ixx="0.01" iyy="0.07" izz="0.06" ixy="0" ixz="0.002" iyz="0"/></inertial></link>
  <link name="l3"><inertial><origin xyz="0.1 0.01 -0.02"/><mass value="1.5"/>
    <inertia ixx="0.004" iyy="0.02" izz="0.019" ixy="0.001" ixz="0" iyz="0"/></inertial></link>
  <joint name="j1" type="continuous"><origin xyz="0 0 0.3" rpy="0.2 -0.1 0"/><parent link="base"/><child link="l1"/>
    <axis xyz="0 0.6 0.8"/></joint>
  <joint name="j2" type="continuous"><origin xyz="0.1 0 0.2" rpy="1.2 0 0.4"/><parent link="l1"/><child link="l2"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="j3" type="prismatic"><origin xyz="0.4 0 0"/><parent link="l2"/><child link="l3"/>
    <axis xyz="1 0 0"/><limit lower="-2" upper="2" effort="1000" velocity="10"/></joint>
</robot>"#;

/// A robot with one effect beside rotors and friction, and what the chain says of it.
pub struct Proof {
    pub effect: &'static str,
    pub outcome: Outcome,
    robot: Robot,
    /// Of the encoders, `[order][joint][sample]`.
    encoders: Motion,
    links: Motion,
    signal: Vec<Vec<f64>>,
    /// Torques of the drives on the links.
    torque: Vec<Vec<f64>>,
}

struct Robot {
    model: Model,
    values: DVector<f64>,
    outcome: Outcome,
}

impl Proof {
    /// Signals of the chain along a motion of the encoders with this time between samples.
    pub fn predicted(&self, encoders: &Motion, step: f64) -> Vec<Vec<f64>> {
        let inverse = self
            .robot
            .model
            .coupling(&self.robot.values)
            .try_inverse()
            .unwrap();
        let mut motors = encoders.clone();
        for (order, series) in motors.iter_mut().enumerate() {
            for (j, to) in series.iter_mut().enumerate() {
                for (k, to) in to.iter_mut().enumerate() {
                    let from = |i: usize| {
                        let offset = if order == 0 {
                            self.robot.outcome.machine().unwrap().joints[i].offset
                        } else {
                            0.0
                        };
                        encoders[order][i][k] - offset
                    };
                    *to = (0..encoders[order].len())
                        .map(|i| inverse[(j, i)] * from(i))
                        .sum();
                }
            }
        }
        along(
            &self.robot,
            &motors,
            (step, self.robot.model.payload().is_some()),
        )
    }
}

impl Proof {
    /// The same robot with another value of a parameter; what the chain says of its recorded course stays that of before.
    pub fn with(mut self, name: &str, value: f64) -> Self {
        let index = self.robot.model.find(name).unwrap();
        self.robot.values[index] = value;
        set(&mut self.robot.outcome, name, value);
        set(&mut self.outcome, name, value);
        self
    }

    /// Positions of the links from rest at zero on, `[joint][step]`, by the forward model under controls at these times.
    pub fn simulated(
        &self,
        controls: impl Fn(f64) -> [f64; 3],
        [step, duration]: [f64; 2],
    ) -> Vec<Vec<f64>> {
        let Robot {
            model,
            values,
            outcome,
        } = &self.robot;
        let accuracy = Accuracy {
            step,
            ..Accuracy::default().halved()
        };
        let mut forward = Forward::new(model, values, model.payload().is_some(), accuracy).unwrap();
        let coupling = model.coupling(values);
        let joints = &outcome.machine().unwrap().joints;
        let constant = DVector::from_fn(joints.len(), |j, _| joints[j].offset);
        let inverse = coupling.clone().try_inverse().unwrap();
        let n = joints.len();
        // The plugin begins with the twists that bear the torques of the motors at rest.
        let straight = &inverse * -&constant;
        let machine = outcome.machine().unwrap();
        let twist = |j: usize| lags(machine, j, &[-at_rest(&joints[j], straight[j])])[0][0];
        let twists = DVector::from_fn(n, |j, _| if forward.lags() > 0 { twist(j) } else { 0.0 });
        let motors = &inverse * (&twists - &constant);
        let mut state = State {
            position: motors
                .iter()
                .chain(twists.iter())
                .copied()
                .take(n + forward.lags())
                .collect(),
            velocity: vec![0.0; n + forward.lags()],
            memory: vec![0.0; n],
        };
        assert!([0, n].contains(&forward.lags()));
        let late = joints[0].value("time_delay", "delay").unwrap_or(0.0);
        let driven = |forward: &Forward<'_>, time: f64| -> Vec<f64> {
            let controls = DVector::from_row_slice(&controls((time - late).max(0.0)));
            // A commanded position is one of a joint.
            let told = &inverse * (&controls - &constant);
            let aim = |k: usize| {
                let told = Told {
                    position: told[k],
                    ..Told::default()
                };
                forward.aim(k, told)
            };
            match forward.is_controlled() {
                true => (0..n).map(aim).collect(),
                false => forward.motor_torques(controls.as_slice()),
            }
        };
        let mut out = vec![Vec::new(); n];
        for k in 0..(duration / step).round() as usize {
            let [from, to] = [k, k + 1].map(|k| driven(&forward, step * k as f64));
            let (from, to) = (&from[..], &to[..]);
            let driven = match forward.is_controlled() {
                true => Driven::Command { from, to },
                false => Driven::Torque { from, to },
            };
            forward.advance(&mut state, driven, step).unwrap();
            let moved = &coupling * DVector::from_row_slice(&state.position[..n]) + &constant;
            for (j, series) in out.iter_mut().enumerate() {
                series.push(moved[j] - state.position.get(n + j).copied().unwrap_or(0.0));
            }
        }
        out
    }
}

/// Torque that the laws of a motor take while it stands.
fn at_rest(joint: &MachineJoint, position: f64) -> f64 {
    let of = |effect: &MachineEffect| {
        let known = find(&effect.id).unwrap();
        let Law::Motor(law) = known.law else {
            return 0.0;
        };
        // Friction is none at rest.
        if !known.needs.borrows.is_empty() || known.needs.memory != Memory::None {
            return 0.0;
        }
        let parameters: Vec<f64> = effect.parameters.iter().map(|p| p.value).collect();
        let samples = Samples {
            position: &[position],
            velocity: &[0.0],
            acceleration: &[0.0],
            sign: &[0.0],
            time: &[],
            cyclic: false,
            surroundings: Surroundings::default(),
        };
        law.torques(samples, &parameters)[0]
    };
    joint.effects.iter().map(of).sum()
}

/// A robot under position controllers.
pub fn controlled(effects: &[&str]) -> Proof {
    let head = "[recordings]\ntrain = [\"none.csv\"]\nsignal = \"position_command\"\n[controller]\nkp = 60.0\nkd = 4.0\n[drive]\n";
    prove("controlled", effects, head)
}

/// A robot with rotors, friction and an effect.
pub fn with_effect(id: &str) -> Proof {
    let effect = find(id).unwrap();
    proof(effect)
}

fn robot(effects: &[&str], head: &str) -> Robot {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("three.urdf"), ROBOT).unwrap();
    let path = folder.path().join("problem.toml");
    let text = format!(
        "name = \"robot\"\n[robot]\nurdf = \"three.urdf\"\ninertials = \"known\"\ngravity = [1.0, -2.0, -9.0]\n{head}\
         effects = {effects:?}\n"
    );
    fs::write(&path, text).unwrap();
    let (problem, robot, model) = open(&path);
    let mut values = drawn_values(&model, 5);
    for (value, parameter) in values.iter_mut().zip(model.parameters()) {
        let end = parameter.name.rsplit('.').take(2).collect::<Vec<_>>();
        match end.as_slice() {
            ["roll", _] => *value = 0.2,
            ["pitch", _] => *value = -0.3,
            ["delay", _] if head.contains("position_command") => *value = -(LATE as f64) * STEP,
            ["delay", _] => *value = LATE as f64 * STEP,
            ["from", _] => *value = 0.031,
            ["to", _] => *value = 0.083,
            ["time_constant", _] => *value = 0.1,
            ["c3", _] => *value = -0.02,
            // No gear gives more torque than it takes.
            ["R", _] => *value *= 0.75,
            ["K", _] => *value = 3e3,
            ["gap", _] => *value = 0.004,
            ["order", _] => *value = 7.0,
            _ => {}
        }
    }
    let declared = ModelSpec::without_prior(&problem, &robot).unwrap();
    let machine = setup::machine::record(&declared, &robot, &model, &values, None);
    Robot {
        model,
        values,
        outcome: outcome(machine),
    }
}

/// Sums of two sines per motor.
fn course(n: usize) -> Motion {
    let mut rng = generator(31);
    let mut motion: Motion = std::array::from_fn(|_| vec![Vec::new(); n]);
    for j in 0..n {
        let waves = [9.0, 31.0].map(|w| {
            (
                w,
                (1.0 + symmetric(&mut rng, 0.5)) / w,
                symmetric(&mut rng, 3.0),
            )
        });
        for k in 0..SAMPLES {
            let t = STEP * k as f64;
            let sum = |f: &dyn Fn(f64, f64, f64) -> f64| -> f64 {
                waves.iter().map(|&(w, a, p)| f(w, a, w * t + p)).sum()
            };
            motion[0][j].push(sum(&|_, a, x| a * x.sin()));
            motion[1][j].push(sum(&|w, a, x| a * w * x.cos()));
            motion[2][j].push(sum(&|w, a, x| -a * w * w * x.sin()));
        }
    }
    motion
}

fn along(robot: &Robot, [q, dq, ddq]: &Motion, (step, loaded): (f64, bool)) -> Vec<Vec<f64>> {
    let samples = q[0].len();
    let time: Vec<f64> = (0..samples).map(|k| step * k as f64).collect();
    let mut evaluator = Evaluator::along(&robot.model, &robot.values, &[], samples);
    let segment = Segment {
        time: &time,
        temperature: &[],
        ..Segment::states(Trajectory { q, dq, ddq }, loaded)
    };
    let block = evaluator.evaluate_whole(segment);
    (0..q.len())
        .map(|c| block.value(c)[..samples].to_vec())
        .collect()
}

/// The lag that resists with these torques, by bisection at every sample, and its rates by backward differences.
fn lags(machine: &Machine, j: usize, torque: &[f64]) -> [Vec<f64>; 3] {
    let value = |effect, parameter| machine.joints[j].value(effect, parameter);
    let stiffness = value("joint_elasticity", "K").unwrap_or(1e6);
    let damping = value("joint_elasticity", "D").unwrap_or(1e3);
    let half = 0.5 * value("backlash", "gap").unwrap_or(0.0);
    let contact = |lag: f64, rate: f64| {
        let root = |x: f64| x.hypot(1e-4);
        let (near, far) = (lag - half, lag + half);
        let stretch = 0.5 * (near + root(near) + far - root(far));
        let slope = 1.0 + 0.5 * (near / root(near) - far / root(far));
        stiffness * stretch + damping * slope * rate
    };
    let mut out: [Vec<f64>; 3] = Default::default();
    for (k, torque) in torque.iter().enumerate() {
        let before = |order: usize, back: usize| {
            let series: &Vec<f64> = &out[order];
            series
                .get(k.wrapping_sub(back))
                .or(series.first())
                .copied()
                .unwrap_or(0.0)
        };
        let weight = if k == 0 { 0.0 } else { 1.5 / STEP };
        let past = |order| weight / 3.0 * (before(order, 2) - 4.0 * before(order, 1));
        let (p, r) = (past(0), past(1));
        let (mut low, mut high) = (-1.0, 1.0);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if contact(middle, weight * middle + p) < *torque {
                low = middle;
            } else {
                high = middle;
            }
        }
        let rate = weight * low + p;
        for (series, value) in out.iter_mut().zip([low, rate, weight * rate + r]) {
            series.push(value);
        }
    }
    out
}

fn proof(effect: &'static Effect) -> Proof {
    let (mut head, mut drive) = (
        String::new(),
        "[drive]\ntorque_constant = [13.0, -12.0, 8.0]\n".to_string(),
    );
    match effect.law {
        Law::Body => head.push_str("payload = \"last\"\n"),
        Law::Coupling => drive.push_str(
            "coupling = [[1, 0, 0], [0.2, 1, 0], [0.03, -0.1, 1]]\noffset = [0.1, 0.0, -0.2]\n",
        ),
        _ => {}
    }
    let mut effects = vec!["rotor_inertia", "viscous_friction", "coulomb_friction"];
    if !effects.contains(&effect.id) && !matches!(effect.law, Law::Body) {
        effects.push(effect.id);
    }
    prove(effect.id, &effects, &format!("{head}{drive}"))
}

fn prove(id: &'static str, effects: &[&str], head: &str) -> Proof {
    let robot = robot(effects, head);
    let n = robot.model.tree().len();
    let motors = course(n);
    let loaded = robot.model.payload().is_some();
    let signal = along(&robot, &motors, (STEP, loaded));
    let machine = robot.outcome.machine().unwrap().clone();
    let coupling = robot.model.coupling(&robot.values);
    let mut encoders = motors.clone();
    for (order, series) in encoders.iter_mut().enumerate() {
        for k in 0..SAMPLES {
            for (i, to) in series.iter_mut().enumerate() {
                let moved: f64 = (0..n).map(|j| coupling[(i, j)] * motors[order][j][k]).sum();
                to[k] = moved
                    + if order == 0 {
                        machine.joints[i].offset
                    } else {
                        0.0
                    };
            }
        }
    }
    // The same links with nothing but what lets them lag, read in torques: what the drives exert on them.
    let lagging: Vec<&str> = effects
        .iter()
        .copied()
        .filter(|id| {
            [
                "joint_elasticity",
                "backlash",
                "joint_spring",
                "external_contact",
            ]
            .contains(id)
        })
        .collect();
    let bare_head = head.replace("torque_constant = [13.0, -12.0, 8.0]\n", "");
    let bare_head: String = bare_head
        .lines()
        .filter(|l| !l.starts_with("coupling") && !l.starts_with("offset"))
        .map(|l| format!("{l}\n"))
        .collect();
    let mut bare = self::robot(&lagging, &bare_head);
    for (p, parameter) in bare.model.parameters().iter().enumerate() {
        if let Ok(at) = robot.model.find(&parameter.name) {
            bare.values[p] = robot.values[at];
        }
    }
    let mut links = encoders.clone();
    if effects
        .iter()
        .any(|id| ["joint_elasticity", "backlash"].contains(id))
    {
        let torque = along(&bare, &encoders, (STEP, loaded));
        for j in 0..n {
            let lag = lags(&machine, j, &torque[j]);
            for (series, lag) in links.iter_mut().zip(lag) {
                series[j].iter_mut().zip(lag).for_each(|(x, lag)| *x -= lag);
            }
        }
    }
    // The torque of laws at the joint is between the drive and the bodies.
    Proof {
        effect: id,
        outcome: robot.outcome.clone(),
        robot,
        encoders,
        torque: torques_along(&machine, &links, loaded),
        links,
        signal,
    }
}

fn torques_along(machine: &Machine, [q, dq, ddq]: &Motion, loaded: bool) -> Vec<Vec<f64>> {
    exid::robot::batch::torques(
        &machine.tree(loaded),
        &machine.tree(loaded).parameters(),
        Trajectory { q, dq, ddq },
    )
}

pub fn proofs() -> Vec<Proof> {
    let mut proofs: Vec<Proof> = EFFECTS.iter().map(|effect| proof(effect)).collect();
    // A current of zero leaves open what the torque is, and a lag remembers it.
    let all: Vec<&str> = EFFECTS
        .iter()
        .filter(|e| {
            !matches!(
                e.law,
                Law::Body | Law::Delay | Law::Tilt | Law::Play | Law::Current
            )
        })
        .map(|e| e.id)
        .collect();
    let head = "[drive]\ntorque_constant = [13.0, -12.0, 8.0]\n";
    proofs.push(prove("all together", &all, head));
    let moving = EFFECTS.iter().filter(|e| all.contains(&e.id) && acts(e));
    let moving: Vec<&str> = moving.map(|e| e.id).collect();
    proofs.push(prove("all of the motion together", &moving, head));
    proofs
}

fn row(motion: &[Vec<f64>], k: usize) -> Vec<f64> {
    motion.iter().map(|series| series[k]).collect()
}

/// Every proof's signals from the exported inverse and torques from the exported drive, `[proof][direction][joint][sample]`.
type Found = Vec<[Vec<Vec<f64>>; 2]>;

fn assert_proofs(format: Format, run: impl Fn(&Path, &[Proof]) -> Option<Vec<Vec<f64>>>) {
    let proofs = proofs();
    let folder = tempfile::tempdir().unwrap();
    for (p, proof) in proofs.iter().enumerate() {
        let mut outcome = proof.outcome.clone();
        outcome.name = format!("robot{p}");
        let written = export(&outcome, format).unwrap_or_else(|e| panic!("{}: {e}", proof.effect));
        for file in &written.files {
            fs::write(folder.path().join(&file.name), &file.text).unwrap();
        }
    }
    let Some(rows) = run(folder.path(), &proofs) else {
        return;
    };
    let mut rows = rows.into_iter();
    let mut found: Found = Vec::new();
    for proof in &proofs {
        let n = proof.signal.len();
        let mut both: [Vec<Vec<f64>>; 2] = std::array::from_fn(|_| vec![Vec::new(); n]);
        for direction in &mut both {
            for _ in 0..SAMPLES {
                for (to, x) in direction.iter_mut().zip(rows.next().unwrap()) {
                    to.push(x);
                }
            }
        }
        found.push(both);
    }
    let mut failures = Vec::new();
    for (proof, [signal, torque]) in proofs.iter().zip(&found) {
        let late = if proof.effect == "time_delay" {
            LATE
        } else {
            0
        };
        let begin = late.unsigned_abs();
        let chosen = begin..SAMPLES - begin;
        let largest = |of: &[Vec<f64>]| of.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
        for (what, found, expected, late) in [
            ("signal", signal, &proof.signal, late),
            ("torque", torque, &proof.torque, 0),
        ] {
            let size = largest(expected);
            let mut worst = 0.0_f64;
            for (j, (found, expected)) in found.iter().zip(expected).enumerate() {
                for k in chosen.clone() {
                    // Below the torque at which current flows a current of zero does not say what the torque is.
                    if what == "torque" && proof.signal[j][k] == 0.0 {
                        continue;
                    }
                    let expected = expected[(k as isize + late) as usize];
                    // Not a number counts as worst.
                    worst = worst.max((found[k] - expected).abs() / size);
                    if found[k].is_nan() {
                        worst = f64::INFINITY;
                    }
                }
            }
            println!("{format:?} {} {what}: {worst:.1e}", proof.effect);
            if worst.is_nan() || worst > TORQUES {
                failures.push(format!("{} {what}: {worst:.1e}", proof.effect));
            }
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn invariant_every_effect_in_rust_code_is_that_of_the_chain() {
    assert_proofs(Format::Rust, |folder, proofs| {
        let mut text = String::from("#![allow(dead_code)]\n");
        let mut main = String::from("fn main() {\n");
        for (p, proof) in proofs.iter().enumerate() {
            text.push_str(&format!("mod robot{p};\n"));
            main.push_str(&format!(
                "  {{ use robot{p}::*; let mut out = [0.0; JOINTS];\n"
            ));
            for inverse in [true, false] {
                main.push_str("    let mut state = [0.0; STATES];\n");
                let motion = if inverse {
                    &proof.encoders
                } else {
                    &proof.links
                };
                for k in 0..SAMPLES {
                    let [q, dq, ddq] = [0, 1, 2].map(|order: usize| row(&motion[order], k));
                    main.push_str(&match inverse {
                        true => {
                            let load = if proof.outcome.machine().unwrap().payload.is_some() { "_with_load" } else { "" };
                            format!("    inverse_step{load}(&mut state, {STEP:?}, &{q:?}, &{dq:?}, &{ddq:?}, &mut out);\n")
                        }
                        false => format!(
                            "    drive_step(&mut state, {STEP:?}, &{:?}, &{q:?}, &{dq:?}, &{ddq:?}, &mut out);\n",
                            row(&proof.signal, k)
                        ),
                    });
                    main.push_str("    println!(\"{:?}\", out);\n");
                }
            }
            main.push_str("  }\n");
        }
        fs::write(folder.join("driver.rs"), format!("{text}{main}}}\n")).unwrap();
        code::run(
            folder,
            "rustc",
            &["--edition", "2021", "driver.rs", "-o", "driver"],
        )
    });
}

#[test]
fn invariant_every_effect_in_c_code_is_that_of_the_chain() {
    assert_proofs(Format::C, |folder, proofs| {
        let mut text = String::from("#include <stdio.h>\n#include <string.h>\n");
        let mut main = String::from("int main(void) {\n");
        let mut sources = Vec::new();
        let array = |x: Vec<f64>| {
            format!(
                "(double[]){{{}}}",
                x.iter()
                    .map(|x| format!("{x:?}"))
                    .collect::<Vec<_>>()
                    .join(", ")
            )
        };
        for (p, proof) in proofs.iter().enumerate() {
            text.push_str(&format!("#include \"robot{p}.h\"\n"));
            sources.push(format!("robot{p}.c"));
            main.push_str(&format!(
                "  {{ double out[ROBOT{p}_JOINTS], state[ROBOT{p}_STATES];\n"
            ));
            for inverse in [true, false] {
                main.push_str("    memset(state, 0, sizeof state);\n");
                let motion = if inverse {
                    &proof.encoders
                } else {
                    &proof.links
                };
                for k in 0..SAMPLES {
                    let [q, dq, ddq] = [0, 1, 2].map(|order: usize| array(row(&motion[order], k)));
                    main.push_str(&match inverse {
                        true => {
                            let load = if proof.outcome.machine().unwrap().payload.is_some() { "_with_load" } else { "" };
                            format!("    robot{p}_inverse_step{load}(state, {STEP:?}, {q}, {dq}, {ddq}, out);\n")
                        }
                        false => format!(
                            "    robot{p}_drive_step(state, {STEP:?}, {}, {q}, {dq}, {ddq}, out);\n",
                            array(row(&proof.signal, k))
                        ),
                    });
                    main.push_str(&format!("    printf(\"[\"); for (int k = 0; k < ROBOT{p}_JOINTS; k++) printf(k ? \",%.17g\" : \"%.17g\", out[k]); printf(\"]\\n\");\n"));
                }
            }
            main.push_str("  }\n");
        }
        fs::write(
            folder.join("driver.c"),
            format!("{text}{main}  return 0;\n}}\n"),
        )
        .unwrap();
        let mut arguments = vec!["-std=c99", "-Wall", "-Wextra", "-pedantic", "driver.c"];
        arguments.extend(sources.iter().map(String::as_str));
        arguments.extend(["-o", "driver", "-lm"]);
        code::run(folder, "cc", &arguments)
    });
}

#[test]
fn invariant_every_effect_in_numpy_code_is_that_of_the_chain() {
    assert_proofs(Format::NumPy, |folder, proofs| {
        let cases: Vec<Value> = proofs
            .iter()
            .map(|proof| {
                let load = proof.outcome.machine().unwrap().payload.is_some();
                json!({
                    "inverse": if load { "inverse_step_with_load" } else { "inverse_step" },
                    "encoders": proof.encoders, "links": proof.links, "signal": proof.signal,
                })
            })
            .collect();
        fs::write(folder.join("cases.json"), json!(cases).to_string()).unwrap();
        let driver = format!(
            "import json, importlib, warnings\nimport numpy as np\nwarnings.simplefilter('error')\n\
             with open('cases.json') as file:\n    cases = json.load(file)\n\
             for p, case in enumerate(cases):\n    robot = importlib.import_module(f'robot{{p}}')\n    \
             for function, motion in ((getattr(robot, case['inverse']), case['encoders']), (None, case['links'])):\n        \
             state, motion, signal = np.zeros(robot.STATES), np.array(motion), np.array(case['signal'])\n        \
             for k in range({SAMPLES}):\n            at = motion[:, :, k]\n            \
             out = function(state, {STEP:?}, *at) if function else robot.drive_step(state, {STEP:?}, signal[:, k], *at)\n            \
             print(json.dumps(out.tolist()))\n"
        );
        fs::write(folder.join("driver.py"), driver).unwrap();
        let python = python()?;
        let output = Command::new(python)
            .current_dir(folder)
            .arg("driver.py")
            .output()
            .unwrap();
        let words = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && words.is_empty(), "{words}");
        let text = String::from_utf8(output.stdout).unwrap();
        Some(
            text.lines()
                .map(|line| serde_json::from_str(line).unwrap())
                .collect(),
        )
    });
}

/// A Python with NumPy; `None`, recorded as a skip, where there is none.
pub fn python() -> Option<std::ffi::OsString> {
    let python = std::env::var_os("EXID_PYTHON").unwrap_or_else(|| "python3".into());
    let asked = Command::new(&python).args(["-c", "import numpy"]).output();
    if asked.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    common::skip("no Python with NumPy: EXID_PYTHON names one");
    None
}
