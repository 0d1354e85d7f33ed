//! The recursions against each other, against differences and against momentum, on random trees.

mod broken;

use crate::linalg::lanes::instructions::InstructionSet;
use crate::robot::batch::{InverseDynamics, RegressorBatch, Trajectory, Wanted, torques};
use crate::robot::derivative_batch::DerivativeBatch;
use crate::robot::derivatives::Derivatives;
use crate::robot::forward_dynamics::ForwardDynamics;
use crate::robot::inertia::Inertia;
use crate::robot::newton_euler::NewtonEuler;
use crate::robot::random::{generator, symmetric, tree};
use crate::robot::regressor::Rows;
use crate::robot::regressor_gradient::RegressorGradient;
use crate::robot::sample_regressor::SampleRegressor;
use crate::robot::tree::Tree;
use nalgebra::{DMatrix, DVector, Vector3};
use rand_chacha::ChaCha8Rng;

const TREES: u64 = 20;
const STATES: usize = 50;

struct State {
    q: Vec<f64>,
    dq: Vec<f64>,
    ddq: Vec<f64>,
}

impl State {
    fn random(rng: &mut ChaCha8Rng, n: usize) -> Self {
        let mut draw = |range: f64| (0..n).map(|_| symmetric(rng, range)).collect::<Vec<f64>>();
        Self {
            q: draw(3.0),
            dq: draw(2.0),
            ddq: draw(8.0),
        }
    }

    fn slices(&self) -> [&[f64]; 3] {
        [&self.q, &self.dq, &self.ddq]
    }

    /// The state after the time h along `q(t) = q + q̇ t + q̈ t²/2`.
    fn after(&self, h: f64) -> Self {
        let n = self.q.len();
        let q = (0..n).map(|k| self.q[k] + h * (self.dq[k] + 0.5 * h * self.ddq[k]));
        let dq = (0..n).map(|k| self.dq[k] + h * self.ddq[k]);
        Self {
            q: q.collect(),
            dq: dq.collect(),
            ddq: self.ddq.clone(),
        }
    }
}

fn robots() -> impl Iterator<Item = (Tree, ChaCha8Rng)> {
    (0..TREES).map(|seed| {
        let mut rng = generator(seed);
        let n = 1 + (seed as usize) % 9;
        (tree(&mut rng, n), rng)
    })
}

fn torque(tree: &Tree, parameters: &[f64], state: &State) -> DVector<f64> {
    let mut out = vec![0.0; tree.len()];
    NewtonEuler::new(tree).torque(tree, parameters, state.slices(), &mut out);
    DVector::from_vec(out)
}

fn regressor(tree: &Tree, rows: Rows, state: &State) -> DMatrix<f64> {
    let mut y = DMatrix::zeros(rows.count(tree.len()), 10 * tree.len());
    SampleRegressor::new(tree, rows).fill(tree, state.slices(), &mut y);
    y
}

#[test]
fn invariant_regressor_times_parameters_is_newton_euler() {
    for (tree, mut rng) in robots() {
        let pi = tree.parameters();
        for _ in 0..STATES {
            let state = State::random(&mut rng, tree.len());
            let expected = torque(&tree, &pi, &state);
            let got = regressor(&tree, Rows::Torque, &state) * DVector::from_column_slice(&pi);
            assert!((&got - &expected).amax() <= 1e-12 * expected.amax().max(1.0));
        }
    }
}

/// Momentum of all links and their moment of momentum about the base origin, and the mass and first
/// moment that gravity acts on, from forward kinematics and differences of poses alone.
fn momentum(tree: &Tree, state: &State) -> (Vector3<f64>, Vector3<f64>) {
    const H: f64 = 1e-6;
    let (before, after) = (state.after(-H), state.after(H));
    let (low, high) = (
        tree.forward_kinematics(&before.q),
        tree.forward_kinematics(&after.q),
    );
    let now = tree.forward_kinematics(&state.q);
    let (mut linear, mut angular) = (Vector3::zeros(), Vector3::zeros());
    for (k, joint) in tree.joints().iter().enumerate() {
        let body = joint.inertia.central().unwrap();
        let turn = now[k].rotation.to_rotation_matrix();
        let centre = now[k] * nalgebra::Point3::from(body.centre);
        let speed = (high[k] * nalgebra::Point3::from(body.centre)
            - low[k] * nalgebra::Point3::from(body.centre))
            / (2.0 * H);
        let spin = (high[k].rotation * low[k].rotation.inverse()).scaled_axis() / (2.0 * H);
        let p = speed * body.mass;
        linear += p;
        angular += centre.coords.cross(&p)
            + turn.matrix() * body.tensor * turn.matrix().transpose() * spin;
    }
    (linear, angular)
}

