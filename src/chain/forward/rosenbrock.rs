//! ROS2 for `A ẍ = r(x, ẋ, z, t)`, `ż = f(z, ẋ)` with a matrix A that is not inverted.
//!
//! With D = −∂r/∂ẋ, S = −∂r/∂x, b = ∂r/∂z (less), a = −∂f/∂z, c = ∂f/∂ẋ, all diagonal, and γ = 1 − 1/√2,
//!
//! ```text
//! W = A + γh D + γ²h² S + γ²h² b c/(1 + γh a)
//! W k₁ = r − γh S ẋ − γh b f/(1 + γh a)
//! W k₂ = r⁺ − 2A k₁ − γh S (ẋ + h k₁ − 2 k₁ˣ) − γh b (f⁺ − 2 k₁ᶻ)/(1 + γh a)
//! k₁ˣ = ẋ + γh k₁,   k₁ᶻ = (f + γh c k₁)/(1 + γh a),   y⁺ = y + h (3k₁ + k₂)/2
//! ```
//!
//! where r⁺ and f⁺ are those at y + h k₁. The difference from the method of order one, h |k₁ + k₂|/2, tells how many steps
//! it takes.

use crate::chain::forward::drive::{Drive, Moving};
use crate::chain::forward::state::{Driven, Drivetrain, State, TimeSpan};

/// γ = 1 − 1/√2: ROS2 is L-stable.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

/// Halvings of a step. What passes faster is a jump within less than a microsecond, which an L-stable method survives.
const MOST_HALVINGS: u32 = 10;

/// Turns in which the sides of losses settle on which they act.
const SIDES: usize = 3;

/// A transmitted torque that leaves a loss where its slope put it to this share is on the side of that slope.
const SAME_SIDE: f64 = 1e-9;

/// A pivot below this share of its diagonal is rounding.
const SINGULAR: f64 = 1e-13;

/// The right-hand side at one state, and its derivatives.
#[derive(Debug, Clone, Default)]
struct Side {
    force: Vec<f64>,
    /// D and S.
    damping: Vec<f64>,
    stiffness: Vec<f64>,
    /// ∂losses/∂τ.
    loss_slope: Vec<f64>,
    /// f, a, c and b.
    rate: Vec<f64>,
    decay: Vec<f64>,
    fill: Vec<f64>,
    weight: Vec<f64>,
}

impl Side {
    fn new(size: usize) -> Self {
        let zeros = || vec![0.0; size];
        Self {
            force: zeros(),
            damping: zeros(),
            stiffness: zeros(),
            loss_slope: zeros(),
            rate: zeros(),
            decay: zeros(),
            fill: zeros(),
            weight: zeros(),
        }
    }
}

/// The integrator with its memory.
#[derive(Debug)]
pub(super) struct Rosenbrock {
    size: usize,
    motors: usize,
    tolerance: f64,
    /// Bᵀ M B, row after row, and Bᵀ h.
    pub mass: Vec<f64>,
    pub bias: Vec<f64>,
    /// Bᵀ τ of the last step: where losses are linearised.
    load: Vec<f64>,
    halvings: u32,
    torque: Vec<f64>,
    now: Side,
    ahead: Side,
    matrix: Vec<f64>,
    first: Vec<f64>,
    second: Vec<f64>,
    first_memory: Vec<f64>,
    trial: State,
    right: Vec<f64>,
}

impl Rosenbrock {
    pub fn new(size: usize, motors: usize, tolerance: f64) -> Self {
        let zeros = || vec![0.0; size];
        Self {
            size,
            motors,
            tolerance,
            mass: vec![0.0; size * size],
            bias: zeros(),
            load: zeros(),
            halvings: 0,
            torque: zeros(),
            now: Side::new(size),
            ahead: Side::new(size),
            matrix: vec![0.0; size * size],
            first: zeros(),
            second: zeros(),
            first_memory: vec![0.0; motors],
            trial: State {
                position: zeros(),
                velocity: zeros(),
                memory: vec![0.0; motors],
            },
            right: zeros(),
        }
    }

    /// Forgets another motion.
    pub fn begin(&mut self) {
        self.load.fill(0.0);
        self.halvings = 0;
    }

