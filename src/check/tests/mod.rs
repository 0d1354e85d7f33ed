//! Recordings of a simulated arm, broken in one way each: exactly the right finding must come.

mod arm;
mod many_joints;

use crate::check::run;
use crate::check::tests::arm::{Arm, Problem, RATE_HZ};
use crate::outcome::check::{Mistake, Severity};
use crate::problem::solution::Control;
use crate::robot::random::{generator, symmetric};

/// Angle by which the first axis of a tilted robot leans, rad.
const LEAN: f64 = 0.03;

/// One way to break a problem, and what has to be found.
struct Break {
    name: &'static str,
    apply: fn(&mut Problem),
    code: &'static str,
    /// Channels of the findings.
    channels: &'static [&'static str],
}

/// A finding about a whole file.
const WHOLE: &[&str] = &[""];

const BREAKS: &[Break] = &[
    Break {
        name: "positions in degrees",
        apply: |p| scale(&mut p.train.q, 180.0 / std::f64::consts::PI),
        code: "position-in-degrees",
        channels: WHOLE,
    },
    Break {
        name: "one position in degrees",
        apply: |p| scale(&mut p.train.q[1..2], 180.0 / std::f64::consts::PI),
        code: "position-in-degrees",
        channels: &["j2"],
    },
    Break {
        name: "time in milliseconds",
        apply: |p| p.train.t.iter_mut().for_each(|t| *t *= 1e3),
        code: "time-unit",
        channels: &["time"],
    },
    Break {
        name: "time in microseconds",
        apply: |p| p.train.t.iter_mut().for_each(|t| *t *= 1e6),
        code: "time-unit",
        channels: &["time"],
    },
    Break {
        name: "time jumps back",
        apply: |p| p.train.t[700] -= 1.0,
        code: "time-not-increasing",
        channels: &["time"],
    },
    Break {
        name: "dropped samples",
        apply: |p| p.train.remove(700..740),
        code: "missing-samples",
        channels: &["time"],
    },
    Break {
        name: "an encoder that slips",
        apply: |p| p.train.q[1][700..].iter_mut().for_each(|q| *q += 0.02),
        code: "position-jumps",
        channels: &["j2"],
    },
    Break {
        name: "angles that start anew after a turn",
        apply: |p| {
            let turn = std::f64::consts::TAU;
            let lowest = p.train.q[2].iter().copied().fold(f64::MAX, f64::min);
            let anew = |q: &mut f64| *q = (*q - lowest - 0.1).rem_euclid(turn) + lowest;
            p.train.q[2].iter_mut().for_each(anew);
        },
        code: "position-jumps",
        channels: &["j3"],
    },
    Break {
        name: "velocity in degrees per second",
        apply: |p| {
            p.with_velocity();
            scale(&mut p.train.dq[2..3], 180.0 / std::f64::consts::PI);
        },
        code: "velocity-factor",
        channels: &["j3"],
    },
    Break {
        name: "velocity columns exchanged",
        apply: |p| {
            p.with_velocity();
            p.train.dq.swap(0, 1);
        },
        code: "velocity-order",
        channels: &["j1", "j2"],
    },
    Break {
        name: "saturated torque",
        apply: |p| {
            let largest = p.train.tau[1].iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            let limit = 0.9 * largest;
            p.train.tau[1]
                .iter_mut()
                .for_each(|x| *x = x.clamp(-limit, limit));
        },
        code: "saturated",
        channels: &["j2"],
    },
    Break {
        name: "stuck torque",
        apply: |p| {
            let held = p.train.tau[3][900];
            p.train.tau[3][900..1300].fill(held);
        },
        code: "stuck",
        channels: &["j4"],
    },
    Break {
        name: "coarse encoder",
        apply: |p| {
            p.train.q[2]
                .iter_mut()
                .for_each(|q| *q = (*q / 0.01).round() * 0.01)
        },
        code: "coarse-position",
        channels: &["j3"],
    },
    Break {
        name: "spikes",
        apply: |p| (1..6).for_each(|k| p.train.tau[0][600 * k] += 200.0),
        code: "spikes",
        channels: &["j1"],
    },
    Break {
        name: "not a number",
        apply: |p| p.train.tau[0][100] = f64::NAN,
        code: "missing-values",
        channels: &["tau1"],
    },
    Break {
        name: "signals exchanged",
        apply: |p| p.train.tau.swap(1, 2),
        code: "joint-order",
        channels: &["j2", "j3"],
    },
    Break {
        name: "signals of three joints in a circle",
        apply: |p| p.train.tau[0..3].rotate_left(1),
        code: "joint-order",
        channels: &["j1", "j2", "j3"],
    },
    Break {
        name: "positions exchanged",
        apply: |p| p.train.q.swap(1, 2),
        code: "joint-order",
        channels: &["j2", "j3"],
    },
    Break {
        name: "positions and signals exchanged",
        apply: |p| {
            p.train.q.swap(0, 2);
            p.train.tau.swap(0, 2);
        },
        code: "joint-order",
        channels: &["j1", "j3"],
    },
    Break {
        name: "signal with the wrong sign",
        apply: |p| scale(&mut p.train.tau[2..3], -1.0),
        code: "signal-sign",
        channels: &["j3"],
    },
    Break {
        name: "position with the wrong sign",
        apply: |p| scale(&mut p.train.q[1..2], -1.0),
        code: "position-sign",
        channels: &["j2"],
    },
    Break {
        name: "zero of a position a quarter turn away",
        apply: |p| {
            p.train.q[2]
                .iter_mut()
                .for_each(|q| *q -= std::f64::consts::FRAC_PI_2)
        },
        code: "position-zero",
        channels: &["j3"],
    },
    Break {
        name: "robot on the wall",
        apply: |p| p.robot_keys.push_str("gravity = [0.0, 9.81, 0.0]\n"),
        code: "gravity-direction",
        channels: &["robot.gravity"],
    },
    Break {
        name: "a current taken for a torque",
        apply: |p| scale(&mut p.train.tau, 0.1),
        code: "signal-scale",
        channels: WHOLE,
    },
    Break {
        name: "signals 10 ms late",
        apply: |p| p.train.tau.iter_mut().for_each(|tau| tau.rotate_right(2)),
        code: "delay",
        channels: WHOLE,
    },
    Break {
        name: "one signal 10 ms late",
        apply: |p| p.train.tau[1].rotate_right(2),
        code: "delay",
        channels: &["j2"],
    },
    Break {
        name: "a wrong period",
        apply: |p| p.recordings_keys = "period = 4.0\n".into(),
        code: "period-wrong",
        channels: &["period"],
    },
    Break {
        name: "a period that is not stated",
        apply: |p| p.recordings_keys.clear(),
        code: "period-not-stated",
        channels: &["period"],
    },
    Break {
        name: "a joint beyond its limits",
        apply: |p| {
            p.urdf = p.urdf.replace(
                "lower=\"-2.2\" upper=\"2.2\"",
                "lower=\"-0.2\" upper=\"2.2\"",
            )
        },
        code: "position-beyond-limits",
        channels: &["j2"],
    },
    Break {
        name: "a joint faster than its limit",
        apply: |p| p.urdf = p.urdf.replace("velocity=\"6.3\"", "velocity=\"0.9\""),
        code: "velocity-beyond-limits",
        channels: &["j3"],
    },
    Break {
        name: "a torque beyond its limit",
        apply: |p| p.urdf = p.urdf.replace("effort=\"333\"", "effort=\"5\""),
        code: "effort-beyond-limits",
        channels: &["j2"],
    },
    Break {
        name: "an impossible body",
        apply: |p| p.urdf = p.urdf.replace("iyy=\"0.21\"", "iyy=\"2.1\""),
        code: "impossible-inertia",
        channels: &["l2"],
    },
    Break {
        name: "a link without mass",
        apply: |p| {
            p.urdf = p
                .urdf
                .replace("<mass value=\"1.1\"/>", "<mass value=\"0\"/>")
        },
        code: "no-mass",
        channels: &["l4"],
    },
    Break {
        name: "a centre of mass in millimetres",
        apply: |p| p.urdf = p.urdf.replace("xyz=\"0.22 ", "xyz=\"220 "),
        code: "far-centre-of-mass",
        channels: &["l2"],
    },
    Break {
        name: "a gain beside free inertials",
        apply: |p| p.effects = "\"viscous_friction\", \"drive_gain\"",
        code: "not-identifiable",
        channels: &[
            "j1.drive_gain.gain",
            "j2.drive_gain.gain",
            "j3.drive_gain.gain",
            "j4.drive_gain.gain",
        ],
    },
    Break {
        name: "a rotor that turns with the first link",
        apply: |p| p.effects = "\"coulomb_friction\", \"viscous_friction\", \"rotor_inertia\"",
        code: "not-identifiable",
        channels: &["j1.rotor_inertia.Jm", "j2.rotor_inertia.Jm"],
    },
    Break {
        name: "no such file",
        apply: |p| p.validation = "validation = [\"absent.csv\"]\n".into(),
        code: "recording-not-found",
        channels: WHOLE,
    },
];

