//! The robot as source code: inverse dynamics, from motion to the signal of the motors, and the law of the drives
//! forwards, from signal and motion of the joints to the torques that move the links.
//!
//! Bodies are one straight line of arithmetic. What the drives remember stands in one array of numbers, all zero at the
//! start: time, whether a step was made, bristles, lags of links with the two values before, signals on their way. With
//! lag both directions solve the same equations, those of the backward difference of second order, for its value at the
//! end of the step.

use crate::chain::effect::Catalogue;
use crate::chain::effect::expression::{Expression, Function, Variable};
use crate::export::drive::Drives;
use crate::export::error::ExportError;
use crate::export::language::Language;
use crate::export::program::{Argument, Body, Head, Visibility};
use crate::export::regroup::minimal;
use crate::export::symbol::{Symbol, record};
use crate::export::tape::{Operation, Tape};
use crate::export::{Export, File};
use crate::outcome::machine::Machine;
use crate::outcome::provenance::VERSION;
use crate::robot::newton_euler::NewtonEuler;
use crate::robot::scalar::Scalar;
use crate::robot::tree::Tree;
use nalgebra::{DVectorView, Rotation3};

/// Entries of rotations and axes this close to −1, 0 or 1 are those: rounding of a sine of π/2 would keep
/// operations alive that change no torque.
const ROUNDING: f64 = 1e-15;

/// Steps of Newton's method, and halvings of one that does not come closer.
const STEPS: usize = 60;
const HALVINGS: usize = 30;

/// Change of a lag by which its slopes are measured, as a share of the step's duration: a speed of this size.
const LAG_SHARE: f64 = 1e-6;

/// Change of a torque by which slopes are measured, N·m (N): the laws are straight on either side of zero.
const TORQUE_CHANGE: f64 = 1e-3;

/// Shortest step for which a line of delayed signals is long enough, s.
pub const SHORTEST_STEP: f64 = 1e-4;

/// Entries of the state in front of those of effects: the time, and whether a step was made.
const CLOCK: usize = 2;

/// The code of a machine in a language; C has a header beside it.
///
/// # Errors
/// Effects or parameters that the result does not hold.
pub fn write(
    (machine, catalogue): (&Machine, &Catalogue),
    (name, language): (&str, Language),
) -> Result<Export, ExportError> {
    let prefix = identifier(name);
    let drives = Drives::of(machine, catalogue)?;
    let layout = Layout::of(&drives);
    let writer = Writer {
        machine,
        language,
        prefix: &prefix,
        drives: &drives,
        layout: &layout,
    };
    let mut files = vec![File {
        name: format!("{prefix}.{}", language.extension()),
        text: writer.source(name),
    }];
    if language == Language::C {
        files.push(File {
            name: format!("{prefix}.h"),
            text: writer.header(name),
        });
    }
    Ok(Export {
        files,
        notes: notes(machine, &drives),
    })
}

/// What a user of the code has to know of the drives.
pub fn notes(machine: &Machine, drives: &Drives) -> Vec<String> {
    let mut notes = Vec::new();
    for (joint, drive) in machine.joints.iter().zip(&drives.drives) {
        let name = &joint.name;
        if drive.delay > 0.0 {
            notes.push(format!(
                "{name}: the recorded signal was {} s late: what inverse_step returns is read that much later, and \
                 drive_step takes the signal as it acts at the motor, not as it was recorded",
                drive.delay
            ));
        }
        if drive.delay < 0.0 {
            notes.push(format!(
                "{name}: the signal acts {} s after it is given: drive_step holds it back, in steps of {SHORTEST_STEP} s \
                 and more of one length; inverse_step returns what is to be given that much earlier",
                -drive.delay
            ));
        }
    }
    notes
}

