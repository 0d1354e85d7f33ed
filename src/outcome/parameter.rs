//! A parameter of the model: its value, how well it is known, and what it is known from.

use serde::{Deserialize, Serialize};

use crate::outcome::number;

/// What the value of a parameter rests on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Source {
    /// The recordings determine it.
    Data,
    /// The recordings alone do not; the prior does.
    Prior,
    /// It lies on a bound, or on the edge of what is physically possible.
    Bound,
    /// Given by the user, not estimated.
    Known,
    /// Nothing determines it: it has no value.
    Undetermined,
}

impl Source {
    /// The word that stands in the result.
    pub fn as_str(self) -> &'static str {
        match self {
            Source::Data => "data",
            Source::Prior => "prior",
            Source::Bound => "bound",
            Source::Known => "known",
            Source::Undetermined => "undetermined",
        }
    }
}

/// One parameter, in SI units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// `<joint>.<effect>.<parameter>` or `<link>.<quantity>`.
    pub name: String,
    /// SI unit in plain text, such as `N·m·s/rad`; empty where there is none.
    pub unit: String,
    /// The estimate; absent where undetermined.
    #[serde(with = "number::optional")]
    pub value: Option<f64>,
    /// Standard deviation of the estimate; absent where undetermined or known.
    #[serde(with = "number::optional")]
    pub std_dev: Option<f64>,
    /// The part of the standard deviation that noise makes, where uncertain torque constants make another.
    #[serde(
        with = "number::optional",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub std_dev_statistical: Option<f64>,
    /// 95 % confidence interval, lower and upper end.
    #[serde(with = "number::interval")]
    pub ci95: Option<[f64; 2]>,
    /// Where the value is from.
    pub source: Source,
    /// What the parameter is, in plain words; may be empty.
    #[serde(default)]
    pub description: String,
    /// The joints that have it in common, the one of its name first; empty of a parameter of one joint.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shared_by: Vec<String>,
}

impl Parameter {
    /// A parameter that the data do not determine: no value, no deviation, no interval.
    pub fn undetermined(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            unit: unit.into(),
            value: None,
            std_dev: None,
            std_dev_statistical: None,
            ci95: None,
            source: Source::Undetermined,
            description: String::new(),
            shared_by: Vec::new(),
        }
    }

    /// A parameter that the user gave: a value without uncertainty.
    pub fn known(name: impl Into<String>, unit: impl Into<String>, value: f64) -> Self {
        Self {
            value: Some(value),
            source: Source::Known,
            ..Self::undetermined(name, unit)
        }
    }

    /// The same parameter, of several joints.
    pub fn shared_by(mut self, joints: Vec<String>) -> Self {
        self.shared_by = joints;
        self
    }

    /// Its name, and those it would have on the other joints that share it.
    pub fn names(&self) -> Vec<String> {
        let rest = self.name.split_once('.').map_or("", |(_, rest)| rest);
        let others = self.shared_by.iter().map(|joint| format!("{joint}.{rest}"));
        let own = std::iter::once(self.name.clone());
        own.chain(others.filter(|name| *name != self.name))
            .collect()
    }

    /// Whether it goes by a name: its own, or that of a joint which shares it.
    pub fn is_called(&self, name: &str) -> bool {
        self.name == name || self.names().iter().any(|own| own == name)
    }

    /// The same parameter, with its meaning in plain words.
    pub fn described(mut self, description: impl Into<String>) -> Self {
        self.description = description.into();
        self
    }
}