#[test]
fn matches_derivative_of_momentum_minus_gravity() {
    const H: f64 = 1e-4;
    for (tree, mut rng) in robots() {
        let pi = DVector::from_vec(tree.parameters());
        for _ in 0..5 {
            let state = State::random(&mut rng, tree.len());
            let (p0, l0) = momentum(&tree, &state.after(-H));
            let (p1, l1) = momentum(&tree, &state.after(H));
            let mut force = (p1 - p0) / (2.0 * H);
            let mut moment = (l1 - l0) / (2.0 * H);
            let poses = tree.forward_kinematics(&state.q);
            for (joint, pose) in tree.joints().iter().zip(poses) {
                let weight = tree.gravity() * joint.inertia.mass();
                let h = pose.rotation * joint.inertia.first_moment()
                    + pose.translation.vector * joint.inertia.mass();
                force -= weight;
                moment -= h.cross(&tree.gravity());
            }
            let got = regressor(&tree, Rows::Base, &state) * &pi;
            let scale = got.amax().max(1.0);
            // Two nested differences leave H² of the motion and 1e-16/(1e-6·1e-4) of rounding.
            for k in 0..3 {
                assert!((got[k] - force[k]).abs() <= 2e-5 * scale, "{got} {force}");
                assert!(
                    (got[k + 3] - moment[k]).abs() <= 2e-5 * scale,
                    "{got} {moment}"
                );
            }
        }
    }
}

#[test]
fn matches_base_reaction_of_a_robot_that_is_carried_on() {
    // A further body between base and robot that does not move carries the same reaction: its joint's
    // three sliding and three turning axes measure force and moment exactly.
    for (tree, mut rng) in robots() {
        let state = State::random(&mut rng, tree.len());
        let both = regressor(&tree, Rows::Both, &state);
        let n = tree.len();
        assert_eq!(both.rows(0, n), regressor(&tree, Rows::Torque, &state));
        assert_eq!(both.rows(n, 6), regressor(&tree, Rows::Base, &state));
        for k in 0..6 {
            let carried = carried_on(&tree, k);
            let mut longer = State {
                q: vec![0.0],
                dq: vec![0.0],
                ddq: vec![0.0],
            };
            longer.q.extend(&state.q);
            longer.dq.extend(&state.dq);
            longer.ddq.extend(&state.ddq);
            let row = regressor(&carried, Rows::Torque, &longer);
            let expected = row.view((0, 10), (1, 10 * n));
            assert!((both.view((n + k, 0), (1, 10 * n)) - expected).amax() < 1e-11);
        }
    }
}

/// The robot on a massless carriage that slides (k < 3) or turns (k >= 3) along base axis k.
fn carried_on(tree: &Tree, k: usize) -> Tree {
    use crate::robot::tree::{Joint, JointKind, Limits};
    let mut axis = Vector3::zeros();
    axis[k % 3] = 1.0;
    let mut joints = vec![Joint {
        name: "carriage".into(),
        link: "carriage".into(),
        parent: None,
        kind: if k < 3 {
            JointKind::Prismatic
        } else {
            JointKind::Revolute
        },
        axis,
        rotation: nalgebra::Rotation3::identity(),
        translation: Vector3::zeros(),
        limits: Limits::default(),
        inertia: Inertia::default(),
    }];
    for joint in tree.joints() {
        let mut joint = joint.clone();
        joint.parent = Some(joint.parent.map_or(0, |p| p + 1));
        joints.push(joint);
    }
    Tree::new("carried", "base", joints).with_gravity(tree.gravity().into())
}

/// Central differences with a step at which rounding (1e-16/h) and curvature (h²) balance.
fn differences(f: impl Fn(f64) -> DVector<f64>) -> DVector<f64> {
    const H: f64 = 1e-5;
    let at = |h: f64| (f(h) - f(-h)) / (2.0 * h);
    // Richardson: the h² term cancels.
    (at(H) * 4.0 - at(2.0 * H)) / 3.0
}

fn shifted(state: &State, which: usize, j: usize, by: f64) -> State {
    let mut moved = State {
        q: state.q.clone(),
        dq: state.dq.clone(),
        ddq: state.ddq.clone(),
    };
    [&mut moved.q, &mut moved.dq, &mut moved.ddq][which][j] += by;
    moved
}