    /// Integrates over a span. The index of a coordinate without inertia is the error.
    pub fn integrate(
        &mut self,
        state: &mut State,
        train: &mut Drivetrain<'_>,
        span: TimeSpan,
    ) -> Result<(), usize> {
        let whole = 1_u32 << MOST_HALVINGS;
        let mut done = 0;
        while done < whole {
            let at = |done: u32| span.at(f64::from(done) / f64::from(whole));
            self.drive(train.driven, at(done));
            let mut now = std::mem::take(&mut self.now);
            self.evaluate(state, train, &mut now);
            let settled = self.settle_losses(state, train, &mut now, span.duration);
            self.now = now;
            settled?;
            loop {
                let share = whole >> self.halvings;
                let step = span.duration * f64::from(share) / f64::from(whole);
                self.drive(train.driven, at(done + share));
                let error = self.attempt(state, train, step)?;
                // Also rejects what is not a number.
                let fits = error <= self.tolerance;
                if !fits && self.halvings < MOST_HALVINGS {
                    self.halvings += 1;
                    continue;
                }
                self.accept(state, step);
                done += share;
                // A step of twice the length has four times the error, and must end on a multiple of its length.
                let even = self.halvings > 0 && done.is_multiple_of(2 * share);
                if even && 4.0 * error <= self.tolerance {
                    self.halvings -= 1;
                }
                break;
            }
        }
        Ok(())
    }

    /// Torques of the motors, or what controllers aim at, at a share of the time over which they are linear.
    fn drive(&mut self, driven: Driven<'_>, share: f64) {
        if let Driven::Torque { from, to } | Driven::Command { from, to } = driven {
            for (u, (from, to)) in self.torque.iter_mut().zip(from.iter().zip(to)) {
                *u = from + share * (to - from);
            }
        }
    }

    fn evaluate(&self, state: &State, train: &mut Drivetrain<'_>, out: &mut Side) {
        let is_controlled = train.is_controlled();
        for (k, drive) in train.drives.iter_mut().enumerate() {
            let v = state.velocity[k];
            let taken = drive.taken(state.position[k], v);
            let mut force = self.torque[k] - taken.torque;
            let mut damping = taken.slope;
            out.stiffness[k] = 0.0;
            if is_controlled {
                let servo = drive.servo;
                force -= servo.stiffness * state.position[k] + servo.damping * v;
                damping += servo.damping;
                out.stiffness[k] = servo.stiffness;
            }
            if let Some(flow) = drive.flow(state.memory[k], v) {
                force -= flow.torque;
                damping += flow.torque_by_velocity.max(0.0);
                out.rate[k] = flow.rate;
                out.decay[k] = -flow.rate_by_state;
                out.fill[k] = flow.rate_by_velocity;
                out.weight[k] = flow.torque_by_state;
            }
            if drive.has_losses() {
                let moving = Moving {
                    position: state.position[k],
                    velocity: v,
                };
                let loss = drive.loss(self.load[k], moving);
                force -= loss.torque - loss.by_load * self.load[k];
                damping += (loss.by_sign * taken.sign_slope).max(0.0);
                out.loss_slope[k] = loss.by_load;
            }
            out.force[k] = force - (1.0 + out.loss_slope[k]) * self.bias[k];
            out.damping[k] = damping;
        }
        for (f, lag) in train.lags.iter().enumerate() {
            let at = self.motors + f;
            let contact = lag.flank.contact(state.position[at], state.velocity[at]);
            out.force[at] = -contact.torque - self.bias[at];
            out.damping[at] = contact.by_rate.max(0.0);
            out.stiffness[at] = contact.by_lag.max(0.0);
        }
    }

    /// Row k of A times a vector.
    fn row_times(&self, drives: &[Drive], side: &Side, k: usize, x: &[f64]) -> f64 {
        let row = &self.mass[k * self.size..(k + 1) * self.size];
        let sum: f64 = row.iter().zip(x).map(|(a, b)| a * b).sum();
        (1.0 + side.loss_slope[k]) * sum + drives.get(k).map_or(0.0, |d| d.inertia * x[k])
    }

