//! `[drive]`: the motors, what is known of them, and the physics between motor and joint.

use crate::problem_file::context::Context;
use crate::problem_file::document::Node;
use crate::problem_file::error::{ProblemFileError, ValueFault};
use crate::problem_file::key::{Form, Key, Length, REQUIRED, Range};
use crate::problem_file::located::{Located, Named, PerJoint};
use crate::problem_file::reader::Reader;
use crate::problem_file::values;

/// Keys of `[drive]`.
#[rustfmt::skip]
pub(crate) const KEYS: &[Key] = &[
    Key { name: "torque_constant", form: Form::PerJoint(Range::Nonzero), unit: "N·m/A (N/A)", default: "none, as for signals that are torques", example: "[13.1, 13.0]", meaning: "Torque constant at the joint side: motor constant times ratio" },
    Key { name: "torque_constant_std", form: Form::PerJoint(Range::NonNegative), unit: "", default: "none: the constants are certain", example: "[0.05, 0.05]", meaning: "Relative standard deviations of the torque constants, or of the torques that the polynomials give; part of every interval" },
    Key { name: "current_polynomial", form: Form::List(&Form::List(&Form::Number(Range::Finite), Length::Exactly(4)), Length::Any), unit: "N·m/A^k (N/A^k)", default: "none", example: "[[0.0, 185.0, 0.25, -0.012]]", meaning: "Instead of torque_constant: torque at the joint side in powers of the current, sign(i)·(c0 + c1·|i| + c2·i² + c3·|i|³)" },
    Key { name: "rotor_inertia", form: Form::PerJoint(Range::NonNegative), unit: "kg·m² (kg)", default: "none; estimated if \"rotor_inertia\" is among the effects", example: "[1.40, 1.50]", meaning: "Inertia of rotor and gear, reflected to the joint" },
    Key { name: "ratio", form: Form::PerJoint(Range::Nonzero), unit: "", default: "none", example: "[32.0, -33.5]", meaning: "Motor turns per joint turn, signed" },
    Key { name: "offset", form: Form::PerJoint(Range::Finite), unit: "rad (m)", default: "none", example: "[0.0, 0.01]", meaning: "Joint position where the motor stands at zero: q = V·(q_enc / ratio) + offset" },
    Key { name: "coupling", form: Form::List(&Form::List(&Form::Number(Range::Finite), Length::Any), Length::Any), unit: "", default: "the identity", example: "[[1.0, 0.0], [0.0093, 1.0]]", meaning: "V, a square matrix by rows: joint speeds = V·(motor speeds / ratio)" },
    Key { name: "effects", form: Form::List(&Form::Effect, Length::Distinct), unit: "", default: "none", example: "[\"coulomb_friction\", \"viscous_friction\"]", meaning: "Physics in the model, for all joints; `exid effects` lists it" },
    Key { name: "effects_of", form: Form::Named(&Form::List(&Form::Effect, Length::Distinct)), unit: "", default: "none", example: "{ a5 = [\"coulomb_friction\"] }", meaning: "What replaces the list of effects on single joints" },
    Key { name: "values", form: Form::Named(&Form::Number(Range::Finite)), unit: "each parameter's own", default: "none", example: "{ \"a5.coulomb_friction.w\" = 0.004 }", meaning: "Parameters of the model with known values" },
    Key { name: "shared", form: Form::List(&Form::Table(SHARED_KEYS), Length::Any), unit: "", default: "none", example: "", meaning: "Joints with motors of one type, and the effects whose parameters are the same on all of them" },
    Key { name: "rotors", form: Form::NamedTables(ROTOR_KEYS), unit: "", default: "none", example: "", meaning: "Spinning part of a joint's motor, which a base wrench feels" },
];

