//! `[diagnose]`: the physics to look for, and how sure a finding has to be.

use crate::problem_file::context::Context;
use crate::problem_file::document::{Node, NodeValue};
use crate::problem_file::error::{NumberFault, ProblemFileError};
use crate::problem_file::key::{Form, Key, Length, Range};
use crate::problem_file::located::Located;
use crate::problem_file::reader::Reader;
use crate::problem_file::values;

/// Keys of `[diagnose]`.
#[rustfmt::skip]
pub(crate) const KEYS: &[Key] = &[
    Key { name: "effects", form: Form::Either(&[Form::Words(all), Form::List(&Form::Effect, Length::SomeDistinct)]), unit: "", default: "\"all\"", example: "[\"time_delay\", \"base_tilt\"]", meaning: "The physics to look for" },
    Key { name: "significance", form: Form::Number(Range::Probability), unit: "", default: "0.001", example: "0.01", meaning: "Probability of a false finding, after correction for the number of hypotheses tried" },
];

/// One false finding in a thousand diagnoses of a model that is right.
const DEFAULT_SIGNIFICANCE: f64 = 0.001;

/// The table `[diagnose]`.
#[derive(Debug, Clone)]
pub struct DiagnoseTable {
    /// Default: [`SoughtEffects::All`].
    pub effects: Located<SoughtEffects>,
    /// Probability of a false finding after correction for the number of hypotheses tried,
    /// 0 < significance < 1. Default: 0.001.
    pub significance: Located<f64>,
}

/// The physics to look for.
#[derive(Debug, Clone, PartialEq)]
pub enum SoughtEffects {
    /// All of the vocabulary, with laws of the problem and registered effects.
    All,
    /// These.
    Listed(Vec<Located<String>>),
}

impl DiagnoseTable {
    pub(super) fn from_node(node: &Node, context: &Context) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, KEYS)?;
        Ok(Self {
            effects: reader.or("effects", SoughtEffects::All, |n| sought(n, context))?,
            significance: reader.or("significance", DEFAULT_SIGNIFICANCE, probability)?,
        })
    }
}

/// The word for every effect.
const ALL: &str = "all";

fn all() -> Vec<&'static str> {
    vec![ALL]
}

fn sought(node: &Node, context: &Context) -> Result<SoughtEffects, ProblemFileError> {
    match &node.value {
        NodeValue::Text(word) if word == ALL => Ok(SoughtEffects::All),
        NodeValue::List(_) => {
            let effects = values::effects(node, context)?;
            values::not_empty(effects, node).map(SoughtEffects::Listed)
        }
        _ => Err(values::wrong_type(
            node,
            "\"all\" or a list of effects such as [\"time_delay\"]",
        )),
    }
}

fn probability(node: &Node) -> Result<f64, ProblemFileError> {
    let value = values::finite(node)?;
    if value > 0.0 && value < 1.0 {
        return Ok(value);
    }
    Err(ProblemFileError::new(
        &node.place,
        NumberFault::OutOfRange {
            found: value.to_string(),
            range: "greater than 0 and less than 1",
        },
    ))
}
