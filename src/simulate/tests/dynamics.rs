//! Dynamics: agreement of the two modes, of motion and torque, of power and losses; the integrator.

use crate::simulate::plant::{Plant, State};
use crate::simulate::random_path::{RecordingConditions, torques};
use crate::simulate::tests::{
    ALL_MOTION, FRICTION, arm, columns, motion_of, panda, parse, simulated, truth_of,
};
use crate::simulate::truth::DEFAULT_WIDTH;
use std::path::Path;

/// Samples of a motion without a load; the rate does not matter to laws without memory.
const ALONE: RecordingConditions = RecordingConditions {
    rate: 200.0,
    cyclic: false,
    loaded: false,
};

#[test]
fn invariant_the_commanded_torque_of_a_closed_loop_is_that_of_the_chain_at_the_true_motion() {
    let rest = format!(
        "{ALL_MOTION}[simulate]\nmode = \"closed_loop\"\nperiods = 1\nwarmup_periods = 0\n\
         [simulate.values]\n\"joint4.torque_offset.offset\" = 2.0\n\"joint2.rotor_inertia.Jm\" = 0.3"
    );
    let problem = panda(FRICTION, &rest);
    let result = simulated(&problem, 3);
    let (_, truth) = truth_of(&problem);
    let motion = motion_of(&result, 0);
    let all: Vec<usize> = (0..7).collect();
    let chain = torques(&truth.plant, &motion, ALONE, &all);
    let nominal = torques(&truth.nominal, &motion, ALONE, &all);
    let tau = columns(&result, 0, "tau");
    for j in 0..7 {
        for k in 0..tau[j].len() {
            assert!((chain[j][k] - tau[j][k]).abs() <= 1e-9);
            // What is concealed is all that the declared model lacks.
            let concealed = match j {
                1 => 0.3 * motion[2][1][k],
                3 => 2.0,
                _ => 0.0,
            };
            assert!((tau[j][k] - nominal[j][k] - concealed).abs() <= 1e-9);
        }
    }
}

#[test]
fn invariant_recorded_accelerations_of_a_closed_loop_are_the_derivatives_of_its_motion() {
    let rest =
        format!("{ALL_MOTION}[simulate]\nmode = \"closed_loop\"\nperiods = 1\nwarmup_periods = 0")
            .replace("period = 5.0", "period = 5.0\nrate = 1000.0");
    // Rotors that leave reversals a few milliseconds, so that differences over two of them see them.
    let drive = FRICTION.replace("[drive]", "[drive]\nrotor_inertia = 1.0");
    let problem = panda(&drive, &rest);
    let [q, dq, ddq] = motion_of(&simulated(&problem, 5), 0);
    let dt = 1e-3;
    for j in 0..7 {
        for (x, derivative) in [(&q[j], &dq[j]), (&dq[j], &ddq[j])] {
            let (mut error, mut size) = (0.0_f64, 0.0_f64);
            for k in 1..x.len() - 1 {
                let slope = (x[k + 1] - x[k - 1]) / (2.0 * dt);
                error += (slope - derivative[k]).powi(2);
                size += derivative[k].powi(2);
            }
            // Root mean square: the difference itself is blind to the milliseconds of a reversal.
            assert!(
                (error / size).sqrt() <= 0.01,
                "{j} {}",
                (error / size).sqrt()
            );
        }
    }
}

#[test]
fn a_closed_loop_with_all_effects_declared_follows_the_trajectory_and_the_inverse_mode() {
    let text = |mode: &str| {
        let rest = format!("{ALL_MOTION}[simulate]\nmode = \"{mode}\"\nperiods = 1");
        panda(FRICTION, &rest)
    };
    let (inverse, closed) = (
        simulated(&text("inverse"), 11),
        simulated(&text("closed_loop"), 11),
    );
    let (a, b) = (motion_of(&inverse, 0), motion_of(&closed, 0));
    let (tau_a, tau_b) = (columns(&inverse, 0, "tau"), columns(&closed, 0, "tau"));
    for j in 0..7 {
        let rms = |x: &[f64], y: &[f64]| {
            let sum: f64 = x.iter().zip(y).map(|(x, y)| (x - y).powi(2)).sum();
            (sum / x.len() as f64).sqrt()
        };
        // A torque held for a millisecond is half a millisecond late: 0.5 ms times the speed bounds the lag.
        assert!(rms(&a[0][j], &b[0][j]) <= 0.5e-3 * 2.6, "{j}");
        let size = rms(tau_a[j], &vec![0.0; tau_a[j].len()]);
        assert!(rms(tau_a[j], tau_b[j]) <= 0.02 * size, "{j}");
    }
}