/// Keys of `[[drive.shared]]`.
#[rustfmt::skip]
pub(crate) const SHARED_KEYS: &[Key] = &[
    Key { name: "joints", form: Form::List(&Form::Text, Length::SeveralDistinct), unit: "", default: REQUIRED, example: "[\"a4\", \"a5\", \"a6\"]", meaning: "Two joints or more whose motors are of one type" },
    Key { name: "effects", form: Form::List(&Form::Effect, Length::SomeDistinct), unit: "", default: "none: every joint has its own parameters, and what could be shared is proposed", example: "[\"coulomb_friction\", \"viscous_friction\"]", meaning: "Effects whose parameters are one unknown for all of the joints; the recordings are asked whether they refuse that" },
    Key { name: "separate", form: Form::List(&Form::Text, Length::Distinct), unit: "", default: "none", example: "[\"torque_ripple.phase\"]", meaning: "Parameters of these effects that every joint has for itself" },
];

/// Keys of an entry of `[drive.rotors]`.
#[rustfmt::skip]
pub(crate) const ROTOR_KEYS: &[Key] = &[
    Key { name: "link", form: Form::Text, unit: "", default: REQUIRED, example: "\"link2\"", meaning: "Link or fixed frame that carries the motor" },
    Key { name: "axis", form: Form::List(&Form::Number(Range::Finite), Length::Exactly(3)), unit: "", default: REQUIRED, example: "[0.0, 0.0, 1.0]", meaning: "Axis about which it spins where the motor turns forwards, in that frame" },
    Key { name: "inertia", form: Form::Number(Range::NonNegative), unit: "kg·m²", default: REQUIRED, example: "0.0002", meaning: "Its own inertia about its axis, at the motor side" },
];

/// Coefficients of one joint's torque, N·m at the joint side, in powers of the current |i|, A:
/// sign(i)·(c0 + c1·|i| + c2·|i|² + c3·|i|³).
pub type CurrentPolynomial = [f64; 4];

/// The table `[drive]`. Every list has one value per joint, in the order of the joints, and
/// belongs to the motor with that index; a single number holds for every joint.
#[derive(Debug, Clone)]
pub struct DriveTable {
    /// How current gives torque. Default: none, as for signals that are torques.
    pub current_law: Option<CurrentLaw>,
    /// Relative standard deviations of the torque constants, or of the torques that the polynomials give, not negative.
    /// Default: none, they are certain.
    pub torque_constant_std: Option<Located<PerJoint>>,
    /// Reflected inertia of rotor and gear at the joint side, kg·m² (kg), not negative.
    /// Default: none; estimated if `rotor_inertia` is among the effects.
    pub rotor_inertia: Option<Located<PerJoint>>,
    /// Motor turns per joint turn, signed, not zero. Default: none.
    pub ratio: Option<Located<PerJoint>>,
    /// q = V·(q_enc / ratio) + offset, rad (m). Default: none.
    pub offset: Option<Located<PerJoint>>,
    /// V, rows of a square matrix without unit: joint speeds = V·(motor speeds / ratio).
    /// Default: none, the identity.
    pub coupling: Option<Located<Vec<Vec<f64>>>>,
    /// Physics in the model, for all joints. Default: none.
    pub effects: Vec<Located<String>>,
    /// Per joint, what replaces `effects`. Default: none.
    pub effects_of: Vec<Named<Vec<Located<String>>>>,
    /// Parameters of the model with known values, in their own units. Default: none.
    pub values: Vec<Named<f64>>,
    /// Joints with motors of one type. Default: none.
    pub shared: Vec<SharedTable>,
    /// Spinning parts of motors, by joint, which a base wrench feels. Default: none.
    pub rotors: Vec<Named<RotorTable>>,
}

/// One table `[[drive.shared]]`.
#[derive(Debug, Clone)]
pub struct SharedTable {
    /// Two joints or more whose motors are of one type.
    pub joints: Located<Vec<Located<String>>>,
    /// Effects whose parameters are the same on all of them. Default: none, what could be shared is proposed.
    pub effects: Vec<Located<String>>,
    /// `<effect>.<parameter>`: what every joint has for itself. Default: none.
    pub separate: Vec<Located<String>>,
}

/// An entry of `[drive.rotors]`.
#[derive(Debug, Clone, PartialEq)]
pub struct RotorTable {
    /// The link or fixed frame that carries the motor.
    pub link: String,
    /// Axis about which it spins where the motor turns forwards, in that frame; not zero.
    pub axis: [f64; 3],
    /// The spinning part's own inertia about its axis, kg·m², at the motor side, not negative.
    pub inertia: f64,
}

