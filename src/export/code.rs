//! Inverse dynamics of the robot as source code: one straight line of arithmetic for the bodies, then the
//! laws of the drives. No loop, no memory but the stack, no dependency.

use crate::export::language::{Language, number};
use crate::export::law::{formula, left_out};
use crate::export::regroup::minimal;
use crate::export::symbol::{Symbol, record};
use crate::export::tape::{Operation, Tape};
use crate::export::{Export, File};
use crate::outcome::machine::{Machine, MachineJoint};
use crate::outcome::run::VERSION;
use crate::robot::newton_euler::NewtonEuler;
use crate::robot::scalar::Scalar;
use crate::robot::tree::Tree;
use nalgebra::{DMatrix, Rotation3};

/// Entries of rotations and axes this close to −1, 0 or 1 are those: rounding of a sine of π/2 would keep
/// operations alive that change no torque.
const ROUNDING: f64 = 1e-15;

/// The code of a machine in a language; C has a header beside it.
pub fn write(machine: &Machine, (name, language): (&str, Language)) -> Export {
    let prefix = identifier(name);
    let writer = Writer {
        machine,
        language,
        prefix: &prefix,
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
    let notes = machine.joints.iter().filter_map(|joint| {
        let ids = left_out(joint);
        (!ids.is_empty()).then(|| format!("{}: no code for {}", joint.name, ids.join(", ")))
    });
    Export {
        files,
        notes: notes.collect(),
    }
}

/// The name with everything that no identifier may hold replaced.
fn identifier(name: &str) -> String {
    let clean = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let text: String = name.chars().map(clean).collect();
    if text.starts_with(|c: char| c.is_ascii_digit()) {
        format!("robot_{text}")
    } else {
        text
    }
}

/// A name as it may stand in a comment, which it can neither end nor open, on one line.
fn in_comment(name: &str) -> String {
    let plain = |c: char| if c.is_control() { ' ' } else { c };
    let line: String = name.chars().map(plain).collect();
    line.replace("*/", "* /").replace("/*", "/ *")
}

struct Writer<'a> {
    machine: &'a Machine,
    language: Language,
    prefix: &'a str,
}