#[test]
fn invariant_power_of_the_motors_over_whole_periods_is_what_friction_takes() {
    let rest = format!("{ALL_MOTION}[simulate]\nperiods = 1");
    let problem = panda(FRICTION, &rest);
    let result = simulated(&problem, 2);
    let [_, dq, _] = motion_of(&result, 0);
    let (_, truth) = truth_of(&problem);
    let tau = columns(&result, 0, "tau");
    let value = |name: &str| {
        let p = truth.plant.find(name).unwrap();
        truth.plant.parameters()[p].value
    };
    let (mut work, mut lost) = (0.0, 0.0);
    for j in 0..7 {
        let fc = value(&format!("joint{}.coulomb_friction.Fc", j + 1));
        let fv = value(&format!("joint{}.viscous_friction.Fv", j + 1));
        for (v, t) in dq[j].iter().zip(tau[j]) {
            work += v * t;
            lost += fc * v * v / (v.abs() + DEFAULT_WIDTH) + fv * v * v;
        }
    }
    // Energy comes back to its start; sums of a band-limited periodic motion are exact, but for the
    // narrow band of friction, which is on both sides.
    assert!(lost > 0.0);
    assert!((work / lost - 1.0).abs() <= 1e-10, "{}", work / lost - 1.0);
}

#[test]
fn a_coupled_motor_moves_both_joints_and_positions_of_joints_show_it() {
    let drive = FRICTION.replace(
        "[drive]",
        "[drive]\ncoupling = [[1.0,0.0,0.0,0.0,0.0,0.0,0.0],[0.0,1.0,0.0,0.0,0.0,0.0,0.0],\
         [0.0,0.0,1.0,0.0,0.0,0.0,0.0],[0.0,0.0,0.0,1.0,0.0,0.0,0.0],[0.0,0.0,0.0,0.0,1.0,0.0,0.0],\
         [0.0,0.0,0.0,0.0,0.3,1.0,0.0],[0.0,0.0,0.0,0.0,0.0,0.0,1.0]]",
    );
    let side = |side: &str, mode: &str| {
        let columns = ALL_MOTION.replace(
            "signal = \"torque\"",
            &format!("signal = \"torque\"\nposition_side = \"{side}\""),
        );
        let drive = drive.replace("[drive]", "[drive]\nratio = 1.0");
        let rest =
            format!("{columns}[simulate]\nperiods = 1\nwarmup_periods = 0\nmode = \"{mode}\"");
        panda(&drive, &rest)
    };
    for mode in ["inverse", "closed_loop"] {
        let motors = motion_of(&simulated(&side("motor", mode), 6), 0);
        let links = motion_of(&simulated(&side("joint", mode), 6), 0);
        for k in 0..links[0][5].len() {
            let expected = motors[0][5][k] + 0.3 * motors[0][4][k];
            assert!((links[0][5][k] - expected).abs() <= 1e-12);
        }
    }
    let problem = side("motor", "closed_loop");
    let (_, truth) = truth_of(&problem);
    let result = simulated(&problem, 6);
    let chain = torques(&truth.plant, &motion_of(&result, 0), ALONE, &[4, 5]);
    let tau = columns(&result, 0, "tau");
    for k in 0..tau[4].len() {
        assert!((chain[0][k] - tau[4][k]).abs() <= 1e-9);
    }
}

#[test]
fn matches_closed_form_of_a_rotor_in_stiff_viscous_friction() {
    // H v̇ = u − Fv v:  v = u/Fv (1 − exp(−Fv t/H)), stiff where Fv h/H is large.
    let locked = "locked = { joint2 = 0.3, joint3 = 0.0, joint4 = -1.0, joint5 = 0.0, joint6 = 1.0, joint7 = 0.0 }";
    let text = format!(
        "[robot]\nmdh = {:?}\n{locked}\n[drive]\neffects = [\"viscous_friction\"]\n\
         [drive.values]\n\"joint1.Fv\" = 500.0",
        arm()
    );
    let (_, truth) = truth_of(&parse(Path::new("p.toml"), &text));
    let mut plant = Plant::new(&truth.plant, false).unwrap();
    let rest = State {
        position: vec![0.0; 7],
        velocity: vec![0.0; 7],
    };
    let chain = plant.linearise(&rest).unwrap();
    // The axis is vertical: without speed the torque is that of the inertia alone.
    let inertia = 1.0 / plant.acceleration(&chain, &[1.0]).unwrap()[0];
    let mut errors = Vec::new();
    for steps in [8, 16, 32] {
        let h = 2.0 * inertia / 500.0 / f64::from(steps);
        let mut state = rest.clone();
        for _ in 0..steps {
            let chain = plant.linearise(&state).unwrap();
            state = plant.step(&state, &chain, &[10.0], h).unwrap().state;
        }
        errors.push((state.velocity[0] - 10.0 / 500.0 * (1.0 - (-2.0_f64).exp())).abs());
    }
    // Order two: a quarter of the error with half of the step, to the next order.
    for pair in errors.windows(2) {
        assert!((pair[1] / pair[0] - 0.25).abs() < 0.06, "{errors:?}");
    }
    // L-stable: one step over many time constants ends at the equilibrium.
    let chain = plant.linearise(&rest).unwrap();
    let after = plant
        .step(&rest, &chain, &[10.0], 1e4 * inertia / 500.0)
        .unwrap()
        .state;
    assert!((after.velocity[0] / 0.02 - 1.0).abs() < 1e-3);
}