fn scale(series: &mut [Vec<f64>], factor: f64) {
    series.iter_mut().flatten().for_each(|x| *x *= factor);
}

fn found(problem: &Problem) -> Vec<Mistake> {
    let folder = tempfile::tempdir().unwrap();
    run(&problem.write(folder.path()), &Control::default())
}

fn text(findings: &[Mistake]) -> String {
    let line = |f: &Mistake| {
        format!(
            "{:?} {} {:?}: {}\n",
            f.severity, f.code, f.channel, f.message
        )
    };
    findings.iter().map(line).collect()
}

#[test]
fn a_good_recording_gives_no_finding() {
    let arm = Arm::new();
    let findings = found(&arm.problem());
    assert!(findings.is_empty(), "{}", text(&findings));
    let mut with_velocity = arm.problem();
    with_velocity.with_velocity();
    let findings = found(&with_velocity);
    assert!(findings.is_empty(), "{}", text(&findings));
}

#[test]
fn recovers_known_break_and_finds_no_other() {
    let arm = Arm::new();
    let mut faults = String::new();
    for broken in BREAKS {
        let mut problem = arm.problem();
        (broken.apply)(&mut problem);
        let findings = found(&problem);
        let mut channels: Vec<&str> = findings
            .iter()
            .map(|f| f.channel.as_deref().unwrap_or(""))
            .collect();
        channels.sort_unstable();
        let right = findings.iter().all(|f| f.code == broken.code) && channels == broken.channels;
        if !right {
            faults.push_str(&format!("{}:\n{}\n", broken.name, text(&findings)));
        }
    }
    assert!(faults.is_empty(), "{faults}");
}