/// How current gives torque.
#[derive(Debug, Clone)]
pub enum CurrentLaw {
    /// Torque constant at the joint side, N·m/A (N/A), not zero.
    Constant(Located<PerJoint>),
    /// One polynomial per joint.
    Polynomial(Located<Vec<CurrentPolynomial>>),
}

impl DriveTable {
    pub(super) fn from_node(node: &Node, context: &Context) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, KEYS)?;
        let effects = |n: &Node| values::effects(n, context);
        Ok(Self {
            current_law: current_law(&reader)?,
            torque_constant_std: reader
                .optional("torque_constant_std", values::per_joint_non_negative)?,
            rotor_inertia: reader.optional("rotor_inertia", values::per_joint_non_negative)?,
            ratio: reader.optional("ratio", values::per_joint_nonzero)?,
            offset: reader.optional("offset", values::per_joint_finite)?,
            coupling: reader.optional("coupling", square_matrix)?,
            effects: reader.list("effects", effects)?,
            effects_of: reader.named("effects_of", effects)?,
            values: reader.named("values", values::finite)?,
            shared: reader
                .tables("shared")?
                .iter()
                .map(|table| shared(table, context))
                .collect::<Result<_, _>>()?,
            rotors: reader.named("rotors", rotor)?,
        })
    }
}

fn shared(node: &Node, context: &Context) -> Result<SharedTable, ProblemFileError> {
    let reader = Reader::open(node, SHARED_KEYS)?;
    let joints = |n: &Node| {
        let joints = values::names(n, "a list of joints")?;
        match joints.len() {
            0 | 1 => Err(values::wrong_type(n, "a list of at least two joints")),
            _ => Ok(joints),
        }
    };
    let effects = |n: &Node| values::not_empty(values::effects(n, context)?, n);
    let separate =
        |n: &Node| values::names(n, "a list of parameters such as [\"torque_ripple.phase\"]");
    Ok(SharedTable {
        joints: reader.required("joints", "name the joints with motors of one type", joints)?,
        effects: reader.list("effects", effects)?,
        separate: reader.list("separate", separate)?,
    })
}

fn rotor(node: &Node) -> Result<RotorTable, ProblemFileError> {
    let reader = Reader::open(node, ROTOR_KEYS)?;
    let axis = |n: &Node| match values::vector3(n)? {
        [0.0, 0.0, 0.0] => Err(values::wrong_type(n, "an axis, three numbers not all zero")),
        axis => Ok(axis),
    };
    Ok(RotorTable {
        link: reader
            .required("link", "name the link that carries the motor", values::text)?
            .value,
        axis: reader
            .required("axis", "state the axis about which the rotor spins", axis)?
            .value,
        inertia: reader
            .required(
                "inertia",
                "state the rotor's own inertia, kg·m²",
                values::non_negative,
            )?
            .value,
    })
}

fn current_law(reader: &Reader) -> Result<Option<CurrentLaw>, ProblemFileError> {
    reader.at_most_one(&["torque_constant", "current_polynomial"])?;
    let constant = reader.optional("torque_constant", values::per_joint_nonzero)?;
    let polynomial = reader.optional("current_polynomial", polynomials)?;
    Ok(constant
        .map(CurrentLaw::Constant)
        .or(polynomial.map(CurrentLaw::Polynomial)))
}

fn polynomials(node: &Node) -> Result<Vec<CurrentPolynomial>, ProblemFileError> {
    let rows = values::items(node, "a list with four coefficients per joint")?;
    rows.iter().map(values::vector4).collect()
}

fn square_matrix(node: &Node) -> Result<Vec<Vec<f64>>, ProblemFileError> {
    let rows = values::items(node, "a square matrix, as a list of rows")?;
    rows.iter()
        .map(|row| {
            let entries = values::items(row, "a row of the matrix, as a list of numbers")?;
            if entries.len() != rows.len() {
                return Err(ProblemFileError::new(
                    &row.place,
                    ValueFault::WrongLength {
                        expected: format!("{}, as many as there are rows", rows.len()),
                        found: entries.len(),
                    },
                ));
            }
            entries.iter().map(values::finite).collect()
        })
        .collect()
}
