//! Derivatives of joint torque and base reaction with respect to position, velocity and acceleration, and
//! with them the mass matrix.
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
//! `Ψ̈ = a_p × S + v_p × Ψ̇` and `B(I, v) = ½ ((v×*) I − I (v×) + (I v) ×̄*)`. Of a rigid body with mass m, first
//! moment h and second moment Σ = ∫ r rᵀ dm (inertia tr(Σ) 1 − Σ) that moves with v = (ω, u), most of B cancels:
//!
//! ```text
//! I (α, a) = (tr(Σ) α − Σ α + h × a, m a − h × α)        l = m u − h × ω
//! B (α, a) = (−ω × Σ α − u (h·α) + (h·u) α, α × l)
//! ```

use crate::linalg::lanes::scalar::Scalar;
use crate::robot::motion::{JointState, placement};
use crate::robot::newton_euler::Load;
use crate::robot::tree::{Link, Tree};
use crate::robot::vector::{Mat3, Vec3};

/// Torque and its derivatives at one state, or at eight in lanes; memory reused from call to call.
#[derive(Clone, Debug)]
pub struct Derivatives<T> {
    links: Vec<Spatial<T>>,
    /// τ, N·m or N.
    torque: Vec<T>,
    /// By q, q̇ and q̈: rows of the joints, then of the base reaction (force, moment); columns of the joints.
    slopes: [Vec<T>; 3],
}

impl<T: Scalar> Derivatives<T> {
    /// Memory for the recursion over a tree; computes nothing yet.
    pub fn new(tree: &Tree) -> Self {
        let n = tree.len();
        let zeros = || vec![T::constant(0.0); (n + 6) * n];
        Self {
            links: vec![Spatial::rest(); n],
            torque: vec![T::constant(0.0); n],
            slopes: [zeros(), zeros(), zeros()],
        }
    }

    /// Torque of a joint at the state that was evaluated last, N·m (N).
    pub fn torque(&self, joint: usize) -> T {
        self.torque[joint]
    }

    /// Derivative of a row with respect to a joint's position (order 0), velocity (1) or acceleration (2): rows 0 to
    /// n − 1 are torques of joints, n to n + 5 the force and the moment of the base.
    pub fn slope(&self, order: usize, row: usize, joint: usize) -> T {
        self.slopes[order][row * self.links.len() + joint]
    }

    /// Torques, then slopes order after order, row after row.
    pub(crate) fn all(&self) -> [&[T]; 4] {
        let [position, velocity, mass] = &self.slopes;
        [&self.torque, position, velocity, mass]
    }

    /// Evaluates at q, q̇, q̈ (n values each) with the 10 n inertial parameters.
    #[inline(always)]
    pub fn evaluate(&mut self, tree: &Tree, parameters: &[f64], state: [&[T]; 3]) {
        self.outward(tree, parameters, state);
        self.inward(tree);
        self.project(tree);
    }

