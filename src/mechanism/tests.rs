//! Mechanisms against closed forms, differences and power balance.

use crate::mechanism::condition::{Anchor, Condition};
use crate::mechanism::error::MechanismError;
use crate::mechanism::h4::{CHAINS, H4, PLATFORM};
use crate::mechanism::loops::Mechanism;
use crate::robot::inertia::{CentralInertia, Inertia};
use crate::robot::newton_euler::NewtonEuler;
use crate::robot::random::{generator, symmetric};
use crate::robot::tree::{Joint, JointKind, Limits, Tree};
use nalgebra::{Matrix3, Rotation3, Vector3, Vector4};

const ROBOT: H4 = H4 {
    lever: 0.26,
    rod: 0.48,
    half_bar: 0.06,
    half_width: 0.06,
    radius: 0.14,
};

/// The middle of the workspace.
const HOME: [f64; 4] = [0.0, 0.0, -0.42, 0.0];

fn poses() -> impl Iterator<Item = Vector4<f64>> {
    let mut rng = generator(3);
    (0..40).map(move |_| {
        let mut away = |range: f64| symmetric(&mut rng, range);
        Vector4::from(HOME) + Vector4::new(away(0.1), away(0.1), away(0.08), away(0.5))
    })
}

/// All joints of an H4 at a pose.
fn closed(pose: &Vector4<f64>) -> Vec<f64> {
    let mut q = ROBOT.inverse(pose).unwrap().to_vec();
    q.extend(pose.iter());
    q.extend([pose[3]; 2]);
    q
}

#[test]
fn invariant_loops_close_as_the_lengths_say() {
    let mechanism = ROBOT.mechanism().unwrap();
    for pose in poses() {
        let q = closed(&pose);
        assert!(mechanism.gap(&q).amax() < 1e-14);
        let tree = mechanism.tree();
        let links = tree.forward_kinematics(&q);
        let (sin, cos) = pose[3].sin_cos();
        // A_1 and B_1 of eqs 3 and 6, spelled out.
        let a = Vector3::new(pose[0] + 0.06 * cos, pose[1] + 0.06 * sin + 0.06, pose[2]);
        let b = Vector3::new(0.06 + 0.14 + 0.26 * q[0].cos(), 0.06, -0.26 * q[0].sin());
        assert!(((a - b).norm() - 0.48).abs() < 1e-14);
        let lever = links[0].transform_point(&(Vector3::x() * 0.26).into());
        assert!((lever.coords - b).amax() < 1e-14);
    }
}

#[test]
fn recovers_known_truth_of_the_pose() {
    for pose in poses() {
        let motors = ROBOT.inverse(&pose).unwrap();
        let found = ROBOT.forward(&motors, &Vector4::from(HOME)).unwrap();
        assert!((found - pose).amax() < 1e-9, "{found} {pose}");
    }
}

#[test]
fn invariant_velocities_and_accelerations_are_those_of_differences() {
    const STEP: f64 = 1e-4;
    let mechanism = ROBOT.mechanism().unwrap();
    for pose in poses() {
        // Motors move along q + v t + a t²/2; the platform follows.
        let motors = ROBOT.inverse(&pose).unwrap();
        let (v, a) = ([0.7, -0.4, 0.5, 0.9], [-3.0, 2.0, 4.0, 1.0]);
        let at = |t: f64| {
            let moved = std::array::from_fn(|k| motors[k] + v[k] * t + 0.5 * a[k] * t * t);
            ROBOT.forward(&moved, &pose).unwrap()
        };
        let (before, now, after) = (at(-STEP), at(0.0), at(STEP));
        let rate = (after - before) / (2.0 * STEP);
        let second = (after - now * 2.0 + before) / (STEP * STEP);
        let (mut dq, mut ddq) = (vec![0.0; 10], vec![0.0; 10]);
        dq[..CHAINS].copy_from_slice(&v);
        ddq[..CHAINS].copy_from_slice(&a);
        let q = closed(&pose);
        mechanism.follow(&q, [&mut dq, &mut ddq]);
        for (k, &joint) in PLATFORM.iter().enumerate() {
            // Third and fourth derivatives are within 100 times the first two: h² of that, and rounding / h².
            assert!((dq[joint] - rate[k]).abs() < 1e-5 * (1.0 + rate.amax()));
            assert!((ddq[joint] - second[k]).abs() < 1e-4 * (1.0 + second.amax()));
        }
    }
}

