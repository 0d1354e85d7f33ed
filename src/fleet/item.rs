//! The stored result of one item, under the hash of all that it depends on.

use crate::fleet::manifest::Entry;
use crate::outcome::number;
use crate::outcome::parameter::{Parameter, Source};
use serde::{Deserialize, Serialize};

/// The content of an item's file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Kept<T> {
    /// The item's key: a file that is copied to another place is not taken for another item.
    pub key: String,
    /// Version of the program.
    pub version: String,
    #[serde(flatten)]
    pub came_to: T,
}

/// What an item came to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ItemOutcome {
    Done(Done),
    SetAside(SetAside),
}

/// A fit or a diagnosis.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Done {
    pub values: Vec<Value>,
    /// Of a diagnosis, the strongest first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub findings: Vec<Found>,
}

/// One estimated value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Value {
    /// A parameter, or a combination of parameters that the recordings determine where they do not single ones.
    pub parameter: String,
    pub unit: String,
    #[serde(with = "number::optional")]
    pub value: Option<f64>,
    #[serde(with = "number::optional")]
    pub std: Option<f64>,
    /// The part of `std` that noise makes; the rest is common to all nights of a robot.
    #[serde(with = "number::optional")]
    pub noise: Option<f64>,
    pub source: Source,
}

impl From<&Parameter> for Value {
    fn from(parameter: &Parameter) -> Self {
        Self {
            parameter: parameter.name.clone(),
            unit: parameter.unit.clone(),
            value: parameter.value,
            std: parameter.std_dev,
            noise: parameter.std_dev_statistical.or(parameter.std_dev),
            source: parameter.source,
        }
    }
}

/// A finding of a diagnosis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Found {
    pub effect: String,
    pub joints: Vec<String>,
    pub sentence: String,
    #[serde(with = "number::optional")]
    pub probability: Option<f64>,
}

/// An item that came to nothing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SetAside {
    /// Stable code of the fault.
    pub code: String,
    pub message: String,
    pub attempts: u32,
}

/// An item and what it came to.
pub struct Item {
    pub entry: Entry,
    pub came_to: ItemOutcome,
}