    #[inline(always)]
    fn outward(&mut self, tree: &Tree, parameters: &[f64], [q, dq, ddq]: [&[T]; 3]) {
        let mut base = Spatial::rest();
        base.turn = Mat3::constant([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        base.acceleration.linear = Vec3::constant((-tree.gravity()).into());
        for (j, link) in tree.links().iter().enumerate() {
            let parent = match link.parent {
                Some(p) => self.links[p],
                None => base,
            };
            let state = JointState::of(link, q[j], dq[j], ddq[j]);
            let mut here = parent.moved(link, &state);
            here.load(&parameters[10 * j..10 * j + 10]);
            self.links[j] = here;
        }
    }

    #[inline(always)]
    fn inward(&mut self, tree: &Tree) {
        for j in (0..tree.len()).rev() {
            if let Some(p) = tree.links()[j].parent {
                let (before, from) = self.links.split_at_mut(j);
                before[p].body.add(&from[0].body);
                before[p].bias.add(&from[0].bias);
                before[p].force.force += from[0].force.force;
                before[p].force.moment += from[0].force.moment;
            }
        }
    }

    #[inline(always)]
    fn project(&mut self, tree: &Tree) {
        let n = tree.len();
        let [position, velocity, mass] = &mut self.slopes;
        for (i, link) in tree.links().iter().enumerate() {
            let at = &self.links[i];
            self.torque[i] = at.axis.on(at.force);
            let of_acceleration = at.body.times(at.axis);
            let of_velocity = twice(sum(at.bias.times(at.axis), at.body.times(at.axis_rate)));
            let of_position = sum(
                sum(
                    twice(at.bias.times(at.axis_rate)),
                    at.body.times(at.axis_second_rate),
                ),
                at.axis.cross_load(at.force),
            );
            let bias_row = at.bias.transpose_times(at.axis);
            for k in 0..3 {
                let (force, moment) = ((n + k) * n + i, (n + 3 + k) * n + i);
                position[force] = of_position.force.0[k];
                position[moment] = of_position.moment.0[k];
                velocity[force] = of_velocity.force.0[k];
                velocity[moment] = of_velocity.moment.0[k];
                mass[force] = of_acceleration.force.0[k];
                mass[moment] = of_acceleration.moment.0[k];
            }
            for &j in &link.ancestors {
                let ancestor = &self.links[j];
                let (own, other) = (i * n + j, j * n + i);
                let by_bias = bias_row.dot(ancestor.axis_rate.angular);
                position[own] = by_bias + by_bias + ancestor.axis_second_rate.on(of_acceleration);
                let half =
                    bias_row.dot(ancestor.axis.angular) + ancestor.axis_rate.on(of_acceleration);
                velocity[own] = half + half;
                position[other] = ancestor.axis.on(of_position);
                velocity[other] = ancestor.axis.on(of_velocity);
                let entry = ancestor.axis.on(of_acceleration);
                mass[own] = entry;
                mass[other] = entry;
            }
        }
    }
}

/// A velocity or an acceleration about the base origin.
#[derive(Clone, Copy, Debug)]
struct Twist<T> {
    angular: Vec3<T>,
    linear: Vec3<T>,
}

impl<T: Scalar> Twist<T> {
    #[inline(always)]
    fn zero() -> Self {
        Self {
            angular: Vec3::zero(),
            linear: Vec3::zero(),
        }
    }

    #[inline(always)]
    fn plus_scaled(self, s: T, other: Self) -> Self {
        Self {
            angular: self.angular.plus_scaled(s, other.angular),
            linear: self.linear.plus_scaled(s, other.linear),
        }
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        Self {
            angular: self.angular + other.angular,
            linear: self.linear + other.linear,
        }
    }

    /// `v × m` for motions.
    #[inline(always)]
    fn cross(self, m: Self) -> Self {
        Self {
            angular: self.angular.cross(m.angular),
            linear: self.angular.cross(m.linear) + self.linear.cross(m.angular),
        }
    }

    /// `v ×* f` for a motion and a force.
    #[inline(always)]
    fn cross_load(self, f: Load<T>) -> Load<T> {
        Load {
            force: self.angular.cross(f.force),
            moment: self.angular.cross(f.moment) + self.linear.cross(f.force),
        }
    }

    /// `Sᵀ f`.
    #[inline(always)]
    fn on(self, f: Load<T>) -> T {
        self.angular.dot(f.moment) + self.linear.dot(f.force)
    }
}

#[inline(always)]
fn sum<T: Scalar>(a: Load<T>, b: Load<T>) -> Load<T> {
    Load {
        force: a.force + b.force,
        moment: a.moment + b.moment,
    }
}

#[inline(always)]
fn twice<T: Scalar>(a: Load<T>) -> Load<T> {
    sum(a, a)
}

/// I: mass, first moment and second moment (xx, xy, yy, xz, yz, zz) about the base origin.
#[derive(Clone, Copy, Debug)]
struct Body<T> {
    mass: T,
    first: Vec3<T>,
    second: [T; 6],
}

impl<T: Scalar> Body<T> {
    #[inline(always)]
    fn zero() -> Self {
        Self {
            mass: T::constant(0.0),
            first: Vec3::zero(),
            second: [T::constant(0.0); 6],
        }
    }

    /// A body with ten inertial parameters about the origin of a frame with this turn and origin.
    #[inline(always)]
    fn placed(parameters: &[f64], turn: &Mat3<T>, origin: Vec3<T>) -> Self {
        let half = 0.5 * (parameters[4] + parameters[6] + parameters[9]);
        let own = Mat3::constant([
            [half - parameters[4], -parameters[5], -parameters[7]],
            [-parameters[5], half - parameters[6], -parameters[8]],
            [-parameters[7], -parameters[8], half - parameters[9]],
        ]);
        let mass = T::constant(parameters[0]);
        let moment = turn.times(Vec3::constant([
            parameters[1],
            parameters[2],
            parameters[3],
        ]));
        let [x, y, z] = turn.0;
        let (a, b, c) = (own.times(Vec3(x)), own.times(Vec3(y)), own.times(Vec3(z)));
        let ([rx, ry, rz], Vec3([wx, wy, wz])) = (
            origin.0,
            moment.plus_scaled(mass * T::constant(0.5), origin),
        );
        Self {
            mass,
            first: moment.plus_scaled(mass, origin),
            second: [
                a.dot(Vec3(x)) + rx.mul_add(wx, rx * wx),
                a.dot(Vec3(y)) + rx.mul_add(wy, ry * wx),
                b.dot(Vec3(y)) + ry.mul_add(wy, ry * wy),
                a.dot(Vec3(z)) + rx.mul_add(wz, rz * wx),
                b.dot(Vec3(z)) + ry.mul_add(wz, rz * wy),
                c.dot(Vec3(z)) + rz.mul_add(wz, rz * wz),
            ],
        }
    }

    /// `I m`.
    #[inline(always)]
    fn times(&self, m: Twist<T>) -> Load<T> {
        let [xx, _, yy, _, _, zz] = self.second;
        let turned = Mat3::symmetric(self.second).times(m.angular);
        Load {
            force: -self
                .first
                .cross(m.angular)
                .plus_scaled(-self.mass, m.linear),
            moment: self.first.cross(m.linear) - turned.plus_scaled(-(xx + yy + zz), m.angular),
        }
    }

    #[inline(always)]
    fn add(&mut self, other: &Self) {
        self.mass += other.mass;
        self.first += other.first;
        for k in 0..6 {
            self.second[k] += other.second[k];
        }
    }
}

/// B: what maps a turn to a moment, and the linear momentum l.
#[derive(Clone, Copy, Debug)]
struct Bias<T> {
    turn: Mat3<T>,
    momentum: Vec3<T>,
}

impl<T: Scalar> Bias<T> {
    #[inline(always)]
    fn zero() -> Self {
        Self {
            turn: Mat3::constant([[0.0; 3]; 3]),
            momentum: Vec3::zero(),
        }
    }

    #[inline(always)]
    fn of(body: &Body<T>, v: Twist<T>, momentum: Vec3<T>) -> Self {
        let [xx, xy, yy, xz, yz, zz] = body.second;
        let [x, y, z] = [
            Vec3([xx, xy, xz]).cross(v.angular),
            Vec3([xy, yy, yz]).cross(v.angular),
            Vec3([xz, yz, zz]).cross(v.angular),
        ];
        let ([ux, uy, uz], [hx, hy, hz]) = (v.linear.0, body.first.0);
        let along = body.first.dot(v.linear);
        Self {
            turn: Mat3([
                [x.0[0] - ux * hx + along, y.0[0] - ux * hy, z.0[0] - ux * hz],
                [x.0[1] - uy * hx, y.0[1] - uy * hy + along, z.0[1] - uy * hz],
                [x.0[2] - uz * hx, y.0[2] - uz * hy, z.0[2] - uz * hz + along],
            ]),
            momentum,
        }
    }

    /// `B m`.
    #[inline(always)]
    fn times(&self, m: Twist<T>) -> Load<T> {
        Load {
            force: m.angular.cross(self.momentum),
            moment: self.turn.times(m.angular),
        }
    }

    /// The angular part of `Bᵀ m`; the linear one vanishes.
    #[inline(always)]
    fn transpose_times(&self, m: Twist<T>) -> Vec3<T> {
        self.turn.transpose_times(m.angular) + self.momentum.cross(m.linear)
    }

    #[inline(always)]
    fn add(&mut self, other: &Self) {
        for r in 0..3 {
            for c in 0..3 {
                self.turn.0[r][c] += other.turn.0[r][c];
            }
        }
        self.momentum += other.momentum;
    }
}

/// One joint and its link; inward also the links that the joint moves.
#[derive(Clone, Copy, Debug)]
struct Spatial<T> {
    /// From link to base coordinates.
    turn: Mat3<T>,
    origin: Vec3<T>,
    /// S
    axis: Twist<T>,
    /// Ψ̇
    axis_rate: Twist<T>,
    /// Ψ̈
    axis_second_rate: Twist<T>,
    velocity: Twist<T>,
    acceleration: Twist<T>,
    body: Body<T>,
    bias: Bias<T>,
    force: Load<T>,
}

impl<T: Scalar> Spatial<T> {
    #[inline(always)]
    fn rest() -> Self {
        Self {
            turn: Mat3::constant([[0.0; 3]; 3]),
            origin: Vec3::zero(),
            axis: Twist::zero(),
            axis_rate: Twist::zero(),
            axis_second_rate: Twist::zero(),
            velocity: Twist::zero(),
            acceleration: Twist::zero(),
            body: Body::zero(),
            bias: Bias::zero(),
            force: Load::zero(),
        }
    }

    /// The next link outward, without its body.
    #[inline(always)]
    fn moved(&self, link: &Link, state: &JointState<T>) -> Self {
        let (down, offset) = placement(link, state);
        let [x, y, z] = self.turn.0;
        let turn = Mat3([
            down.times(Vec3(x)).0,
            down.times(Vec3(y)).0,
            down.times(Vec3(z)).0,
        ]);
        let origin = self.origin + self.turn.times(offset);
        let along = turn.times(Vec3::constant(link.axis));
        let axis = if link.revolute {
            Twist {
                angular: along,
                linear: origin.cross(along),
            }
        } else {
            Twist {
                angular: Vec3::zero(),
                linear: along,
            }
        };
        let axis_rate = self.velocity.cross(axis);
        Self {
            turn,
            origin,
            axis,
            axis_rate,
            axis_second_rate: self
                .acceleration
                .cross(axis)
                .plus(self.velocity.cross(axis_rate)),
            velocity: self.velocity.plus_scaled(state.dq, axis),
            acceleration: self
                .acceleration
                .plus_scaled(state.ddq, axis)
                .plus_scaled(state.dq, axis_rate),
            ..Self::rest()
        }
    }

    /// Gives the link its body: ten inertial parameters.
    #[inline(always)]
    fn load(&mut self, parameters: &[f64]) {
        self.body = Body::placed(parameters, &self.turn, self.origin);
        let momentum = self.body.times(self.velocity);
        self.bias = Bias::of(&self.body, self.velocity, momentum.force);
        self.force = sum(
            self.body.times(self.acceleration),
            self.velocity.cross_load(momentum),
        );
    }
}