    /// A into the matrix, with a diagonal added; rows of motors whose motion is given are those of the identity.
    fn assemble(&mut self, train: &Drivetrain<'_>, side: &Side, added: impl Fn(usize) -> f64) {
        let n = self.size;
        let given = train.is_given();
        for k in 0..n {
            let row = &mut self.matrix[k * n..(k + 1) * n];
            if given && k < self.motors {
                row.fill(0.0);
                row[k] = 1.0;
                continue;
            }
            let scale = 1.0 + side.loss_slope[k];
            for (to, from) in row.iter_mut().zip(&self.mass[k * n..(k + 1) * n]) {
                *to = scale * from;
            }
            row[k] += train.drives.get(k).map_or(0.0, |d| d.inertia) + added(k);
        }
    }

    /// Lets losses act on the side of the transmitted torque on which the motion puts it.
    fn settle_losses(
        &mut self,
        state: &State,
        train: &mut Drivetrain<'_>,
        side: &mut Side,
        h: f64,
    ) -> Result<(), usize> {
        if train.is_given() || !train.has_losses() {
            return Ok(());
        }
        let step = h / f64::from(1_u32 << self.halvings);
        for _ in 0..SIDES {
            self.prepare(train, side, step);
            self.factor()?;
            self.right_of_first(state, train.driven, side, step);
            let mut k1 = std::mem::take(&mut self.right);
            self.substitute(&mut k1);
            let mut same = true;
            for (k, drive) in train.drives.iter_mut().enumerate() {
                let row = &self.mass[k * self.size..(k + 1) * self.size];
                let load = self.bias[k] + row.iter().zip(&k1).map(|(a, b)| a * b).sum::<f64>();
                if drive.has_losses() {
                    let moving = Moving {
                        position: state.position[k],
                        velocity: state.velocity[k],
                    };
                    let (there, here) =
                        (drive.loss(load, moving), drive.loss(self.load[k], moving));
                    let expected = here.torque + here.by_load * (load - self.load[k]);
                    let scale = there.torque.abs() + load.abs();
                    same &= (there.torque - expected).abs() <= SAME_SIDE * scale;
                }
                self.load[k] = load;
            }
            self.right = k1;
            self.evaluate(state, train, side);
            if same {
                break;
            }
        }
        Ok(())
    }

    fn prepare(&mut self, train: &Drivetrain<'_>, side: &Side, h: f64) {
        let g = GAMMA * h;
        self.assemble(train, side, |k| {
            let memory = side.weight[k] * side.fill[k] / (1.0 + g * side.decay[k]);
            g * side.damping[k] + g * g * (side.stiffness[k] + memory)
        });
    }

    fn right_of_first(&mut self, state: &State, driven: Driven<'_>, side: &Side, h: f64) {
        let g = GAMMA * h;
        for k in 0..self.size {
            let memory = side.weight[k] * side.rate[k] / (1.0 + g * side.decay[k]);
            self.right[k] = side.force[k] - g * (side.stiffness[k] * state.velocity[k] + memory);
        }
        if let Driven::Motion { acceleration } = driven {
            self.right[..self.motors].copy_from_slice(&acceleration[..self.motors]);
        }
    }

    /// k₁ and k₂ of a step from a state; the largest difference of a velocity from the method of order one.
    fn attempt(&mut self, state: &State, train: &mut Drivetrain<'_>, h: f64) -> Result<f64, usize> {
        let (now, mut ahead) = (
            std::mem::take(&mut self.now),
            std::mem::take(&mut self.ahead),
        );
        let error = self.stages(state, train, h, &now, &mut ahead);
        (self.now, self.ahead) = (now, ahead);
        error
    }

