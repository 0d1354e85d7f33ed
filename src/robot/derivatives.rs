//! Derivatives of the joint torque with respect to position, velocity and acceleration, and with them
//! the mass matrix.
//!
//! Spatial vectors (angular, linear) about the base origin in base coordinates; for single-axis joints
//! the closed forms of Singh, Russell and Wensing (2022, "Efficient analytical derivatives of rigid-body
//! dynamics using spatial vector algebra", eqs 24 to 27) read, with j an ancestor of i or i itself,
//!
//! ```text
//! ∂τ_i/∂q_j = S_iᵀ (2 B_i Ψ̇_j + I_i Ψ̈_j)      ∂τ_j/∂q_i = S_jᵀ (2 B_i Ψ̇_i + I_i Ψ̈_i + S_i ×* f_i)
//! ∂τ_i/∂q̇_j = S_iᵀ (2 B_i S_j + 2 I_i Ψ̇_j)     ∂τ_j/∂q̇_i = S_jᵀ (2 B_i S_i + 2 I_i Ψ̇_i)
//! ∂τ_i/∂q̈_j = M_ij = S_iᵀ I_i S_j
//! ```
//!
//! with I_i, B_i and f_i summed over the links that joint i moves, `Ψ̇ = v_p × S`,
//! `Ψ̈ = a_p × S + v_p × Ψ̇` and `B(I, v) = ½ ((v×*) I − I (v×) + (I v) ×̄*)`.

use crate::robot::inertia::Inertia;
use crate::robot::motion::{JointState, placement};
use crate::robot::tree::Tree;
use nalgebra::{DMatrix, Matrix3, Matrix6, Vector3, Vector6};

/// Spatial quantities of one joint and its link.
#[derive(Clone, Debug)]
struct Spatial {
    /// From link to base coordinates.
    turn: Matrix3<f64>,
    origin: Vector3<f64>,
    axis: Vector6<f64>,
    axis_rate: Vector6<f64>,
    axis_second_rate: Vector6<f64>,
    velocity: Vector6<f64>,
    acceleration: Vector6<f64>,
    inertia: Matrix6<f64>,
    bias: Matrix6<f64>,
    force: Vector6<f64>,
}

/// Torque, its derivatives and the mass matrix at one state; memory reused from call to call.
#[derive(Clone, Debug)]
pub struct Derivatives {
    links: Vec<Spatial>,
    /// τ, N·m or N.
    pub torque: Vec<f64>,
    /// ∂τ/∂q, n x n.
    pub position: DMatrix<f64>,
    /// ∂τ/∂q̇, n x n.
    pub velocity: DMatrix<f64>,
    /// ∂τ/∂q̈, n x n: the mass matrix.
    pub mass: DMatrix<f64>,
    /// Derivatives of the base reaction (force, then moment), 6 x n, with respect to q, q̇ and q̈: the
    /// base stands before every joint, so they are the forms above before the product with S_j.
    pub base: [DMatrix<f64>; 3],
}

impl Derivatives {
    pub fn new(tree: &Tree) -> Self {
        let n = tree.len();
        let rest = Spatial {
            turn: Matrix3::identity(),
            origin: Vector3::zeros(),
            axis: Vector6::zeros(),
            axis_rate: Vector6::zeros(),
            axis_second_rate: Vector6::zeros(),
            velocity: Vector6::zeros(),
            acceleration: Vector6::zeros(),
            inertia: Matrix6::zeros(),
            bias: Matrix6::zeros(),
            force: Vector6::zeros(),
        };
        Self {
            links: vec![rest; n],
            torque: vec![0.0; n],
            position: DMatrix::zeros(n, n),
            velocity: DMatrix::zeros(n, n),
            mass: DMatrix::zeros(n, n),
            base: std::array::from_fn(|_| DMatrix::zeros(6, n)),
        }
    }

    /// Evaluates at q, q̇, q̈ (n values each) with the 10 n inertial parameters.
    pub fn evaluate(&mut self, tree: &Tree, parameters: &[f64], state: [&[f64]; 3]) {
        self.outward(tree, parameters, state);
        self.inward(tree);
        self.project(tree);
    }

    fn outward(&mut self, tree: &Tree, parameters: &[f64], [q, dq, ddq]: [&[f64]; 3]) {
        for (j, link) in tree.links().iter().enumerate() {
            let (parent_turn, parent_origin, v, a) = match link.parent {
                Some(p) => {
                    let parent = &self.links[p];
                    (
                        parent.turn,
                        parent.origin,
                        parent.velocity,
                        parent.acceleration,
                    )
                }
                None => {
                    let mut a = Vector6::zeros();
                    a.fixed_rows_mut::<3>(3).copy_from(&-tree.gravity());
                    (Matrix3::identity(), Vector3::zeros(), Vector6::zeros(), a)
                }
            };
            let (turn, offset) = placement(link, &JointState::of(link, q[j], dq[j], ddq[j]));
            let down = Matrix3::from_fn(|r, c| turn.0[r][c]);
            let here = &mut self.links[j];
            here.turn = parent_turn * down.transpose();
            here.origin = parent_origin + parent_turn * Vector3::from(offset.0);
            let z = here.turn * Vector3::from(link.axis);
            here.axis = if link.revolute {
                stack(z, here.origin.cross(&z))
            } else {
                stack(Vector3::zeros(), z)
            };
            here.axis_rate = cross_motion(&v, &here.axis);
            here.axis_second_rate =
                cross_motion(&a, &here.axis) + cross_motion(&v, &here.axis_rate);
            here.velocity = v + here.axis * dq[j];
            here.acceleration = a + here.axis * ddq[j] + here.axis_rate * dq[j];
            let body = Inertia(std::array::from_fn(|k| parameters[10 * j + k]));
            here.inertia = spatial_inertia(&body, &here.turn, &here.origin);
            let momentum = here.inertia * here.velocity;
            here.bias = coriolis(&here.inertia, &here.velocity, &momentum);
            here.force = here.inertia * here.acceleration + cross_force(&here.velocity, &momentum);
        }
    }

