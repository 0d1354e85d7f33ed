//! The parts of a file of source: opening, functions with their arguments, and wrappers.

use crate::chain::effect::expression::Expression;
use crate::export::code::layout::Layout;
use crate::export::code::names::{in_comment, quoted};
use crate::export::drive::Drives;
use crate::export::language::Language;
use crate::export::program::{Argument, Body, Head, Visibility};
use crate::export::values::Values;
use crate::outcome::machine::Machine;
use crate::outcome::provenance::VERSION;

pub(super) struct Writer<'a> {
    pub(super) machine: &'a Machine,
    pub(super) language: Language,
    pub(super) prefix: &'a str,
    pub(super) drives: &'a Drives,
    pub(super) layout: &'a Layout,
}

pub(super) fn name(text: impl Into<String>) -> Expression {
    Expression::name(text)
}

pub(super) fn suffix(loaded: bool) -> &'static str {
    if loaded { "_with_load" } else { "" }
}

impl Writer<'_> {
    pub(super) fn joints(&self) -> usize {
        self.machine.joints.len()
    }

    pub(super) fn source(&self, title: &str) -> String {
        let mut parts = vec![self.opening(title)];
        for loaded in self.loads() {
            let suffix = suffix(loaded);
            parts.push(self.bodies(loaded, suffix));
            if self.drives.is_memoryless() {
                parts.push(self.motor_torque(suffix));
                if self.has_currents() {
                    parts.push(self.motor_current(suffix));
                }
            }
            if !self.members().is_empty() {
                parts.push(self.lag_miss(suffix));
            }
            parts.push(self.inverse_step(suffix));
        }
        if !self.members().is_empty() {
            parts.push(self.drive_miss());
        }
        parts.push(self.drive_step());
        if self.language == Language::NumPy {
            parts.push(self.wrappers());
        }
        let blank = match self.language {
            Language::NumPy => "\n\n",
            Language::Rust | Language::C => "\n",
        };
        parts.join(blank)
    }

    /// Without the load, and with it where there is one.
    pub(super) fn loads(&self) -> Vec<bool> {
        match self.machine.payload {
            Some(_) => vec![false, true],
            None => vec![false],
        }
    }

    pub(super) fn has_currents(&self) -> bool {
        let mut joints = self.machine.joints.iter();
        joints.all(|joint| joint.torque_constant.is_some())
    }

    pub(super) fn title(&self, title: &str) -> String {
        let names: Vec<String> = self
            .machine
            .joints
            .iter()
            .map(|j| in_comment(&j.name))
            .collect();
        let signal = if self.has_currents() { "A" } else { "N·m (N)" };
        format!(
            "{}: inverse dynamics and drives, written by exid {VERSION}. Arrays have one entry per joint, rad and N·m (m and N\n\
             for sliding joints), signals in {signal}, in the order {}.\n\
             Positions are as the motors' encoders show them, q = V m + offset; links behind elastic gears or play lag them.",
            in_comment(title),
            names.join(", ")
        )
    }

    pub(super) fn opening(&self, title: &str) -> String {
        let text = self.title(title);
        let (count, states) = (self.joints(), self.layout.size);
        let helpers = self.language.helpers();
        let names: Vec<String> = self
            .machine
            .joints
            .iter()
            .map(|j| quoted(&j.name))
            .collect();
        let names = names.join(", ");
        let delays: Vec<String> = self
            .drives
            .drives
            .iter()
            .map(|d| self.language.number(d.delay))
            .collect();
        let delays = delays.join(", ");
        match self.language {
            Language::Rust => format!(
                "// {}\n\npub const JOINTS: usize = {count};\n\n/// Entries of what the drives remember, all zero at the \
                 start.\npub const STATES: usize = {states};\n\n\
                 pub const JOINT_NAMES: [&str; JOINTS] = [{names}];\n\n\
                 /// s by which the signal at t belongs to the motion before t.\n\
                 pub const DELAYS: [f64; JOINTS] = [{delays}];\n\n{helpers}",
                text.replace('\n', "\n// ")
            ),
            Language::C => format!(
                "/* {text} */\n\n#include \"{}.h\"\n#include <math.h>\n\n{helpers}",
                self.prefix
            ),
            Language::NumPy => format!(
                "\"\"\"{text}\"\"\"\n\nimport numpy as np\n\nJOINTS = {count}\n# Entries of what the drives remember, all zero \
                 at the start.\nSTATES = {states}\nJOINT_NAMES = [{names}]\n\
                 # s by which the signal at t belongs to the motion before t.\nDELAYS = [{delays}]\n\n\n{helpers}"
            ),
        }
    }

    pub(super) fn header(&self, title: &str) -> String {
        let guard = self.prefix.to_uppercase();
        let delays: Vec<String> = self
            .drives
            .drives
            .iter()
            .map(|d| self.language.number(d.delay))
            .collect();
        let mut text = format!(
            "/* {} */\n\n#ifndef {guard}_H\n#define {guard}_H\n\n#define {guard}_JOINTS {}\n\
             /* Entries of what the drives remember, all zero at the start. */\n#define {guard}_STATES {}\n\
             /* s by which the signal at t belongs to the motion before t, per joint. */\n#define {guard}_DELAYS {{{}}}\n\n\
             #ifdef __cplusplus\nextern \"C\" {{\n#endif\n",
            self.title(title),
            self.joints(),
            self.layout.size,
            delays.join(", ")
        );
        let mut declare = |function: &str, arguments: &[Argument]| {
            let head = Head {
                name: function,
                documentation: "",
                arguments,
                visibility: Visibility::Public,
            };
            let declared = Body::new(self.language, self.prefix).declaration(&head);
            text.push_str(&format!("\n{declared};\n"));
        };
        for loaded in self.loads() {
            let suffix = suffix(loaded);
            declare(&format!("joint_torque{suffix}"), &self.motion_arguments());
            if self.drives.is_memoryless() {
                declare(&format!("motor_torque{suffix}"), &self.motion_arguments());
                if self.has_currents() {
                    declare(&format!("motor_current{suffix}"), &self.motion_arguments());
                }
            }
            declare(&format!("inverse_step{suffix}"), &self.inverse_arguments());
        }
        declare("drive_step", &self.drive_arguments());
        text.push_str("\n#ifdef __cplusplus\n}\n#endif\n#endif\n");
        text
    }

    pub(super) fn motion_arguments(&self) -> Vec<Argument> {
        let n = self.joints();
        vec![
            Argument::Read("q", n),
            Argument::Read("dq", n),
            Argument::Read("ddq", n),
            Argument::Written("out", n),
        ]
    }

    pub(super) fn inverse_arguments(&self) -> Vec<Argument> {
        let mut arguments = vec![
            Argument::Written("state", self.layout.size),
            Argument::Scalar("dt"),
        ];
        arguments.extend(self.motion_arguments());
        arguments
    }

    pub(super) fn drive_arguments(&self) -> Vec<Argument> {
        let mut arguments = self.values();
        arguments.extend([
            Argument::Written("state", self.layout.size),
            Argument::Scalar("dt"),
            Argument::Read("signal", self.joints()),
        ]);
        arguments.extend(self.motion_arguments());
        arguments
    }

    /// The array of numbers that were read, where there is one.
    pub(super) fn values(&self) -> Vec<Argument> {
        match &self.drives.values {
            Values::Numbers => Vec::new(),
            Values::Array(_) => vec![Argument::Read("p", self.drives.values.count().max(1))],
        }
    }

    pub(super) fn body(&self) -> Body {
        Body::new(self.language, self.prefix)
    }

    /// Functions that take and give arrays.
    pub(super) fn wrappers(&self) -> String {
        let mut parts = Vec::new();
        for loaded in self.loads() {
            let suffix = suffix(loaded);
            let mut of_motion = vec![(
                format!("joint_torque{suffix}"),
                "Torques at the joints that move the bodies: inertia, Coriolis, gravity.",
            )];
            if self.drives.is_memoryless() {
                of_motion.push((
                    format!("motor_torque{suffix}"),
                    "Torques at the motors, at joint scale: what moves the joints, losses, rotor inertia, friction, offsets.",
                ));
                if self.has_currents() {
                    of_motion.push((
                        format!("motor_current{suffix}"),
                        "Currents of the motors, A.",
                    ));
                }
            }
            for (function, words) in of_motion {
                parts.push(format!(
                    "def {function}(q, dq, ddq):\n    \"\"\"{words}\n\n    Arrays of one entry per joint, or of joints by \
                     samples.\n    \"\"\"\n    q, dq, ddq = (np.asarray(x, dtype=float) for x in (q, dq, ddq))\n    \
                     if q.ndim == 2:\n        columns = [{function}(q[:, k], dq[:, k], ddq[:, k]) for k in \
                     range(q.shape[1])]\n        return np.stack(columns, axis=1)\n    out = [0.0] * JOINTS\n    \
                     _{function}(q.tolist(), dq.tolist(), ddq.tolist(), out)\n    return np.array(out)\n"
                ));
            }
            parts.push(format!(
                "def inverse_step{suffix}(state, dt, q, dq, ddq):\n    \"\"\"The signals that the next sample of a motion \
                 takes, dt after the one before.\n\n    `state` is np.zeros(STATES) at the start and goes on by one \
                 sample.\n    \"\"\"\n    held, out = list(state), [0.0] * JOINTS\n    \
                 _inverse_step{suffix}(held, float(dt), list(q), list(dq), list(ddq), out)\n    state[:] = held\n    \
                 return np.array(out)\n"
            ));
        }
        parts.push(
            "def drive_step(state, dt, signal, q, dq, ddq):\n    \"\"\"Torques of the drives on the links, from the signals \
             of the motors and the motion of the links.\n\n    `state` is np.zeros(STATES) at the start and goes on by one \
             step. Accelerations act on rotors alone.\n    \"\"\"\n    held, out = list(state), [0.0] * JOINTS\n    \
             _drive_step(held, float(dt), list(signal), list(q), list(dq), list(ddq), out)\n    state[:] = held\n    \
             return np.array(out)\n"
                .to_string(),
        );
        parts.join("\n\n")
    }
}
