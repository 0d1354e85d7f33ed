//! The law of the drives forwards: from signal and motion of the joints to the torques that move the links.

use crate::chain::effect::expression::{Expression, Function};
use crate::export::code::lag::LAG_SHARE;
use crate::export::code::layout::DelayLine;
use crate::export::code::motors::with_current;
use crate::export::code::writer::{Writer, name};
use crate::export::program::{Argument, Body, Head, Visibility};
use crate::export::values::{combination, product};

/// Change of a torque by which slopes are measured, N·m (N): the laws are straight on either side of zero.
pub(super) const TORQUE_CHANGE: f64 = 1e-3;

impl Writer<'_> {
    /// Binds `drive{j}`, the torque of each motor, from the signals in the array of this name.
    pub(super) fn bind_driving(&self, body: &mut Body, signal: &str) {
        for (j, drive) in self.drives.drives.iter().enumerate() {
            let row = self.drives.crosstalk.inverse.row(j);
            let read = combination(row.iter(), |k| name(format!("{signal}[{k}]")));
            let torque = match &drive.current {
                Some(current) => {
                    let size = body.bind(&format!("size{j}"), &read.clone().magnitude());
                    let Expression::Name(size) = size else {
                        continue;
                    };
                    read.call(Function::Signum) * with_current(&current.branch.torque, &size)
                }
                None => read,
            };
            let torque = product(torque, drive.factor.clone());
            let torque = match self.shown(j) {
                Some(shown) => torque - shown,
                None => torque,
            };
            body.bind(&format!("drive{j}"), &torque);
        }
    }

    /// Torque that a motor takes for its load less what it gives, by lags of links and torques at the other joints.
    pub(super) fn drive_miss(&self) -> String {
        let mut body = self.body();
        self.bind_clock(&mut body);
        self.bind_shaft(&mut body);
        self.bind_driving(&mut body, "signal");
        for j in 0..self.joints() {
            let mut miss = self.before_losses(j);
            if let Some(laws) = self.laws(j) {
                miss = miss + laws;
            }
            body.assign(&format!("out[{j}]"), &(miss - name(format!("drive{j}"))));
        }
        body.function(&Head {
            name: "drive_miss",
            documentation: "What the motors take less what they give, by lags of links and torques at the other joints.",
            arguments: &self.drive_miss_arguments(),
            visibility: Visibility::Private,
        })
    }

    pub(super) fn drive_miss_arguments(&self) -> Vec<Argument> {
        let n = self.joints();
        let mut arguments = self.values();
        arguments.extend([
            Argument::Read("state", self.layout.size),
            Argument::Scalar("dt"),
            Argument::Read("signal", n),
            Argument::Read("q", n),
            Argument::Read("dq", n),
            Argument::Read("ddq", n),
            Argument::Read("x", n),
            Argument::Written("out", n),
        ]);
        arguments
    }

    /// Motors, joint torques `tau{j}` and loads where the links are at q and `x` holds lags and torques.
    pub(super) fn bind_shaft(&self, body: &mut Body) {
        let members = self.members();
        for &j in &members {
            self.bind_lag(body, j, &format!("x[{j}]"));
        }
        for (series, order) in [("q", ""), ("dq", "d"), ("ddq", "dd")] {
            body.array(&format!("e{series}"), self.joints());
            for j in 0..self.joints() {
                let from = name(format!("{series}[{j}]"));
                let moved = match members.contains(&j) {
                    true => from + name(format!("{order}lag{j}")),
                    false => from,
                };
                body.assign(&format!("e{series}[{j}]"), &moved);
            }
        }
        self.bind_motors(body, ["eq", "edq", "eddq"]);
        for j in 0..self.joints() {
            self.bind_states(body, j);
            let torque = match members.contains(&j) {
                true => self.contact(j),
                false => name(format!("x[{j}]")),
            };
            body.bind(&format!("tau{j}"), &torque);
        }
        for j in 0..self.joints() {
            let column = self.drives.coupling.matrix.column(j);
            let load = combination(&column, |k| name(format!("tau{k}")));
            body.bind(&format!("load{j}"), &load);
        }
    }

    pub(super) fn drive_step(&self) -> String {
        let mut body = self.body();
        self.bind_clock(&mut body);
        body.array("acting", self.joints());
        for j in 0..self.joints() {
            body.assign(&format!("acting[{j}]"), &name(format!("signal[{j}]")));
            if let Some(line) = self.layout.lines[j] {
                self.hold_back(&mut body, j, line);
            }
        }
        if self.members().is_empty() {
            self.rigid_drive(&mut body);
        } else {
            self.lagging_drive(&mut body);
        }
        for j in 0..self.joints() {
            if let Some(laws) = self.at_joint(j, ["q", "dq"]) {
                body.assign(&format!("out[{j}]"), &(name(format!("out[{j}]")) - laws));
            }
            self.keep_states(&mut body, j);
            self.keep_lag(&mut body, j);
        }
        self.keep_clock(&mut body);
        body.function(&Head {
            name: "drive_step",
            documentation: "Torques of the drives on the links, from the signals of the motors and the motion of the links, dt after the\n\
                 step before; state goes on by one step. Begin with a state of zeros. Accelerations act on rotors alone: with\n\
                 rotors in the simulator (armature) give zeros.",
            arguments: &self.drive_arguments(),
            visibility: Visibility::Public,
        })
    }

    /// The signal that was given a delay before.
    pub(super) fn hold_back(&self, body: &mut Body, j: usize, line: DelayLine) {
        let DelayLine { first, count } = line;
        let delay = -self.drives.drives[j].delay;
        let signal = name(format!("signal[{j}]"));
        body.if_less(&name("state[1]"), &Expression::Number(0.5));
        body.repeat("k", count);
        body.assign(&format!("state[{first} + k]"), &signal);
        body.close();
        body.close();
        body.repeat("k", count - 1);
        let [to, from] = [count - 1, count - 2].map(|at| format!("state[{} - k]", first + at));
        body.assign(&to, &name(from));
        body.close();
        body.assign(&format!("state[{first}]"), &signal);
        body.variable(&format!("age{j}"), &Expression::Number(0.0));
        body.repeat("k", count);
        let reached = name(format!("age{j}"));
        // A delay of whole steps is met in spite of rounding.
        body.if_less(&reached, &(name("dt") * 1e-6 + delay));
        body.assign(
            &format!("acting[{j}]"),
            &name(format!("state[{first} + k]")),
        );
        body.close();
        body.assign(&format!("age{j}"), &(reached + name("dt")));
        body.close();
    }

    pub(super) fn rigid_drive(&self, body: &mut Body) {
        self.bind_motors(body, ["q", "dq", "ddq"]);
        self.bind_driving(body, "acting");
        for j in 0..self.joints() {
            self.bind_states(body, j);
            let mut left = name(format!("drive{j}"));
            if let Some(laws) = self.laws(j) {
                left = left - laws;
            }
            body.bind(&format!("left{j}"), &left);
            // Losses are proportional to the load on either side of zero: their share at loads of one and minus one.
            let share = |load: f64| {
                let of = self.before_losses(j);
                of.replaced(&|e| {
                    (*e == name(format!("load{j}"))).then_some(Expression::Number(load))
                })
            };
            let left = name(format!("left{j}"));
            let load = match self.drives.drives[j].losses.is_empty() {
                true => left,
                false => {
                    let up = body.bind(&format!("up{j}"), &share(1.0));
                    let down = body.bind(&format!("down{j}"), &-share(-1.0));
                    let lowered = left.clone() / down;
                    let raised = left.clone() / up;
                    left.if_less(0.0, lowered, raised)
                }
            };
            body.bind(&format!("load{j}"), &load);
        }
        for j in 0..self.joints() {
            let column = self.drives.coupling.inverse.column(j);
            let torque = combination(&column, |k| name(format!("load{k}")));
            body.assign(&format!("out[{j}]"), &torque);
        }
    }

    pub(super) fn lagging_drive(&self, body: &mut Body) {
        let n = self.joints();
        body.array("x", n);
        for (j, at) in self.layout.lags.iter().enumerate() {
            if let Some(at) = at {
                body.assign(&format!("x[{j}]"), &name(format!("state[{at}]")));
            }
        }
        let change: Vec<Expression> = (0..n)
            .map(|j| match self.layout.lags[j] {
                Some(_) => name("dt") * LAG_SHARE,
                None => Expression::Number(TORQUE_CHANGE),
            })
            .collect();
        let values = self.values();
        let values = values.iter().map(|argument| argument.name());
        let before: Vec<&str> = values
            .chain(["state", "dt", "acting", "q", "dq", "ddq"])
            .collect();
        self.newton(body, "drive_miss", &before, &change);
        self.bind_shaft(body);
        for j in 0..n {
            body.assign(&format!("out[{j}]"), &name(format!("tau{j}")));
        }
    }
}