/// The source of a plugin: the drives in C, and `glue` that calls them, with its change of speed for slopes.
///
/// # Errors
/// Effects or parameters that the result does not hold.
pub fn plugin(
    (machine, catalogue): (&Machine, &Catalogue),
    (name, glue, change): (&str, &str, f64),
) -> Result<String, ExportError> {
    let drives = Drives::of(machine, catalogue)?;
    let layout = Layout::of(&drives);
    let writer = Writer {
        machine,
        language: Language::C,
        prefix: "exid",
        drives: &drives,
        layout: &layout,
    };
    let mut parts = vec![format!(
        "/* Drives of {}, written by exid {VERSION}, as an actuator plugin of MuJoCo. Compile and load it:\n\n   \
         MJ=$(python -c \"import mujoco, os; print(os.path.dirname(mujoco.__file__))\")\n   \
         cc -O2 -shared -fPIC -I$MJ/include exid_drive.c -o libexid_drive.so -L$MJ \
         -l:$(basename $MJ/libmujoco.so.?*) -lm\n   \
         python -c \"import mujoco; mujoco.mj_loadPluginLibrary('./libexid_drive.so')\" */\n\n\
         #include <math.h>\n#include <mujoco/mujoco.h>\n\n#define EXID_JOINTS {}\n#define EXID_STATES {}\n\
         #define EXID_SPEED_CHANGE {change:?}\n\n{}",
        in_comment(name),
        writer.joints(),
        layout.size,
        Language::C.helpers()
    )];
    if !writer.members().is_empty() {
        parts.push(writer.drive_miss());
    }
    parts.push(writer.drive_step());
    parts.push(glue.to_string());
    Ok(parts.join("\n"))
}

/// The name with everything that no identifier may hold replaced.
fn identifier(name: &str) -> String {
    let clean = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let text: String = name.chars().map(clean).collect();
    if text.is_empty() || text.starts_with(|c: char| c.is_ascii_digit()) {
        format!("robot_{text}")
    } else {
        text
    }
}

/// A name as it may stand in a comment of any language, which it can neither end nor open, on one line.
pub fn in_comment(name: &str) -> String {
    let plain = |c: char| match c {
        '"' => '\'',
        '\\' => '/',
        c if is_invisible(c) => ' ',
        c => c,
    };
    let line: String = name.chars().map(plain).collect();
    line.replace("*/", "* /")
        .replace("/*", "/ *")
        .replace("??", "? ?")
}

/// Ends of lines, and marks that turn the direction of a text around.
fn is_invisible(c: char) -> bool {
    let turns = matches!(c, '\u{200e}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}');
    c.is_control() || turns
}

/// A name as a text of the language.
fn quoted(name: &str) -> String {
    let of = |c: char| match c {
        '"' => "\\\"".to_string(),
        '\\' => "\\\\".to_string(),
        c if is_invisible(c) => " ".to_string(),
        c => c.to_string(),
    };
    let inner: String = name.chars().map(of).collect();
    format!("\"{inner}\"")
}

/// Where the state of each law stands.
#[derive(Debug)]
struct Layout {
    /// Of each joint's motor laws: state and velocity before, where the law has one.
    bristles: Vec<Vec<Option<usize>>>,
    /// Of each joint: lag, the lag before it, and the rates of both.
    lags: Vec<Option<usize>>,
    /// Of each joint: signals on their way, the newest first, and their number.
    lines: Vec<Option<(usize, usize)>>,
    size: usize,
}

impl Layout {
    fn of(drives: &Drives) -> Self {
        let mut size = CLOCK;
        let mut take = |count: usize| {
            size += count;
            size - count
        };
        let bristles = drives.drives.iter().map(|drive| {
            let laws = drive.motor.iter();
            laws.map(|law| (!law.states.is_empty()).then(|| take(law.states.len() + 1)))
                .collect()
        });
        let bristles = bristles.collect();
        let lags = drives.drives.iter();
        let lags = lags
            .map(|drive| drive.contact.as_ref().map(|_| take(4)))
            .collect();
        let lines = drives.drives.iter().map(|drive| {
            let count = (-drive.delay / SHORTEST_STEP).ceil() as usize + 2;
            (drive.delay < 0.0).then(|| (take(count), count))
        });
        let lines = lines.collect();
        Self {
            bristles,
            lags,
            lines,
            size,
        }
    }
}

/// What moves in the places of a law's variables.
struct Moving<'a> {
    joint: usize,
    /// Of the motor: `m`, `v`, `a` and `s` with the joint's number.
    sign: &'a str,
}

struct Writer<'a> {
    machine: &'a Machine,
    language: Language,
    prefix: &'a str,
    drives: &'a Drives,
    layout: &'a Layout,
}

