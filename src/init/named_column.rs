//! Columns that are named beside the files, where their names do not say what they hold.

use crate::recording::units::Quantity;
use std::str::FromStr;

/// A column that is named beside the files: `position=AIPos.A{n}`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedColumn {
    /// What it holds: a key of `[recordings.columns]`.
    pub key: ColumnKey,
    /// Its name with `{n}` for the number of a joint or `{joint}` for its name, or names of all joints with commas between them.
    pub column: String,
}

/// Keys of `[recordings.columns]` that can be named.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnKey {
    /// Time stamps.
    Time,
    /// Positions.
    Position,
    /// Velocities.
    Velocity,
    /// Currents.
    Current,
    /// Torques.
    Torque,
    /// Commanded positions.
    Command,
}

impl ColumnKey {
    const ALL: [(&str, Self); 6] = [
        ("time", Self::Time),
        ("position", Self::Position),
        ("velocity", Self::Velocity),
        ("current", Self::Current),
        ("torque", Self::Torque),
        ("command", Self::Command),
    ];

    pub(super) fn quantity(self) -> Quantity {
        match self {
            Self::Time => Quantity::Time,
            Self::Position | Self::Command => Quantity::Position,
            Self::Velocity => Quantity::Velocity,
            Self::Current => Quantity::Current,
            Self::Torque => Quantity::Torque,
        }
    }
}

impl FromStr for NamedColumn {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = |key: &str| ColumnKey::ALL.iter().find(|(name, _)| *name == key);
        let pair = text
            .split_once('=')
            .filter(|(_, column)| !column.is_empty());
        let named = pair.and_then(|(key, column)| {
            let (_, key) = known(key)?;
            let column = column.to_owned();
            Some(Self { key: *key, column })
        });
        named.ok_or_else(|| {
            let keys = ColumnKey::ALL.map(|(name, _)| name).join(", ");
            format!("a column is named as position=NAME{{n}}, with one of {keys}")
        })
    }
}