/// The robot file has a first axis that leans to one side, and in truth it leans as much to the other: half a turn of the first
/// joint is as good as the tilt, but for the links beyond.
#[test]
fn a_tilted_base_is_no_wrong_zero() {
    let mut problem = Arm::under([0.0, 9.81 * LEAN.sin(), -9.81 * LEAN.cos()]).problem();
    problem.urdf = problem
        .urdf
        .replacen("0 0 0.1\"", &format!("0 0 0.1\" rpy=\"{LEAN} 0 0\""), 1);
    let findings = found(&problem);
    let codes: Vec<&str> = findings.iter().map(|f| f.code.as_str()).collect();
    assert_eq!(codes, ["base-tilt"], "{}", text(&findings));
    assert_eq!(findings[0].severity, Severity::Warning);
    let degrees = format!("{:.1} degrees", (2.0 * LEAN).to_degrees());
    assert!(
        findings[0].message.contains(&degrees),
        "{}",
        text(&findings)
    );
}

#[test]
fn recovers_known_delay_and_says_how_sure_it_is() {
    let mut problem = Arm::new().problem();
    problem
        .train
        .tau
        .iter_mut()
        .for_each(|tau| tau.rotate_right(3));
    let findings = found(&problem);
    // Three samples at 200 Hz; the parabola is right to a hundredth of a sample for this smooth motion.
    assert!(findings[0].message.contains("15.0"), "{}", text(&findings));
}

#[test]
fn a_broken_file_hides_no_finding_about_another() {
    let mut problem = Arm::new().problem();
    problem.train.tau.swap(1, 2);
    problem.validation = "validation = [\"absent.csv\"]\n".into();
    let findings = found(&problem);
    let of = |code: &str| findings.iter().filter(|f| f.code == code).count();
    assert_eq!(
        (of("joint-order"), of("recording-not-found")),
        (2, 1),
        "{}",
        text(&findings)
    );
    assert!(findings.iter().all(|f| f.severity == Severity::Error));
}

#[test]
fn a_drift_of_losses_is_noted() {
    let mut problem = Arm::new().problem();
    let samples = problem.train.t.len();
    for k in 0..samples {
        // Viscous friction of joint 1 falls by 3 N·m·s/rad from start to end.
        problem.train.tau[0][k] -= 3.0 * problem.train.dq[0][k] * k as f64 / samples as f64;
    }
    let findings = found(&problem);
    assert!(
        findings
            .iter()
            .any(|f| f.code == "drift" && f.channel.as_deref() == Some("j1"))
    );
}

#[test]
fn a_joint_that_stands_still_is_named() {
    let problem = Arm::standing(3).problem();
    let findings = found(&problem);
    let named = |code: &str| findings.iter().find(|f| f.code == code);
    assert_eq!(
        named("joint-hardly-moves").unwrap().channel.as_deref(),
        Some("j4")
    );
    assert!(
        findings.iter().all(|f| f.severity != Severity::Error),
        "{}",
        text(&findings)
    );
}

#[test]
fn uneven_steps_of_time_are_named() {
    let mut problem = Arm::new().problem();
    let mut rng = generator(9);
    problem
        .train
        .t
        .iter_mut()
        .for_each(|t| *t += symmetric(&mut rng, 0.3 / RATE_HZ));
    let findings = found(&problem);
    assert!(
        findings.iter().any(|f| f.code == "jitter"),
        "{}",
        text(&findings)
    );
}