fn name(text: impl Into<String>) -> Expression {
    Expression::name(text)
}

impl Writer<'_> {
    fn joints(&self) -> usize {
        self.machine.joints.len()
    }

    fn source(&self, title: &str) -> String {
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
    fn loads(&self) -> Vec<bool> {
        match self.machine.payload {
            Some(_) => vec![false, true],
            None => vec![false],
        }
    }

    fn has_currents(&self) -> bool {
        let mut joints = self.machine.joints.iter();
        joints.all(|joint| joint.torque_constant.is_some())
    }

    fn title(&self, title: &str) -> String {
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

    fn opening(&self, title: &str) -> String {
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

    fn header(&self, title: &str) -> String {
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

    fn motion_arguments(&self) -> Vec<Argument> {
        let n = self.joints();
        vec![
            Argument::Read("q", n),
            Argument::Read("dq", n),
            Argument::Read("ddq", n),
            Argument::Written("out", n),
        ]
    }

    fn inverse_arguments(&self) -> Vec<Argument> {
        let mut arguments = vec![
            Argument::Written("state", self.layout.size),
            Argument::Scalar("dt"),
        ];
        arguments.extend(self.motion_arguments());
        arguments
    }

    fn drive_arguments(&self) -> Vec<Argument> {
        let mut arguments = vec![
            Argument::Written("state", self.layout.size),
            Argument::Scalar("dt"),
            Argument::Read("signal", self.joints()),
        ];
        arguments.extend(self.motion_arguments());
        arguments
    }

    fn function(
        &self,
        body: Body,
        (name, documentation): (&str, &str),
        (arguments, visibility): (&[Argument], Visibility),
    ) -> String {
        body.function(&Head {
            name,
            documentation,
            arguments,
            visibility,
        })
    }

    fn body(&self) -> Body {
        Body::new(self.language, self.prefix)
    }

    /// `τ = Y(q, q̇, q̈) π` as a straight line.
    fn bodies(&self, loaded: bool, suffix: &str) -> String {
        let tree = without_rounding(&self.machine.tree(loaded));
        // The model has no drives and no couplings, so that nothing can be wrong with it; the bodies as
        // they are give the same torques.
        let parameters = minimal(&tree).unwrap_or_else(|_| tree.parameters());
        let n = tree.len();
        let (torque, tape) = record(|| {
            let series = |first: usize| -> Vec<Symbol> {
                (0..n).map(|k| Symbol::input(first * n + k)).collect()
            };
            let (q, dq, ddq) = (series(0), series(1), series(2));
            let mut torque = vec![Symbol::constant(0.0); n];
            NewtonEuler::new(&tree).torque(&tree, &parameters, [&q, &dq, &ddq], &mut torque);
            torque
        });
        let mut body = self.body();
        self.straight_line(&tape, &torque, &mut body);
        self.function(
            body,
            (
                &format!("joint_torque{suffix}"),
                "Torques at the joints that move the bodies: inertia, Coriolis, gravity.",
            ),
            (&self.motion_arguments(), Visibility::Public),
        )
    }

    fn straight_line(&self, tape: &Tape, results: &[Symbol], body: &mut Body) {
        let positions: Vec<usize> = results.iter().map(|r| r.position()).collect();
        let n = self.joints();
        let word = |k: usize| match tape.operation(k) {
            Operation::Constant(bits) => Expression::Number(f64::from_bits(bits)),
            Operation::Input(k) => name(format!("{}[{}]", ["q", "dq", "ddq"][k / n], k % n)),
            _ => name(format!("x{k}")),
        };
        let at = |k: u32| word(k as usize);
        for k in tape.needed(&positions) {
            let value = match tape.operation(k) {
                Operation::Constant(_) | Operation::Input(_) => continue,
                Operation::Sine(a) => at(a).call(Function::Sine),
                Operation::Cosine(a) => at(a).call(Function::Cosine),
                Operation::Negative(a) => -at(a),
                Operation::Sum(a, b) => at(a) + at(b),
                Operation::Difference(a, b) => at(a) - at(b),
                Operation::Product(a, b) => at(a) * at(b),
            };
            body.bind(&format!("x{k}"), &value);
        }
        for (joint, position) in positions.into_iter().enumerate() {
            body.assign(&format!("out[{joint}]"), &word(position));
        }
    }

    /// `m = V⁻¹ (q − offset)` and its derivatives, of the arrays with these names.
    fn bind_motors(&self, body: &mut Body, series: [&str; 3]) {
        for j in 0..self.joints() {
            let row: Vec<f64> = self.drives.inverse.row(j).iter().copied().collect();
            let shift: f64 = row
                .iter()
                .zip(&self.drives.offset)
                .map(|(w, o)| w * o)
                .sum();
            let position = combination(&row, |k| name(format!("{}[{k}]", series[0])));
            let position = match shift {
                0.0 => position,
                shift => position - shift,
            };
            body.bind(&format!("m{j}"), &position);
            for (letter, series) in ["v", "a"].into_iter().zip(&series[1..]) {
                let value = combination(&row, |k| name(format!("{series}[{k}]")));
                body.bind(&format!("{letter}{j}"), &value);
            }
            let width = self.language.number(self.drives.drives[j].width);
            body.bind(&format!("s{j}"), &name(format!("sign(v{j}, {width})")));
        }
    }

    /// A law with the motion of a motor in the places of its variables.
    fn of_motor(&self, law: &Expression, moving: &Moving<'_>, state: &str) -> Expression {
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
    fn bind_states(&self, body: &mut Body, j: usize) {
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
    fn keep_states(&self, body: &mut Body, j: usize) {
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
    fn laws(&self, j: usize) -> Option<Expression> {
        let moving = Moving {
            joint: j,
            sign: &format!("s{j}"),
        };
        let laws = self.drives.drives[j].motor.iter().enumerate();
        let laws = laws.map(|(k, law)| self.of_motor(&law.torque, &moving, &format!("z{j}_{k}")));
        laws.reduce(|sum, law| sum + law)
    }

    /// What the signal of a motor shows beyond its torque.
    fn shown(&self, j: usize) -> Option<Expression> {
        let moving = Moving {
            joint: j,
            sign: &format!("s{j}"),
        };
        let laws = self.drives.drives[j].signal.iter();
        let laws = laws.map(|law| self.of_motor(law, &moving, ""));
        laws.reduce(|sum, law| sum + law)
    }

    /// `τ_in` of the torque `load{j}`.
    fn before_losses(&self, j: usize) -> Expression {
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
    fn at_joint(&self, j: usize, [positions, velocities]: [&str; 2]) -> Option<Expression> {
        let velocity = format!("{velocities}[{j}]");
        let width = self.language.number(self.drives.drives[j].width);
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
    fn assign_motor_torques(&self, body: &mut Body, motion: [&str; 2]) {
        for j in 0..self.joints() {
            if let Some(laws) = self.at_joint(j, motion) {
                let sum = name(format!("tau[{j}]")) + laws;
                body.assign(&format!("tau[{j}]"), &sum);
            }
        }
        for j in 0..self.joints() {
            let column = self.drives.coupling.column(j);
            body.bind(
                &format!("load{j}"),
                &of_column(column, |k| name(format!("tau[{k}]"))),
            );
            self.bind_states(body, j);
            let mut torque = self.before_losses(j);
            if let Some(laws) = self.laws(j) {
                torque = torque + laws;
            }
            body.assign(&format!("out[{j}]"), &torque);
        }
    }

    fn motor_torque(&self, suffix: &str) -> String {
        let mut body = self.body();
        body.array("tau", self.joints());
        body.call(&format!("joint_torque{suffix}"), &["q", "dq", "ddq", "tau"]);
        self.bind_motors(&mut body, ["q", "dq", "ddq"]);
        self.assign_motor_torques(&mut body, ["q", "dq"]);
        self.function(
            body,
            (
                &format!("motor_torque{suffix}"),
                "Torques at the motors, at joint scale: what moves the joints, losses, rotor inertia, friction, offsets.",
            ),
            (&self.motion_arguments(), Visibility::Public),
        )
    }

    fn motor_current(&self, suffix: &str) -> String {
        let mut body = self.body();
        body.call(&format!("motor_torque{suffix}"), &["q", "dq", "ddq", "out"]);
        self.become_signals(&mut body);
        self.function(
            body,
            (
                &format!("motor_current{suffix}"),
                "Currents of the motors, A.",
            ),
            (&self.motion_arguments(), Visibility::Public),
        )
    }

    /// Motor torques in `out` become what is read: `s = τ_mot / (k · gain)`, or the current of a polynomial.
    fn become_signals(&self, body: &mut Body) {
        for (j, drive) in self.drives.drives.iter().enumerate() {
            let out = format!("out[{j}]");
            if let Some(shown) = self.shown(j) {
                body.assign(&out, &(name(&out) + shown));
            }
            if drive.factor != 1.0 {
                body.assign(&out, &(name(&out) / drive.factor));
            }
            let Some(branch) = &drive.current else {
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
            let bound = Expression::Number(drive.threshold.max(0.0));
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
    }

    fn members(&self) -> Vec<usize> {
        self.drives.lagging()
    }

    /// Binds the time and the rate at which a backward difference weighs the value at the end of the step.
    fn bind_clock(&self, body: &mut Body) {
        let began = |then: Expression| name("state[1]").if_less(0.5, 0.0, then);
        body.bind("now", &began(name("state[0]") + name("dt")));
        body.bind("rate", &began(Expression::Number(1.5) / name("dt")));
    }

    /// Binds `lag{j}`, `dlag{j}` and `ddlag{j}` of a member whose lag has this name.
    fn bind_lag(&self, body: &mut Body, (j, lag): (usize, &str)) {
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
    fn contact(&self, j: usize) -> Expression {
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
    fn keep_lag(&self, body: &mut Body, j: usize) {
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

    fn keep_clock(&self, body: &mut Body) {
        body.assign("state[0]", &name("now"));
        body.assign("state[1]", &Expression::Number(1.0));
    }

    /// The motion of the links, `lq`, `ldq`, `lddq`, from that of the encoders and the lags.
    fn move_links(&self, body: &mut Body, lags: impl Fn(usize) -> String) {
        let members = self.members();
        for series in ["lq", "ldq", "lddq"] {
            body.array(series, self.joints());
        }
        for (f, &j) in members.iter().enumerate() {
            self.bind_lag(body, (j, &lags(f)));
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

    fn miss_arguments(&self) -> Vec<Argument> {
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
    fn lag_miss(&self, suffix: &str) -> String {
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
        self.function(
            body,
            (
                &format!("lag_miss{suffix}"),
                "What resists the lags of links less what the links take.",
            ),
            (&self.miss_arguments(), Visibility::Private),
        )
    }

    /// Newton's method for `function(before.., x, r) = 0` with n unknowns, whose slopes are measured over `change`.
    fn newton(&self, body: &mut Body, (function, before): (&str, &[&str]), change: &[Expression]) {
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

    fn inverse_step(&self, suffix: &str) -> String {
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
            self.newton(&mut body, (&format!("lag_miss{suffix}"), &before), &change);
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
        self.function(
            body,
            (
                &format!("inverse_step{suffix}"),
                "The signals that the next sample of a motion takes, dt after the one before; state goes on by one sample.\n\
                 Begin with a state of zeros; the first sample is at time 0, whatever dt is.",
            ),
            (&self.inverse_arguments(), Visibility::Public),
        )
    }

    /// Binds `drive{j}`, the torque of each motor, from the signals in the array of this name.
    fn bind_driving(&self, body: &mut Body, signal: &str) {
        for (j, drive) in self.drives.drives.iter().enumerate() {
            let read = name(format!("{signal}[{j}]"));
            let torque = match &drive.current {
                Some(branch) => {
                    let size = body.bind(&format!("size{j}"), &read.clone().magnitude());
                    let Expression::Name(size) = size else {
                        continue;
                    };
                    read.call(Function::Signum) * with_current(&branch.torque, &size)
                }
                None => read,
            };
            let torque = match drive.factor {
                1.0 => torque,
                factor => torque * factor,
            };
            let torque = match self.shown(j) {
                Some(shown) => torque - shown,
                None => torque,
            };
            body.bind(&format!("drive{j}"), &torque);
        }
    }

    /// Torque that a motor takes for its load less what it gives, by lags of links and torques at the other joints.
    fn drive_miss(&self) -> String {
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
        self.function(
            body,
            ("drive_miss", "What the motors take less what they give, by lags of links and torques at the other joints."),
            (&self.drive_miss_arguments(), Visibility::Private),
        )
    }

    fn drive_miss_arguments(&self) -> Vec<Argument> {
        let n = self.joints();
        vec![
            Argument::Read("state", self.layout.size),
            Argument::Scalar("dt"),
            Argument::Read("signal", n),
            Argument::Read("q", n),
            Argument::Read("dq", n),
            Argument::Read("ddq", n),
            Argument::Read("x", n),
            Argument::Written("out", n),
        ]
    }

    /// Motors, joint torques `tau{j}` and loads where the links are at q and `x` holds lags and torques.
    fn bind_shaft(&self, body: &mut Body) {
        let members = self.members();
        for &j in &members {
            self.bind_lag(body, (j, &format!("x[{j}]")));
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
            let column = self.drives.coupling.column(j);
            let load = of_column(column, |k| name(format!("tau{k}")));
            body.bind(&format!("load{j}"), &load);
        }
    }

    fn drive_step(&self) -> String {
        let mut body = self.body();
        self.bind_clock(&mut body);
        body.array("acting", self.joints());
        for j in 0..self.joints() {
            body.assign(&format!("acting[{j}]"), &name(format!("signal[{j}]")));
            if let Some(line) = self.layout.lines[j] {
                self.hold_back(&mut body, (j, line));
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
        self.function(
            body,
            (
                "drive_step",
                "Torques of the drives on the links, from the signals of the motors and the motion of the links, dt after the\n\
                 step before; state goes on by one step. Begin with a state of zeros. Accelerations act on rotors alone: with\n\
                 rotors in the simulator (armature) give zeros.",
            ),
            (&self.drive_arguments(), Visibility::Public),
        )
    }

    /// The signal that was given a delay before.
    fn hold_back(&self, body: &mut Body, (j, (first, count)): (usize, (usize, usize))) {
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

    fn rigid_drive(&self, body: &mut Body) {
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
            let column = self.drives.inverse.column(j);
            let torque = of_column(column, |k| name(format!("load{k}")));
            body.assign(&format!("out[{j}]"), &torque);
        }
    }

    fn lagging_drive(&self, body: &mut Body) {
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
        let before = ["state", "dt", "acting", "q", "dq", "ddq"];
        self.newton(body, ("drive_miss", &before), &change);
        self.bind_shaft(body);
        for j in 0..n {
            body.assign(&format!("out[{j}]"), &name(format!("tau{j}")));
        }
    }

    /// Functions that take and give arrays.
    fn wrappers(&self) -> String {
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

fn suffix(loaded: bool) -> &'static str {
    if loaded { "_with_load" } else { "" }
}

fn of_parts(parts: usize) -> f64 {
    parts as f64
}

/// A formula of the current of this name.
fn with_current(of: &Expression, current: &str) -> Expression {
    of.replaced(&|e| match e {
        Expression::Variable(Variable::Current) => Some(name(current)),
        _ => None,
    })
}

/// `Σ factor · of(k)` without the terms that are zero.
fn combination(factors: &[f64], of: impl Fn(usize) -> Expression) -> Expression {
    let terms = factors
        .iter()
        .enumerate()
        .filter(|(_, factor)| **factor != 0.0);
    let terms = terms.map(|(k, factor)| match *factor {
        1.0 => of(k),
        factor => of(k) * factor,
    });
    terms
        .reduce(|sum, term| sum + term)
        .unwrap_or(Expression::Number(0.0))
}

fn of_column(column: DVectorView<'_, f64>, of: impl Fn(usize) -> Expression) -> Expression {
    let factors: Vec<f64> = column.iter().copied().collect();
    combination(&factors, of)
}

/// The same robot, its rotations and axes free of rounding around −1, 0 and 1.
fn without_rounding(tree: &Tree) -> Tree {
    let clean = |x: f64| {
        let whole = x.round();
        if (x - whole).abs() < ROUNDING {
            whole
        } else {
            x
        }
    };
    let mut joints = tree.joints().to_vec();
    for joint in &mut joints {
        joint.rotation = Rotation3::from_matrix_unchecked(joint.rotation.matrix().map(clean));
        joint.axis = joint.axis.map(clean);
    }
    Tree::new(tree.name(), tree.base(), joints).with_gravity(tree.gravity().into())
}
