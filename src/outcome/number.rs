//! Numbers in JSON: whatever is not finite becomes `null`, and `null` reads back as not a number.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A number; `null` where it is not finite.
pub mod nullable {
    use super::*;

    /// Writes `null` for what is not finite.
    pub fn serialize<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        finite(*value).serialize(serializer)
    }

    /// Reads `null` as not a number.
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
    }
}

/// A number that may be absent; `null` where it is absent or not finite.
pub mod optional {
    use super::*;

    /// Writes `null` for nothing and for what is not finite.
    pub fn serialize<S: Serializer>(value: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
        value.and_then(finite).serialize(serializer)
    }

    /// Reads `null` as nothing.
    pub fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Option<f64>, D::Error> {
        Option::deserialize(deserializer)
    }
}

/// An interval `[lower, upper]`; `null` as a whole where either end is not finite.
pub mod interval {
    use super::*;

    /// Writes `null` for nothing and for an end that is not finite.
    pub fn serialize<S: Serializer>(
        value: &Option<[f64; 2]>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        value
            .filter(|ends| ends.iter().all(|end| end.is_finite()))
            .serialize(serializer)
    }

    /// Reads `null` as nothing.
    pub fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Option<[f64; 2]>, D::Error> {
        Option::deserialize(deserializer)
    }
}

/// A matrix by rows; `null` for each entry that is not finite.
pub mod matrix {
    use super::*;

    /// Writes rows as lists, `null` for what is not finite.
    pub fn serialize<S: Serializer>(rows: &[Vec<f64>], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(rows.iter().map(|row| Row(row)))
    }

    /// Reads `null` as not a number.
    pub fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Vec<Vec<f64>>, D::Error> {
        let rows: Vec<Vec<Option<f64>>> = Vec::deserialize(deserializer)?;
        Ok(rows
            .into_iter()
            .map(|row| row.into_iter().map(|x| x.unwrap_or(f64::NAN)).collect())
            .collect())
    }

    struct Row<'a>(&'a [f64]);

    impl Serialize for Row<'_> {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            serializer.collect_seq(self.0.iter().map(|x| finite(*x)))
        }
    }
}

/// A list of numbers; `null` for each that is not finite.
pub mod list {
    use super::*;

    /// Writes `null` for what is not finite.
    pub fn serialize<S: Serializer>(values: &[f64], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(values.iter().map(|x| finite(*x)))
    }

    /// Reads `null` as not a number.
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<f64>, D::Error> {
        let values: Vec<Option<f64>> = Vec::deserialize(deserializer)?;
        Ok(values.into_iter().map(|x| x.unwrap_or(f64::NAN)).collect())
    }
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// Two square matrices, by rows, along the diagonal of one.
pub(super) fn block_diagonal(first: &[Vec<f64>], second: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let (n, m) = (first.len(), second.len());
    let above = first
        .iter()
        .map(|row| [row.as_slice(), &vec![0.0; m]].concat());
    let below = second
        .iter()
        .map(|row| [&vec![0.0; n], row.as_slice()].concat());
    above.chain(below).collect()
}
