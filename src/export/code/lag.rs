//! Links that lag behind their motors: the equations of a step, and its inverse dynamics.

use crate::chain::effect::expression::{Expression, Variable};
use crate::export::code::writer::{Writer, name};
use crate::export::program::{Argument, Body, Head, Visibility};

/// Steps of Newton's method, and halvings of one that does not come closer.
pub(super) const STEPS: usize = 60;

pub(super) const HALVINGS: usize = 30;

/// Change of a lag by which its slopes are measured, as a share of the step's duration: a speed of this size.
pub(super) const LAG_SHARE: f64 = 1e-6;

impl Writer<'_> {
    pub(super) fn members(&self) -> Vec<usize> {
        self.drives.lagging()
    }

    /// Binds the time and the rate at which a backward difference weighs the value at the end of the step.
    pub(super) fn bind_clock(&self, body: &mut Body) {
        let began = |then: Expression| name("state[1]").if_less(0.5, 0.0, then);
        body.bind("now", &began(name("state[0]") + name("dt")));
        body.bind("rate", &began(Expression::Number(1.5) / name("dt")));
    }

    /// Binds `lag{j}`, `dlag{j}` and `ddlag{j}` of a member whose lag has this name.
    pub(super) fn bind_lag(&self, body: &mut Body, j: usize, lag: &str) {
        let Some(at) = self.layout.lags[j] else {
            return;
        };
        let past = |first: usize| {
            let [last, before] = [first, first + 1].map(|k| name(format!("state[{k}]")));
            (before - last * 4.0) * (name("rate") / 3.0)
        };
        body.bind(&format!("lag{j}"), &name(lag));
        let rate = name("rate") * name(format!("lag{j}")) + past(at);
        body.bind(&format!("dlag{j}"), &rate);
        let bend = name("rate") * name(format!("dlag{j}")) + past(at + 2);
        body.bind(&format!("ddlag{j}"), &bend);
    }

    /// What resists the lag of a member.
    pub(super) fn contact(&self, j: usize) -> Expression {
        let contact = self.drives.drives[j].contact.as_ref();
        contact.map_or(Expression::Number(0.0), |law| {
            law.replaced(&|e| match e {
                Expression::Variable(Variable::Lag) => Some(name(format!("lag{j}"))),
                Expression::Variable(Variable::LagRate) => Some(name(format!("dlag{j}"))),
                _ => None,
            })
        })
    }

    /// Keeps the lag of a member and its rate.
    pub(super) fn keep_lag(&self, body: &mut Body, j: usize) {
        let Some(at) = self.layout.lags[j] else {
            return;
        };
        // Before a first sample the link was where it is, at rest.
        body.if_less(&name("state[1]"), &Expression::Number(0.5));
        body.assign(&format!("state[{at}]"), &name(format!("lag{j}")));
        body.close();
        body.assign(&format!("state[{}]", at + 1), &name(format!("state[{at}]")));
        body.assign(&format!("state[{at}]"), &name(format!("lag{j}")));
        body.assign(
            &format!("state[{}]", at + 3),
            &name(format!("state[{}]", at + 2)),
        );
        body.assign(&format!("state[{}]", at + 2), &name(format!("dlag{j}")));
    }

    pub(super) fn keep_clock(&self, body: &mut Body) {
        body.assign("state[0]", &name("now"));
        body.assign("state[1]", &Expression::Number(1.0));
    }

    /// The motion of the links, `lq`, `ldq`, `lddq`, from that of the encoders and the lags.
    pub(super) fn move_links(&self, body: &mut Body, lags: impl Fn(usize) -> String) {
        let members = self.members();
        for series in ["lq", "ldq", "lddq"] {
            body.array(series, self.joints());
        }
        for (f, &j) in members.iter().enumerate() {
            self.bind_lag(body, j, &lags(f));
        }
        for j in 0..self.joints() {
            for (series, order) in [("q", ""), ("dq", "d"), ("ddq", "dd")] {
                let from = name(format!("{series}[{j}]"));
                let moved = match members.contains(&j) {
                    true => from - name(format!("{order}lag{j}")),
                    false => from,
                };
                body.assign(&format!("l{series}[{j}]"), &moved);
            }
        }
    }

    pub(super) fn miss_arguments(&self) -> Vec<Argument> {
        let (n, members) = (self.joints(), self.members().len());
        vec![
            Argument::Read("state", self.layout.size),
            Argument::Scalar("dt"),
            Argument::Read("q", n),
            Argument::Read("dq", n),
            Argument::Read("ddq", n),
            Argument::Read("x", members),
            Argument::Written("out", members),
        ]
    }

    /// What resists the lags less what the links take.
    pub(super) fn lag_miss(&self, suffix: &str) -> String {
        let mut body = self.body();
        self.bind_clock(&mut body);
        self.move_links(&mut body, |f| format!("x[{f}]"));
        body.array("tau", self.joints());
        body.call(
            &format!("joint_torque{suffix}"),
            &["lq", "ldq", "lddq", "tau"],
        );
        for (f, &j) in self.members().iter().enumerate() {
            let mut miss = self.contact(j) - name(format!("tau[{j}]"));
            if let Some(laws) = self.at_joint(j, ["lq", "ldq"]) {
                miss = miss - laws;
            }
            body.assign(&format!("out[{f}]"), &miss);
        }
        body.function(&Head {
            name: &format!("lag_miss{suffix}"),
            documentation: "What resists the lags of links less what the links take.",
            arguments: &self.miss_arguments(),
            visibility: Visibility::Private,
        })
    }

    /// Newton's method for `function(before.., x, r) = 0` with n unknowns, whose slopes are measured over `change`.
    pub(super) fn newton(
        &self,
        body: &mut Body,
        function: &str,
        before: &[&str],
        change: &[Expression],
    ) {
        let n = change.len();
        for (array, size) in [
            ("r", n),
            ("tried", n),
            ("moved", n),
            ("step", n),
            ("change", n),
            ("slopes", n * n),
        ] {
            body.array(array, size);
        }
        for (k, change) in change.iter().enumerate() {
            body.assign(&format!("change[{k}]"), change);
        }
        let of = |x: &'static str, r: &'static str| -> Vec<&str> {
            before.iter().copied().chain([x, r]).collect()
        };
        body.call(function, &of("x", "r"));
        body.repeat("_newton", STEPS);
        body.repeat("c", n);
        body.repeat("k", n);
        body.assign("moved[k]", &name("x[k]"));
        body.close();
        body.assign("moved[c]", &(name("x[c]") + name("change[c]")));
        body.call(function, &of("moved", "tried"));
        body.repeat("k", n);
        let slope = (name("tried[k]") - name("r[k]")) / name("change[c]");
        body.assign(&format!("slopes[k * {n} + c]"), &slope);
        body.close();
        body.close();
        body.repeat("k", n);
        body.assign("step[k]", &name("r[k]"));
        body.close();
        body.help("solve", &[&n.to_string(), "slopes", "step"]);
        body.variable("share", &Expression::Number(1.0));
        body.variable("closer", &Expression::Number(0.0));
        body.repeat("_halving", HALVINGS);
        body.repeat("k", n);
        body.assign(
            "moved[k]",
            &(name("x[k]") - name("share") * name("step[k]")),
        );
        body.close();
        body.call(function, &of("moved", "tried"));
        let squares = |of: &str| name(format!("squares({n}, {of})"));
        body.if_less(&squares("tried"), &squares("r"));
        body.repeat("k", n);
        body.assign("x[k]", &name("moved[k]"));
        body.assign("r[k]", &name("tried[k]"));
        body.close();
        body.assign("closer", &Expression::Number(1.0));
        body.leave();
        body.close();
        body.assign("share", &(name("share") * 0.5));
        body.close();
        body.if_less(&name("closer"), &Expression::Number(0.5));
        body.leave();
        body.close();
        body.close();
    }

    pub(super) fn inverse_step(&self, suffix: &str) -> String {
        let mut body = self.body();
        let members = self.members();
        self.bind_clock(&mut body);
        let mut links = ["q", "dq", "ddq"];
        if !members.is_empty() {
            body.array("x", members.len());
            for (f, &j) in members.iter().enumerate() {
                let at = self.layout.lags[j].unwrap_or(0);
                body.assign(&format!("x[{f}]"), &name(format!("state[{at}]")));
            }
            let change = vec![name("dt") * LAG_SHARE; members.len()];
            let before = ["state", "dt", "q", "dq", "ddq"];
            self.newton(&mut body, &format!("lag_miss{suffix}"), &before, &change);
            self.move_links(&mut body, |f| format!("x[{f}]"));
            links = ["lq", "ldq", "lddq"];
        }
        body.array("tau", self.joints());
        let [q, dq, ddq] = links;
        body.call(&format!("joint_torque{suffix}"), &[q, dq, ddq, "tau"]);
        self.bind_motors(&mut body, ["q", "dq", "ddq"]);
        self.assign_motor_torques(&mut body, [q, dq]);
        self.become_signals(&mut body);
        for j in 0..self.joints() {
            self.keep_states(&mut body, j);
            self.keep_lag(&mut body, j);
        }
        self.keep_clock(&mut body);
        body.function(&Head {
            name: &format!("inverse_step{suffix}"),
            documentation: "The signals that the next sample of a motion takes, dt after the one before; state goes on by one sample.\n\
                 Begin with a state of zeros; the first sample is at time 0, whatever dt is.",
            arguments: &self.inverse_arguments(),
            visibility: Visibility::Public,
        })
    }
}
