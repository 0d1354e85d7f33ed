//! `[controller]`: the gains of the position controllers, where the torque follows from what these are told.

use crate::problem_file::document::{Node, NodeValue};
use crate::problem_file::error::{ProblemFileError, ValueFault};
use crate::problem_file::key::{Form, Key, Length, REQUIRED, Range};
use crate::problem_file::located::{Located, check_length};
use crate::problem_file::reader::Reader;
use crate::problem_file::values;

/// Keys of `[controller]`.
#[rustfmt::skip]
pub(crate) const KEYS: &[Key] = &[
    Key { name: "kp", form: KP, unit: "N·m/rad (N/m)", default: "the robot file's, or else \"estimate\"", example: "[20.0, { value = 20.0, std_dev = 2.0 }, \"estimate\"]", meaning: "Proportional gains at the joint side, one for all joints or one for each: known, known up to a standard deviation, or estimated" },
    Key { name: "kd", form: KD, unit: "N·m·s/rad (N·s/m)", default: "the robot file's, or else \"estimate\"", example: "1.5", meaning: "Derivative gains, in the same forms" },
];

/// Keys of a gain that is known up to a standard deviation.
#[rustfmt::skip]
pub(crate) const GAIN_KEYS: &[Key] = &[
    Key { name: "value", form: Form::Number(Range::Positive), unit: "the gain's own", default: REQUIRED, example: "20.0", meaning: "The gain expected" },
    Key { name: "std_dev", form: Form::Number(Range::Positive), unit: "the gain's own", default: REQUIRED, example: "2.0", meaning: "How far to trust it: its standard deviation" },
];

const KP: Form = Form::Either(&[
    Form::Number(Range::Positive),
    Form::Words(estimated),
    Form::Table(GAIN_KEYS),
    Form::List(&KP_OF_JOINT, Length::Some),
]);
const KP_OF_JOINT: Form = Form::Either(&[
    Form::Number(Range::Positive),
    Form::Words(estimated),
    Form::Table(GAIN_KEYS),
]);
const KD: Form = Form::Either(&[
    Form::Number(Range::NonNegative),
    Form::Words(estimated),
    Form::Table(GAIN_KEYS),
    Form::List(&KD_OF_JOINT, Length::Some),
]);
const KD_OF_JOINT: Form = Form::Either(&[
    Form::Number(Range::NonNegative),
    Form::Words(estimated),
    Form::Table(GAIN_KEYS),
]);

/// The word for a gain that nothing is known of.
const ESTIMATE: &str = "estimate";

fn estimated() -> Vec<&'static str> {
    vec![ESTIMATE]
}

/// What is known of a gain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Gain {
    /// It has this value.
    Known(f64),
    /// A value and its standard deviation.
    Uncertain {
        /// The value expected.
        value: f64,
        /// How far to trust it, positive, in the gain's unit.
        std_dev: f64,
    },
    /// It is estimated from the recordings alone.
    Estimate,
}

/// Gains of all joints.
#[derive(Debug, Clone, PartialEq)]
pub enum Gains {
    /// One for every joint.
    All(Gain),
    /// One for each.
    Each(Vec<Gain>),
}

impl Located<Gains> {
    /// One gain per joint.
    ///
    /// # Errors
    /// `wrong-length`, where a list has not as many gains as there are joints.
    pub fn expand(&self, joints: &[String]) -> Result<Vec<Gain>, ProblemFileError> {
        match &self.value {
            Gains::All(gain) => Ok(vec![*gain; joints.len()]),
            Gains::Each(gains) => {
                let remark = "; one gain for all joints may stand alone, without brackets";
                check_length(gains.len(), joints, remark, &self.place)?;
                Ok(gains.clone())
            }
        }
    }
}

/// The table `[controller]`.
#[derive(Debug, Clone)]
pub struct ControllerTable {
    /// N·m/rad (N/m), positive. Default: the robot file's, or else estimated.
    pub kp: Option<Located<Gains>>,
    /// N·m·s/rad (N·s/m), not negative. Default: the robot file's, or else estimated.
    pub kd: Option<Located<Gains>>,
}

impl ControllerTable {
    pub(super) fn from_node(node: &Node) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, KEYS)?;
        Ok(Self {
            kp: reader.optional("kp", |n| gains(n, values::positive))?,
            kd: reader.optional("kd", |n| gains(n, values::non_negative))?,
        })
    }
}

type Number = fn(&Node) -> Result<f64, ProblemFileError>;

fn gains(node: &Node, number: Number) -> Result<Gains, ProblemFileError> {
    match &node.value {
        NodeValue::List(items) if !items.is_empty() => {
            let gains = items.iter().map(|item| gain(item, number));
            gains.collect::<Result<_, _>>().map(Gains::Each)
        }
        _ => gain(node, number).map(Gains::All),
    }
}

fn gain(node: &Node, number: Number) -> Result<Gain, ProblemFileError> {
    const EXPECTED: &str =
        "a gain: a number, a table such as { value = 20.0, std_dev = 2.0 }, or \"estimate\"";
    match &node.value {
        NodeValue::Integer(_) | NodeValue::Number(_) => number(node).map(Gain::Known),
        NodeValue::Text(word) if word == ESTIMATE => Ok(Gain::Estimate),
        NodeValue::Text(word) => Err(ProblemFileError::new(
            &node.place,
            ValueFault::WrongType {
                expected: EXPECTED,
                found: format!("the text \"{word}\""),
            },
        )),
        NodeValue::Table(_) => {
            let reader = Reader::open(node, GAIN_KEYS)?;
            let value = reader.required("value", "state the gain expected", values::positive)?;
            let remedy = "state how far to trust it";
            let std_dev = reader.required("std_dev", remedy, values::positive)?;
            Ok(Gain::Uncertain {
                value: value.value,
                std_dev: std_dev.value,
            })
        }
        _ => Err(values::wrong_type(node, EXPECTED)),
    }
}
