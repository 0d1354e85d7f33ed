//! Limits on combinations of parameters: the total mass, and the centre of mass of a body within a box,
//! which is linear in mass and first moment: `lower·m <= m c <= upper·m`.

use crate::chain::model::Model;
use crate::problem_file::FitTable;
use crate::robot::inertia::PER_LINK;
use crate::setup::error::SetupError;
use crate::setup::known::resolve;
use crate::setup::names::{BodyQuantity, Reference};

/// `Σ coefficient · parameter + constant >= 0`.
#[derive(Debug, Clone, PartialEq)]
pub struct Limit {
    /// What is limited, and on which side.
    pub name: String,
    /// SI unit of the sum.
    pub unit: String,
    /// Position of a parameter in the model and its coefficient.
    pub terms: Vec<(usize, f64)>,
    /// In that unit.
    pub constant: f64,
}

/// The limits of a fit that are not bounds of single parameters.
pub fn build(settings: &FitTable, model: &Model) -> Result<Vec<Limit>, SetupError> {
    let mut limits = Vec::new();
    for entry in &settings.bounds {
        let reference = resolve(model, &entry.name, &entry.value.place)?;
        if let Reference::Body(first, BodyQuantity::Centre(axis)) = reference {
            let interval = entry.value.value;
            for (sign, side, word) in [
                (1.0, interval.lower, "lower"),
                (-1.0, interval.upper, "upper"),
            ] {
                if side.is_finite() {
                    limits.push(Limit {
                        name: format!("{} {word} limit", entry.name),
                        unit: "kg·m".to_string(),
                        terms: vec![(first + 1 + axis, sign), (first, -sign * side)],
                        constant: 0.0,
                    });
                }
            }
        }
    }
    if let Some(total) = &settings.total_mass {
        let interval = total.value;
        for (sign, side, word) in [
            (1.0, interval.lower, "lower"),
            (-1.0, interval.upper, "upper"),
        ] {
            if side.is_finite() {
                let masses = (0..model.tree().len()).map(|link| (PER_LINK * link, sign));
                limits.push(Limit {
                    name: format!("total_mass {word} limit"),
                    unit: "kg".to_string(),
                    terms: masses.collect(),
                    constant: -sign * side,
                });
            }
        }
    }
    Ok(limits)
}