#[test]
fn matches_differences_of_torque_in_position_velocity_acceleration() {
    for (tree, mut rng) in robots() {
        let pi = tree.parameters();
        let mut derivatives = Derivatives::new(&tree);
        for _ in 0..5 {
            let state = State::random(&mut rng, tree.len());
            derivatives.evaluate(&tree, &pi, state.slices());
            let expected = torque(&tree, &pi, &state);
            let n = tree.len();
            let got = DVector::from_fn(n, |j, _| derivatives.torque(j));
            assert!((got - &expected).amax() <= 1e-11 * expected.amax().max(1.0));
            for which in 0..3 {
                for j in 0..n {
                    let column = differences(|h| torque(&tree, &pi, &shifted(&state, which, j, h)));
                    let got = DVector::from_fn(n, |row, _| derivatives.slope(which, row, j));
                    let error = (got - &column).amax();
                    assert!(
                        error <= 1e-7 * column.amax().max(1.0),
                        "{which} {j}: {error:e}"
                    );
                }
            }
        }
    }
}

#[test]
fn matches_differences_of_base_reaction() {
    for (tree, mut rng) in robots() {
        let pi = DVector::from_vec(tree.parameters());
        let mut derivatives = Derivatives::new(&tree);
        let state = State::random(&mut rng, tree.len());
        derivatives.evaluate(&tree, pi.as_slice(), state.slices());
        let reaction = |s: &State| regressor(&tree, Rows::Base, s) * &pi;
        for which in 0..3 {
            for j in 0..tree.len() {
                let column = differences(|h| reaction(&shifted(&state, which, j, h)));
                let first = tree.len();
                let got = DVector::from_fn(6, |k, _| derivatives.slope(which, first + k, j));
                let error = (got - &column).amax();
                assert!(
                    error <= 1e-7 * column.amax().max(1.0),
                    "{which} {j}: {error:e}"
                );
            }
        }
    }
}

#[test]
fn matches_differences_of_weighted_regressor() {
    for (tree, mut rng) in robots() {
        let n = tree.len();
        let mut gradient = RegressorGradient::<f64>::new(&tree);
        for _ in 0..5 {
            let state = State::random(&mut rng, n);
            let g = DMatrix::from_fn(n, 10 * n, |_, _| symmetric(&mut rng, 1.0));
            let value =
                |s: &State| DVector::from_element(1, regressor(&tree, Rows::Torque, s).dot(&g));
            let got = gradient
                .evaluate(&tree, state.slices(), |row, link| {
                    std::array::from_fn(|k| g[(row, 10 * link + k)])
                })
                .clone();
            for (which, part) in [&got.q, &got.dq, &got.ddq].into_iter().enumerate() {
                for (j, got) in part.iter().enumerate() {
                    let expected = differences(|h| value(&shifted(&state, which, j, h)))[0];
                    let bound = 1e-7 * value(&state)[0].abs().max(expected.abs()).max(10.0);
                    assert!((got - expected).abs() <= bound, "{which} {j}");
                }
            }
        }
    }
}

/// Positions, velocities and accelerations of some states, one after the other: `[joint][sample]` each.
fn in_turn(states: &[State]) -> [Vec<Vec<f64>>; 3] {
    let picks: [fn(&State) -> &Vec<f64>; 3] = [|s| &s.q, |s| &s.dq, |s| &s.ddq];
    let joints = 0..states[0].q.len();
    picks.map(|pick| {
        let of = |j: usize| states.iter().map(|s| pick(s)[j]).collect();
        joints.clone().map(of).collect()
    })
}