    fn stages(
        &mut self,
        state: &State,
        train: &mut Drivetrain<'_>,
        h: f64,
        now: &Side,
        ahead: &mut Side,
    ) -> Result<f64, usize> {
        let g = GAMMA * h;
        let (n, motors) = (self.size, self.motors);
        self.right_of_first(state, train.driven, now, h);
        self.prepare(train, now, h);
        self.factor()?;
        let mut k1 = std::mem::take(&mut self.first);
        k1.copy_from_slice(&self.right);
        self.substitute(&mut k1);
        for k in 0..n {
            self.trial.velocity[k] = state.velocity[k] + h * k1[k];
            self.trial.position[k] = state.position[k] + h * (state.velocity[k] + g * k1[k]);
        }
        for k in 0..motors {
            let filled = now.rate[k] + g * now.fill[k] * k1[k];
            self.first_memory[k] = filled / (1.0 + g * now.decay[k]);
            self.trial.memory[k] = state.memory[k] + h * self.first_memory[k];
        }
        let trial = std::mem::take(&mut self.trial);
        self.evaluate(&trial, train, ahead);
        self.trial = trial;
        let given = train.is_given();
        let mut k2 = std::mem::take(&mut self.second);
        k2.copy_from_slice(&ahead.force);
        if !given && train.has_losses() {
            // A is another one there: its acceleration, brought to this A.
            let kept = self.matrix.clone();
            self.assemble(train, ahead, |_| 0.0);
            self.factor()?;
            self.substitute(&mut k2);
            let carried: Vec<f64> = (0..n)
                .map(|k| self.row_times(train.drives, now, k, &k2))
                .collect();
            k2.copy_from_slice(&carried);
            self.matrix = kept;
        }
        for k in 0..n {
            if given && k < motors {
                k2[k] = -k1[k];
                continue;
            }
            let moved = self.trial.velocity[k] - 2.0 * (state.velocity[k] + g * k1[k]);
            k2[k] -= 2.0 * self.row_times(train.drives, now, k, &k1) + g * now.stiffness[k] * moved;
            if k < motors && now.weight[k] != 0.0 {
                let memory = ahead.rate[k] - 2.0 * self.first_memory[k];
                k2[k] -= g * now.weight[k] * memory / (1.0 + g * now.decay[k]);
            }
        }
        self.substitute(&mut k2);
        let mut error = 0.0_f64;
        for k in (if given { motors } else { 0 })..n {
            let own = 0.5 * h * (k1[k] + k2[k]).abs();
            error = if own.is_nan() {
                f64::INFINITY
            } else {
                error.max(own)
            };
        }
        // Position and memory of the end, while everything is at hand.
        for k in 0..n {
            let first = state.velocity[k] + g * k1[k];
            let second = self.trial.velocity[k] - 2.0 * first + g * k2[k];
            self.trial.position[k] = state.position[k] + 0.5 * h * (3.0 * first + second);
        }
        for k in 0..motors {
            let first = self.first_memory[k];
            let second =
                (ahead.rate[k] - 2.0 * first + g * now.fill[k] * k2[k]) / (1.0 + g * now.decay[k]);
            self.trial.memory[k] = state.memory[k] + 0.5 * h * (3.0 * first + second);
        }
        (self.first, self.second) = (k1, k2);
        Ok(error)
    }

    /// Takes the state to the end of the last step that was attempted.
    fn accept(&mut self, state: &mut State, h: f64) {
        for k in 0..self.size {
            state.velocity[k] += 0.5 * h * (3.0 * self.first[k] + self.second[k]);
        }
        state.position.copy_from_slice(&self.trial.position);
        state.memory.copy_from_slice(&self.trial.memory);
    }

    /// LU factors in place, without pivoting: the matrix is positive definite, or nearly symmetric where losses depend
    /// on load.
    fn factor(&mut self) -> Result<(), usize> {
        let n = self.size;
        for k in 0..n {
            let (above, below) = self.matrix.split_at_mut((k + 1) * n);
            let pivots = &above[k * n..];
            let pivot = pivots[k];
            let diagonal = self.mass[k * n + k].abs();
            // Also false for a pivot that is not a number.
            let regular = pivot > SINGULAR * diagonal;
            if !regular {
                return Err(k);
            }
            for row in below.chunks_exact_mut(n) {
                let factor = row[k] / pivot;
                if factor != 0.0 {
                    for (to, from) in row[k + 1..].iter_mut().zip(&pivots[k + 1..]) {
                        *to -= factor * from;
                    }
                }
                row[k] = factor;
            }
        }
        Ok(())
    }

    /// Solves with the factors.
    fn substitute(&self, right: &mut [f64]) {
        let n = self.size;
        for k in 1..n {
            let row = &self.matrix[k * n..k * n + k];
            let sum: f64 = row.iter().zip(&*right).map(|(a, b)| a * b).sum();
            right[k] -= sum;
        }
        for k in (0..n).rev() {
            let row = &self.matrix[k * n + k + 1..(k + 1) * n];
            let sum: f64 = row.iter().zip(&right[k + 1..]).map(|(a, b)| a * b).sum();
            right[k] = (right[k] - sum) / self.matrix[k * n + k];
        }
    }
}