#[test]
fn invariant_the_motors_power_is_the_change_of_energy() {
    const MASS: f64 = 1.05;
    const INERTIA: f64 = 0.003;
    let mechanism = ROBOT.mechanism().unwrap();
    let mut parameters = vec![0.0; 100];
    let nacelle = 10 * PLATFORM[3];
    parameters[nacelle] = MASS;
    parameters[nacelle + 9] = INERTIA;
    let tree = mechanism.tree();
    let mut dynamics = NewtonEuler::new(tree);
    for pose in poses() {
        let q = closed(&pose);
        let (mut dq, mut ddq) = (vec![0.0; 10], vec![0.0; 10]);
        dq[..CHAINS].copy_from_slice(&[0.7, -0.4, 0.5, 0.9]);
        ddq[..CHAINS].copy_from_slice(&[-3.0, 2.0, 4.0, 1.0]);
        mechanism.follow(&q, [&mut dq, &mut ddq]);
        let mut open = vec![0.0; 10];
        dynamics.torque(tree, &parameters, [&q, &dq, &ddq], &mut open);
        let map = mechanism.velocity_map(&q);
        let of_motor = |k: usize| {
            let passive = mechanism.passive().iter().enumerate();
            open[k] + passive.map(|(p, &j)| map[(p, k)] * open[j]).sum::<f64>()
        };
        let power: f64 = (0..CHAINS).map(|k| of_motor(k) * dq[k]).sum();
        let [x, y, z, theta] = PLATFORM;
        // d/dt (m v²/2 + I θ̇²/2 + m g z)
        let energy = MASS * (dq[x] * ddq[x] + dq[y] * ddq[y] + dq[z] * (ddq[z] + 9.81))
            + INERTIA * dq[theta] * ddq[theta];
        assert!((power - energy).abs() < 1e-10 * (1.0 + energy.abs()));
    }
}

#[test]
fn positions_that_do_not_exist_or_that_motors_do_not_hold_are_errors() {
    let far = ROBOT.inverse(&Vector4::new(0.0, 0.0, -0.9, 0.0));
    assert!(matches!(
        far,
        Err(MechanismError::OutOfReach { chain: 1, .. })
    ));
    // Levers far apart: no platform joins the four rods.
    let apart = ROBOT.forward(&[-1.0, -1.0, 2.5, -1.0], &Vector4::from(HOME));
    assert!(
        matches!(apart, Err(MechanismError::OutsideWorkspace { .. })),
        "{apart:?}"
    );
    // Without bars nothing turns the platform.
    let stub = H4 {
        half_bar: 1e-9,
        ..ROBOT
    };
    let motors = stub.inverse(&Vector4::from(HOME)).unwrap();
    let loose = stub.forward(&motors, &Vector4::from(HOME));
    assert!(
        matches!(loose, Err(MechanismError::Singular { .. })),
        "{loose:?}"
    );
    let wrong = H4 { rod: -0.5, ..ROBOT };
    assert!(matches!(
        wrong.mechanism().err(),
        Some(MechanismError::NotALength { name: "rod", .. })
    ));
}

fn hinge(name: &str, parent: Option<usize>, at: Vector3<f64>, body: &CentralInertia) -> Joint {
    Joint {
        name: name.to_string(),
        link: format!("{name}_link"),
        parent,
        kind: JointKind::Revolute,
        axis: Vector3::y(),
        rotation: Rotation3::identity(),
        translation: at,
        limits: Limits::default(),
        inertia: Inertia::from_central(body),
    }
}

/// Crank and rocker of 0.4 m, side by side 0.3 m apart, a coupler between their ends.
fn parallelogram() -> Mechanism {
    let body = |x: f64, z: f64| CentralInertia {
        mass: 2.0,
        centre: Vector3::new(x, 0.0, z),
        tensor: Matrix3::identity() * 0.02,
    };
    let joints = vec![
        hinge("crank", None, Vector3::zeros(), &body(0.02, 0.2)),
        hinge("coupler", Some(0), Vector3::z() * 0.4, &body(0.15, 0.01)),
        hinge("rocker", None, Vector3::x() * 0.3, &body(-0.01, 0.18)),
    ];
    let anchor = |link, point| Anchor {
        link: Some(link),
        point,
    };
    let closed = Condition::Hinge {
        ends: [anchor(1, Vector3::x() * 0.3), anchor(2, Vector3::z() * 0.4)],
        axes: [Vector3::y(), Vector3::y()],
    };
    let tree = Tree::new("parallelogram", "base", joints);
    Mechanism::new(tree, &[1, 2], vec![closed], vec![0.3, -0.3, 0.3]).unwrap()
}

#[test]
fn invariant_a_parallelogram_keeps_its_coupler_level() {
    let mechanism = parallelogram();
    for crank in [-0.9, -0.2, 0.4, 1.1] {
        let mut q = vec![crank, 0.0, 0.0];
        mechanism.close(&mut q).unwrap();
        assert!((q[1] + crank).abs() < 1e-12 && (q[2] - crank).abs() < 1e-12);
        let map = mechanism.velocity_map(&q);
        assert!((map[(0, 0)] + 1.0).abs() < 1e-12 && (map[(1, 0)] - 1.0).abs() < 1e-12);
        let (mut dq, mut ddq) = (vec![1.5, 0.0, 0.0], vec![-4.0, 0.0, 0.0]);
        mechanism.follow(&q, [&mut dq, &mut ddq]);
        assert!((ddq[1] - 4.0).abs() < 1e-10 && (ddq[2] + 4.0).abs() < 1e-10);
    }
    // Flat, crank and coupler in one line, the rocker may turn either way.
    let mut flat = vec![std::f64::consts::FRAC_PI_2, -1.570, 1.570];
    let error = mechanism.close(&mut flat).unwrap_err();
    assert!(matches!(error, MechanismError::Singular { .. }), "{error}");
}

#[test]
fn too_few_conditions_are_an_error() {
    let mechanism = parallelogram();
    let tie = Condition::Equal { joints: [0, 2] };
    let loose = Mechanism::new(mechanism.tree().clone(), &[1, 2], vec![tie], Vec::new());
    assert!(matches!(loose, Err(MechanismError::Loose { .. })));
}