impl Writer<'_> {
    fn source(&self, name: &str) -> String {
        let mut text = self.opening(name);
        for loaded in self.loads() {
            let suffix = if loaded { "_with_load" } else { "" };
            text.push('\n');
            text.push_str(&self.bodies(loaded, suffix));
            text.push('\n');
            text.push_str(&self.drives(suffix));
            if self.has_currents() {
                text.push('\n');
                text.push_str(&self.currents(suffix));
            }
        }
        text
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

    fn title(&self, name: &str) -> String {
        let name = in_comment(name);
        format!(
            "Inverse dynamics of {name}, written by exid {VERSION}: arrays have one entry per joint, rad, N·m\n\
             (m, N for sliding joints), in the order {}.",
            in_comment(&self.joint_names().join(", "))
        )
    }

    fn joint_names(&self) -> Vec<&str> {
        self.machine
            .joints
            .iter()
            .map(|j| j.name.as_str())
            .collect()
    }

    fn opening(&self, name: &str) -> String {
        let title = self.title(name);
        let helpers = self.language.helpers();
        match self.language {
            Language::Rust => {
                let title = title.replace('\n', "\n// ");
                let count = self.machine.joints.len();
                let names = self.joint_names();
                format!(
                    "// {title}\n\npub const JOINTS: usize = {count};\n\n\
                     pub const JOINT_NAMES: [&str; JOINTS] = {names:?};\n\n{helpers}"
                )
            }
            Language::C => format!(
                "/* {title} */\n\n#include \"{}.h\"\n#include <math.h>\n\n{helpers}",
                self.prefix
            ),
        }
    }

    fn header(&self, name: &str) -> String {
        let guard = self.prefix.to_uppercase();
        let mut text = format!(
            "/* {} */\n\n#ifndef {guard}_H\n#define {guard}_H\n\n#define {guard}_JOINTS {}\n",
            self.title(name),
            self.machine.joints.len()
        );
        for loaded in self.loads() {
            let suffix = if loaded { "_with_load" } else { "" };
            let currents = self.has_currents().then_some("motor_current");
            for function in ["joint_torque", "motor_torque"].into_iter().chain(currents) {
                let head = self
                    .language
                    .head(&format!("{function}{suffix}"), self.prefix);
                text.push_str(&format!("\n{head};\n"));
            }
        }
        text.push_str("\n#endif\n");
        text
    }

    fn function(&self, documentation: &[&str], name: &str, body: &str) -> String {
        let comment = self.language.documentation(documentation);
        let head = self.language.head(name, self.prefix);
        format!("{comment}{head} {{\n{body}}}\n")
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
        let mut body = self.language.touch().to_string();
        body.push_str(&self.straight_line(&tape, &torque));
        self.function(
            &["Torques at the joints that move the bodies: inertia, Coriolis, gravity."],
            &format!("joint_torque{suffix}"),
            &body,
        )
    }

    fn straight_line(&self, tape: &Tape, results: &[Symbol]) -> String {
        let positions: Vec<usize> = results.iter().map(|r| r.position()).collect();
        let n = self.machine.joints.len();
        let word = |k: usize| match tape.operation(k) {
            Operation::Constant(bits) => number(f64::from_bits(bits)),
            Operation::Input(k) => format!("{}[{}]", ["q", "dq", "ddq"][k / n], k % n),
            _ => format!("x{k}"),
        };
        let operand = |k: u32| {
            let word = word(k as usize);
            if word.starts_with('-') {
                format!("({word})")
            } else {
                word
            }
        };
        let mut text = String::new();
        for k in tape.needed(&positions) {
            let value = match tape.operation(k) {
                Operation::Constant(_) | Operation::Input(_) => continue,
                Operation::Sine(a) => self.language.sine(&operand(a)),
                Operation::Cosine(a) => self.language.cosine(&operand(a)),
                Operation::Negative(a) => format!("-{}", operand(a)),
                Operation::Sum(a, b) => format!("{} + {}", operand(a), operand(b)),
                Operation::Difference(a, b) => format!("{} - {}", operand(a), operand(b)),
                Operation::Product(a, b) => format!("{} * {}", operand(a), operand(b)),
            };
            text.push_str(&self.language.binding(&format!("x{k}"), &value));
        }
        for (joint, position) in positions.into_iter().enumerate() {
            text.push_str(&format!("    out[{joint}] = {};\n", word(position)));
        }
        text
    }

    /// `τ_mot = Vᵀ τ + Σ laws(m, ṁ, m̈)`, `m = V⁻¹ (q − offset)`.
    fn drives(&self, suffix: &str) -> String {
        let n = self.machine.joints.len();
        let coupling = match &self.machine.coupling {
            Some(rows) => DMatrix::from_fn(n, n, |r, c| rows[r][c]),
            None => DMatrix::identity(n, n),
        };
        // The model of the fit has refused couplings without inverse.
        let inverse = coupling
            .clone()
            .try_inverse()
            .unwrap_or_else(|| coupling.clone());
        let mut body = self.language.touch().to_string();
        body.push_str(
            &self
                .language
                .pass_on(&format!("joint_torque{suffix}"), self.prefix),
        );
        if self.machine.coupling.is_some() {
            body.push_str(&self.language.copy(self.prefix));
        }
        for (j, joint) in self.machine.joints.iter().enumerate() {
            let transmitted = match self.machine.coupling {
                Some(_) => combination(coupling.column(j).iter(), "tau"),
                None => format!("out[{j}]"),
            };
            let row: Vec<f64> = inverse.row(j).iter().copied().collect();
            body.push_str(&self.motor(joint, (j, &row), &transmitted));
        }
        self.function(
            &[
                "Torques at the motors, at joint scale: what moves the joints, rotor inertia, friction, offsets.",
            ],
            &format!("motor_torque{suffix}"),
            &body,
        )
    }

    fn motor(&self, joint: &MachineJoint, (j, row): (usize, &[f64]), transmitted: &str) -> String {
        let formulas: Vec<String> = joint.effects.iter().filter_map(formula).collect();
        if formulas.is_empty() && self.machine.coupling.is_none() {
            return String::new();
        }
        let sum = formulas.join(" + ");
        let uses = |word: &str| {
            let is_letter = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
            sum.split(|c: char| !is_letter(c))
                .any(|found| found == word)
        };
        let width = joint.value("coulomb_friction", "w").unwrap_or(0.0);
        let mut block = String::new();
        let bind = |name: &str, value: &str| format!("    {}", self.language.binding(name, value));
        if uses("v") || uses("s") {
            block.push_str(&bind("v", &combination(row.iter(), "dq")));
        }
        if uses("a") {
            block.push_str(&bind("a", &combination(row.iter(), "ddq")));
        }
        if uses("s") {
            block.push_str(&bind("s", &format!("sign(v, {})", number(width))));
        }
        block.push_str(&bind("t", transmitted));
        let whole = std::iter::once("t".to_string()).chain(formulas);
        let whole: Vec<String> = whole.collect();
        format!(
            "    {{\n{block}        out[{j}] = {};\n    }}\n",
            whole.join(" + ")
        )
    }

    /// `i = τ_mot / (k · gain)`.
    fn currents(&self, suffix: &str) -> String {
        let mut body = self
            .language
            .pass_on(&format!("motor_torque{suffix}"), self.prefix);
        for (j, joint) in self.machine.joints.iter().enumerate() {
            let constant = joint.torque_constant.unwrap_or(1.0);
            let gain = joint.value("drive_gain", "gain").unwrap_or(1.0);
            let factor = number(1.0 / (constant * gain));
            body.push_str(&format!("    out[{j}] *= {factor};\n"));
        }
        self.function(
            &["Currents of the motors, A."],
            &format!("motor_current{suffix}"),
            &body,
        )
    }
}

/// `factor·series[k] + ...` without the terms that are zero.
fn combination<'a>(factors: impl Iterator<Item = &'a f64>, series: &str) -> String {
    let term = |(k, factor): (usize, &f64)| match *factor {
        0.0 => None,
        1.0 => Some(format!("{series}[{k}]")),
        factor => Some(format!("{} * {series}[{k}]", number(factor))),
    };
    let terms: Vec<String> = factors.enumerate().filter_map(term).collect();
    if terms.is_empty() {
        number(0.0)
    } else {
        terms.join(" + ")
    }
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
