//! From the torque that the motors transmit to their signal: laws, losses, currents, delays.

use crate::chain::effect::expression::{Expression, Function, Variable};
use crate::export::code::writer::{Writer, name};
use crate::export::drive::Current;
use crate::export::program::{Body, Head, Visibility};
use crate::export::values::combination;

/// What moves in the places of a law's variables.
pub(super) struct Moving<'a> {
    pub(super) joint: usize,
    /// Of the motor: `m`, `v`, `a` and `s` with the joint's number.
    pub(super) sign: &'a str,
}

/// A formula of the current of this name.
pub(super) fn with_current(of: &Expression, current: &str) -> Expression {
    of.replaced(&|e| match e {
        Expression::Variable(Variable::Current) => Some(name(current)),
        _ => None,
    })
}

pub(super) fn of_parts(parts: usize) -> f64 {
    parts as f64
}

impl Writer<'_> {
    /// `m = V⁻¹ (q − offset)` and its derivatives, of the arrays with these names.
    pub(super) fn bind_motors(&self, body: &mut Body, series: [&str; 3]) {
        for j in 0..self.joints() {
            let row = self.drives.coupling.inverse.row(j);
            let shift = combination(&row, |k| self.drives.offset[k].clone());
            let position = combination(&row, |k| name(format!("{}[{k}]", series[0])));
            let position = match shift {
                Expression::Number(0.0) => position,
                shift => position - shift,
            };
            body.bind(&format!("m{j}"), &position);
            for (letter, series) in ["v", "a"].into_iter().zip(&series[1..]) {
                let value = combination(&row, |k| name(format!("{series}[{k}]")));
                body.bind(&format!("{letter}{j}"), &value);
            }
            let width = self.language.formula(&self.drives.drives[j].width);
            body.bind(&format!("s{j}"), &name(format!("sign(v{j}, {width})")));
        }
    }

    /// A law with the motion of a motor in the places of its variables.
    pub(super) fn of_motor(
        &self,
        law: &Expression,
        moving: &Moving<'_>,
        state: &str,
    ) -> Expression {
        let j = moving.joint;
        law.replaced(&|e| match e {
            Expression::Variable(variable) => Some(match variable {
                Variable::Position => name(format!("m{j}")),
                Variable::Velocity => name(format!("v{j}")),
                Variable::Acceleration => name(format!("a{j}")),
                Variable::Sign => name(moving.sign),
                Variable::Time => name("now"),
                Variable::Load => name(format!("load{j}")),
                Variable::State(k) => name(format!("{state}_{k}")),
                other => Expression::Variable(*other),
            }),
            _ => None,
        })
    }

    /// Binds the states of the laws of a motor at the end of the step.
    pub(super) fn bind_states(&self, body: &mut Body, j: usize) {
        for (k, law) in self.drives.drives[j].motor.iter().enumerate() {
            let Some(at) = self.layout.bristles[j][k] else {
                continue;
            };
            let now = name(format!("v{j}"));
            let before = name(format!("state[{}]", at + law.states.len()));
            for (s, of) in law.states.iter().enumerate() {
                let z = format!("z{j}_{k}_{s}");
                let velocity = |of: &Expression, velocity: &Expression, parts: usize| {
                    of.replaced(&|e| match e {
                        Expression::Variable(Variable::Velocity) => Some(velocity.clone()),
                        Expression::Variable(Variable::State(_)) => Some(name(&z)),
                        Expression::Variable(Variable::Duration) => {
                            Some(name("dt") / of_parts(parts))
                        }
                        _ => None,
                    })
                };
                body.variable(&z, &name(format!("state[{}]", at + s)));
                body.if_less(&name("state[1]"), &Expression::Number(0.5));
                body.assign(&z, &velocity(&of.start, &now, of.parts));
                body.otherwise();
                for part in 0..of.parts {
                    let share = (part as f64 + 0.5) / of.parts as f64;
                    let middle = before.clone() + (now.clone() - before.clone()) * share;
                    let middle = body.bind(&format!("u{j}_{k}_{s}_{part}"), &middle);
                    body.assign(&z, &velocity(&of.advance, &middle, of.parts));
                }
                body.close();
            }
        }
    }

    /// Keeps the states of the laws of a motor.
    pub(super) fn keep_states(&self, body: &mut Body, j: usize) {
        for (k, at) in self.layout.bristles[j].iter().enumerate() {
            let Some(at) = at else { continue };
            let count = self.drives.drives[j].motor[k].states.len();
            for s in 0..count {
                body.assign(
                    &format!("state[{}]", at + s),
                    &name(format!("z{j}_{k}_{s}")),
                );
            }
            body.assign(&format!("state[{}]", at + count), &name(format!("v{j}")));
        }
    }

    /// Sum of the laws at a motor.
    pub(super) fn laws(&self, j: usize) -> Option<Expression> {
        let moving = Moving {
            joint: j,
            sign: &format!("s{j}"),
        };
        let laws = self.drives.drives[j].motor.iter().enumerate();
        let laws = laws.map(|(k, law)| self.of_motor(&law.torque, &moving, &format!("z{j}_{k}")));
        laws.reduce(|sum, law| sum + law)
    }

    /// What the signal of a motor shows beyond its torque.
    pub(super) fn shown(&self, j: usize) -> Option<Expression> {
        let moving = Moving {
            joint: j,
            sign: &format!("s{j}"),
        };
        let laws = self.drives.drives[j].signal.iter();
        let laws = laws.map(|law| self.of_motor(law, &moving, ""));
        laws.reduce(|sum, law| sum + law)
    }

    /// `τ_in` of the torque `load{j}`.
    pub(super) fn before_losses(&self, j: usize) -> Expression {
        let moving = Moving {
            joint: j,
            sign: &format!("s{j}"),
        };
        let losses = self.drives.drives[j].losses.iter();
        losses.fold(name(format!("load{j}")), |sum, law| {
            sum + self.of_motor(law, &moving, "")
        })
    }

    /// Torques of laws at a joint whose positions and velocities stand in the arrays of these names.
    pub(super) fn at_joint(
        &self,
        j: usize,
        [positions, velocities]: [&str; 2],
    ) -> Option<Expression> {
        let velocity = format!("{velocities}[{j}]");
        let width = self.language.formula(&self.drives.drives[j].width);
        let laws = self.drives.drives[j].joint.iter().map(|law| {
            law.replaced(&|e| match e {
                Expression::Variable(Variable::Position) => Some(name(format!("{positions}[{j}]"))),
                Expression::Variable(Variable::Velocity) => Some(name(&velocity)),
                Expression::Variable(Variable::Sign) => {
                    Some(name(format!("sign({velocity}, {width})")))
                }
                Expression::Variable(Variable::Time) => Some(name("now")),
                _ => None,
            })
        });
        laws.reduce(|sum, law| sum + law)
    }

    /// Motor torques from the joint torques in the array `tau`, into `out`; `now` and the motors are bound.
    pub(super) fn assign_motor_torques(&self, body: &mut Body, motion: [&str; 2]) {
        for j in 0..self.joints() {
            if let Some(laws) = self.at_joint(j, motion) {
                let sum = name(format!("tau[{j}]")) + laws;
                body.assign(&format!("tau[{j}]"), &sum);
            }
        }
        for j in 0..self.joints() {
            let column = self.drives.coupling.matrix.column(j);
            body.bind(
                &format!("load{j}"),
                &combination(&column, |k| name(format!("tau[{k}]"))),
            );
            self.bind_states(body, j);
            let mut torque = self.before_losses(j);
            if let Some(laws) = self.laws(j) {
                torque = torque + laws;
            }
            body.assign(&format!("out[{j}]"), &torque);
        }
    }

    pub(super) fn motor_torque(&self, suffix: &str) -> String {
        let mut body = self.body();
        body.array("tau", self.joints());
        body.call(&format!("joint_torque{suffix}"), &["q", "dq", "ddq", "tau"]);
        self.bind_motors(&mut body, ["q", "dq", "ddq"]);
        self.assign_motor_torques(&mut body, ["q", "dq"]);
        body.function(&Head {
            name: &format!("motor_torque{suffix}"),
            documentation: "Torques at the motors, at joint scale: what moves the joints, losses, rotor inertia, friction, offsets.",
            arguments: &self.motion_arguments(),
            visibility: Visibility::Public,
        })
    }

    pub(super) fn motor_current(&self, suffix: &str) -> String {
        let mut body = self.body();
        body.call(&format!("motor_torque{suffix}"), &["q", "dq", "ddq", "out"]);
        self.become_signals(&mut body);
        body.function(&Head {
            name: &format!("motor_current{suffix}"),
            documentation: "Currents of the motors, A.",
            arguments: &self.motion_arguments(),
            visibility: Visibility::Public,
        })
    }

    /// Motor torques in `out` become what is read: `s = τ_mot / (k · gain)`, or the current of a polynomial.
    pub(super) fn become_signals(&self, body: &mut Body) {
        for (j, drive) in self.drives.drives.iter().enumerate() {
            let out = format!("out[{j}]");
            if let Some(shown) = self.shown(j) {
                body.assign(&out, &(name(&out) + shown));
            }
            if drive.factor != Expression::Number(1.0) {
                body.assign(&out, &(name(&out) / drive.factor.clone()));
            }
            let Some(Current {
                coefficients,
                branch,
                ..
            }) = &drive.current
            else {
                continue;
            };
            // Newton's steps, and bisection where they leave the bracket: the branch rises.
            let size = body.bind(&format!("size{j}"), &name(&out).magnitude());
            let [low, high, at] = ["low", "high", "at"].map(|word| format!("{word}{j}"));
            let of = |e: &Expression| with_current(e, &at);
            let slope = of(&branch.slope);
            body.variable(&low, &Expression::Number(0.0));
            body.variable(&high, &Expression::Number(1.0));
            body.variable(&at, &Expression::Number(0.0));
            let bound = coefficients[0].clone().call_with(Function::Larger, 0.0);
            body.if_less(&bound, &size);
            let grown = with_current(&branch.torque, &high);
            body.repeat("_k", 1000);
            body.if_less(&grown, &size);
            body.assign(&high, &(name(&high) * 2.0));
            body.otherwise();
            body.leave();
            body.close();
            body.close();
            body.assign(&at, &name(&high));
            body.repeat("_k", 100);
            let miss = body.bind(&format!("miss{j}"), &(of(&branch.torque) - size.clone()));
            body.if_less(&Expression::Number(0.0), &miss);
            body.assign(&high, &name(&at));
            body.otherwise();
            body.assign(&low, &name(&at));
            body.close();
            body.variable(&format!("next{j}"), &(name(&at) - miss / slope));
            let next = format!("next{j}");
            let halved = (name(&low) + name(&high)) * 0.5;
            body.if_less(&name(&next), &name(&low));
            body.assign(&next, &halved);
            body.close();
            body.if_less(&name(&high), &name(&next));
            body.assign(&next, &halved);
            body.close();
            let moved = (name(&next) - name(&at)).magnitude();
            let moved = body.bind(&format!("moved{j}"), &moved);
            body.assign(&at, &name(&next));
            let last = name(&next) * (4.0 * f64::EPSILON);
            body.if_less(&moved, &last);
            body.leave();
            body.close();
            body.close();
            body.close();
            body.assign(&out, &(name(&out).call(Function::Signum) * name(&at)));
        }
        self.hear_others(body);
    }

    /// Signals of the motors in `out` become those of channels that hear one another.
    fn hear_others(&self, body: &mut Body) {
        let crosstalk = &self.drives.crosstalk;
        if crosstalk.is_identity() {
            return;
        }
        for j in 0..self.joints() {
            body.bind(&format!("own{j}"), &name(format!("out[{j}]")));
        }
        for (j, row) in crosstalk.matrix.row_iter().enumerate() {
            let heard = combination(row.iter(), |k| name(format!("own{k}")));
            body.assign(&format!("out[{j}]"), &heard);
        }
    }
}