    fn inward(&mut self, tree: &Tree) {
        for j in (0..tree.len()).rev() {
            if let Some(p) = tree.links()[j].parent {
                let (before, from) = self.links.split_at_mut(j);
                before[p].inertia += from[0].inertia;
                before[p].bias += from[0].bias;
                before[p].force += from[0].force;
            }
        }
    }

    fn project(&mut self, tree: &Tree) {
        self.position.as_mut_slice().fill(0.0);
        self.velocity.as_mut_slice().fill(0.0);
        self.mass.as_mut_slice().fill(0.0);
        for (i, link) in tree.links().iter().enumerate() {
            let at = &self.links[i];
            self.torque[i] = at.axis.dot(&at.force);
            let inertia_axis = at.inertia * at.axis;
            let doubled_bias = at.bias * 2.0;
            let of_position = doubled_bias * at.axis_rate
                + at.inertia * at.axis_second_rate
                + cross_force(&at.axis, &at.force);
            let of_velocity = doubled_bias * at.axis + at.inertia * at.axis_rate * 2.0;
            for (matrix, column) in
                self.base
                    .iter_mut()
                    .zip([&of_position, &of_velocity, &inertia_axis])
            {
                for k in 0..3 {
                    matrix[(k, i)] = column[k + 3];
                    matrix[(k + 3, i)] = column[k];
                }
            }
            let bias_row = doubled_bias.transpose() * at.axis;
            for &j in &link.ancestors {
                let ancestor = &self.links[j];
                self.position[(i, j)] = bias_row.dot(&ancestor.axis_rate)
                    + inertia_axis.dot(&ancestor.axis_second_rate);
                self.velocity[(i, j)] =
                    bias_row.dot(&ancestor.axis) + 2.0 * inertia_axis.dot(&ancestor.axis_rate);
                self.position[(j, i)] = ancestor.axis.dot(&of_position);
                self.velocity[(j, i)] = ancestor.axis.dot(&of_velocity);
                let mass = inertia_axis.dot(&ancestor.axis);
                self.mass[(i, j)] = mass;
                self.mass[(j, i)] = mass;
            }
        }
    }
}

fn stack(angular: Vector3<f64>, linear: Vector3<f64>) -> Vector6<f64> {
    Vector6::new(
        angular.x, angular.y, angular.z, linear.x, linear.y, linear.z,
    )
}

fn parts(v: &Vector6<f64>) -> (Vector3<f64>, Vector3<f64>) {
    (
        Vector3::new(v[0], v[1], v[2]),
        Vector3::new(v[3], v[4], v[5]),
    )
}

/// `v × m` for motions.
fn cross_motion(v: &Vector6<f64>, m: &Vector6<f64>) -> Vector6<f64> {
    let ((w, u), (a, b)) = (parts(v), parts(m));
    stack(w.cross(&a), w.cross(&b) + u.cross(&a))
}

/// `v ×* f` for a motion and a force.
fn cross_force(v: &Vector6<f64>, f: &Vector6<f64>) -> Vector6<f64> {
    let ((w, u), (n, l)) = (parts(v), parts(f));
    stack(w.cross(&n) + u.cross(&l), w.cross(&l))
}

fn motion_matrix(v: &Vector6<f64>) -> Matrix6<f64> {
    let (w, u) = parts(v);
    blocks(
        [&w.cross_matrix(), &Matrix3::zeros()],
        [&u.cross_matrix(), &w.cross_matrix()],
    )
}

fn blocks(top: [&Matrix3<f64>; 2], bottom: [&Matrix3<f64>; 2]) -> Matrix6<f64> {
    let mut m = Matrix6::zeros();
    m.fixed_view_mut::<3, 3>(0, 0).copy_from(top[0]);
    m.fixed_view_mut::<3, 3>(0, 3).copy_from(top[1]);
    m.fixed_view_mut::<3, 3>(3, 0).copy_from(bottom[0]);
    m.fixed_view_mut::<3, 3>(3, 3).copy_from(bottom[1]);
    m
}

/// Inertia of a body about the base origin in base coordinates.
fn spatial_inertia(body: &Inertia, turn: &Matrix3<f64>, origin: &Vector3<f64>) -> Matrix6<f64> {
    let rotation = nalgebra::Rotation3::from_matrix_unchecked(*turn);
    let moved = body.seen_from(&rotation, origin);
    let h = moved.first_moment().cross_matrix();
    blocks(
        [&moved.tensor(), &h],
        [&-h, &(Matrix3::identity() * moved.mass())],
    )
}

/// `B(I, v)` with the momentum I v at hand.
fn coriolis(inertia: &Matrix6<f64>, v: &Vector6<f64>, momentum: &Vector6<f64>) -> Matrix6<f64> {
    let cross = motion_matrix(v);
    let (n, l) = parts(momentum);
    // (p ×̄*) m = m ×* p as a matrix acting on m.
    let swapped = blocks(
        [&-n.cross_matrix(), &-l.cross_matrix()],
        [&-l.cross_matrix(), &Matrix3::zeros()],
    );
    (-cross.transpose() * inertia - inertia * cross + swapped) * 0.5
}