#[test]
fn invariant_lanes_match_single_samples_in_every_instruction_set() {
    for (tree, mut rng) in robots() {
        let n = tree.len();
        let samples = 21;
        let states: Vec<State> = (0..samples).map(|_| State::random(&mut rng, n)).collect();
        let [q, dq, ddq] = in_turn(&states);
        let trajectory = Trajectory {
            q: &q,
            dq: &dq,
            ddq: &ddq,
        };
        let batch_torque = torques(&tree, &tree.parameters(), trajectory);
        for (k, state) in states.iter().enumerate() {
            let expected = torque(&tree, &tree.parameters(), state);
            for j in 0..n {
                let error = (batch_torque[j][k] - expected[j]).abs();
                assert!(error <= 1e-12 * expected.amax().max(1.0));
            }
        }
        for set in [
            InstructionSet::Baseline,
            InstructionSet::Avx2,
            InstructionSet::Avx512,
        ] {
            let mut batch = RegressorBatch::with_instructions(&tree, Rows::Both, samples, set);
            batch.evaluate(&tree, trajectory, 0..samples);
            let mut slopes = DerivativeBatch::with_instructions(&tree, samples, set);
            slopes.evaluate(&tree, &tree.parameters(), trajectory, 0..samples);
            let mut single = Derivatives::new(&tree);
            for (k, state) in states.iter().enumerate() {
                single.evaluate(&tree, &tree.parameters(), state.slices());
                for (row, j) in (0..n + 6).flat_map(|row| (0..n).map(move |j| (row, j))) {
                    for order in 0..3 {
                        let got = slopes.slope(order, row, j)[k];
                        let expected = single.slope(order, row, j);
                        let bound = 1e-11 * expected.abs().max(100.0);
                        assert!((got - expected).abs() <= bound, "{set:?} {order} {row} {j}");
                    }
                }
                let y = regressor(&tree, Rows::Both, state);
                let scale = y.amax();
                for row in 0..n + 6 {
                    for column in 0..10 * n {
                        let error = (batch.column(row, column)[k] - y[(row, column)]).abs();
                        assert!(error <= 1e-13 * scale, "{set:?} {row} {column}");
                    }
                }
            }
        }
    }
}

/// What is asked for is what it is beside everything else, and the rest stays what it was.
#[test]
fn invariant_joints_that_are_asked_for_alone_have_the_torques_and_rows_that_they_have_among_all() {
    const UNTOUCHED: f64 = 7.25;
    for (tree, mut rng) in robots() {
        let (n, samples) = (tree.len(), 11);
        let states: Vec<State> = (0..samples).map(|_| State::random(&mut rng, n)).collect();
        let [q, dq, ddq] = in_turn(&states);
        let trajectory = Trajectory {
            q: &q,
            dq: &dq,
            ddq: &ddq,
        };
        let parameters = tree.parameters();
        let of_all = torques(&tree, &parameters, trajectory);
        let mut every = RegressorBatch::new(&tree, Rows::Torque, samples);
        every.evaluate(&tree, trajectory, 0..samples);
        for joint in 0..n {
            let mut joints = vec![false; n];
            joints[joint] = true;
            let mut own = vec![vec![UNTOUCHED; samples]; n];
            let dynamics = InverseDynamics {
                tree: &tree,
                parameters: &parameters,
                trajectory,
                samples,
                wanted: &joints,
            };
            dynamics.put_into(&mut own);
            let mut some = RegressorBatch::new(&tree, Rows::Torque, samples);
            let wanted = Wanted {
                links: &vec![true; n],
                joints: &joints,
            };
            some.evaluate_wanted(&tree, trajectory, 0..samples, wanted);
            for row in 0..n {
                match row == joint {
                    true => assert_eq!(own[row], of_all[row]),
                    false => assert_eq!(own[row], vec![UNTOUCHED; samples]),
                }
                for column in 0..10 * n {
                    match row == joint {
                        true => assert_eq!(some.column(row, column), every.column(row, column)),
                        false => assert!(some.column(row, column).iter().all(|x| *x == 0.0)),
                    }
                }
            }
        }
    }
}

#[test]
fn invariant_forward_dynamics_inverts_inverse_dynamics() {
    for (tree, mut rng) in robots() {
        let (n, pi) = (tree.len(), tree.parameters());
        let rotor: Vec<f64> = (0..n).map(|k| 0.1 * k as f64).collect();
        for _ in 0..5 {
            let state = State::random(&mut rng, n);
            let mut tau = torque(&tree, &pi, &state);
            for j in 0..n {
                tau[j] += rotor[j] * state.ddq[j];
            }
            let mut ddq = vec![0.0; n];
            let input = [&state.q[..], &state.dq, tau.as_slice(), &rotor];
            ForwardDynamics::new(&tree)
                .acceleration(&tree, &pi, input, &mut ddq)
                .unwrap();
            for (got, expected) in ddq.iter().zip(&state.ddq) {
                assert!((got - expected).abs() < 1e-8, "{got} {expected}");
            }
        }
    }
}

#[test]
fn a_massless_last_link_is_a_singular_mass_matrix() {
    let mut rng = generator(3);
    let robot = tree(&mut rng, 4);
    let massless = vec![0.0; 40];
    let zero = vec![0.0; 4];
    let input = [&zero[..], &zero, &zero, &zero];
    let fault = ForwardDynamics::new(&robot)
        .acceleration(&robot, &massless, input, &mut [0.0; 4])
        .unwrap_err();
    assert_eq!(fault.joint, 0);
}
