//! Bodies as one straight line of arithmetic.

use crate::chain::effect::expression::{Expression, Function};
use crate::export::code::writer::{Writer, name};
use crate::export::program::{Body, Head, Visibility};
use crate::export::regroup::minimal;
use crate::export::symbol::{Symbol, record};
use crate::export::tape::{Operation, Tape};
use crate::linalg::lanes::scalar::Scalar;
use crate::robot::newton_euler::NewtonEuler;
use crate::robot::tree::Tree;
use nalgebra::Rotation3;

/// Entries of rotations and axes this close to −1, 0 or 1 are those: rounding of a sine of π/2 would keep
/// operations alive that change no torque.
pub(super) const ROUNDING: f64 = 1e-15;

/// The same robot, its rotations and axes free of rounding around −1, 0 and 1.
pub(super) fn without_rounding(tree: &Tree) -> Tree {
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

impl Writer<'_> {
    /// `τ = Y(q, q̇, q̈) π` as a straight line.
    pub(super) fn bodies(&self, loaded: bool, suffix: &str) -> String {
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
        body.function(&Head {
            name: &format!("joint_torque{suffix}"),
            documentation: "Torques at the joints that move the bodies: inertia, Coriolis, gravity.",
            arguments: &self.motion_arguments(),
            visibility: Visibility::Public,
        })
    }

    pub(super) fn straight_line(&self, tape: &Tape, results: &[Symbol], body: &mut Body) {
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
}
