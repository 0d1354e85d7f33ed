//! Kinematic coupling: entries of `q = V m`, by which one motor moves two joints.
//!
//! The row of V that belongs to the effect's joint is estimated: entries that the problem file's
//! `coupling` declares as other than zero, or the entry of the joint before where it declares none.

use crate::chain::effect::fitted_effect::FittedEffect;
use crate::chain::effect::knowledge::{Drawn, Knowledge, Sizes, Trial, drawn};
use crate::chain::effect::site::{Site, either_sign};
use crate::chain::effect::{
    Confounder, Dependence, Effect, Law, Linearity, Needs, ParameterInfo, Search, Unit,
};
use crate::chain::words::list;
use rand_chacha::ChaCha8Rng;

/// Name of the parameter in this table; a model names it after the other joint.
pub const OTHER_JOINT: &str = "<other joint>";

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "kinematic_coupling",
    sentence: "One motor moves two joints: gears of the wrist, belts, hollow shafts.",
    equation: "q = V·m + offset, τ_M = Vᵀ·τ",
    source: "Swevers, Verdonck, Naumer, Pieters and Biber 2002 eqs 9 to 11",
    parameters: &[ParameterInfo {
        name: OTHER_JOINT,
        unit: Unit::One,
        meaning: "speed of this joint per speed of the other joint's motor",
        lower: -10.0,
        upper: 10.0,
        typical: 0.01,
        linearity: Linearity::Nonlinear,
        search: Search::Typical,
    }],
    depends_on: &[Dependence::OtherJoints],
    confounded_with: &[Confounder {
        with: "coulomb_friction",
        separated_by: "reversals of the two joints at different times",
    }],
    law: Law::Coupling,
    needs: Needs::NOTHING,
    knowledge: Knowledge {
        finding: Some(finding),
        sizes: Sizes::First,
        trial: Trial::Drawn(sized),
        ..Knowledge::NONE
    },
};

fn finding(found: &FittedEffect<'_>) -> String {
    let by = found.by.first().and_then(|motor| found.quantity(motor));
    let by = by.map_or_else(String::new, |by| format!(", by {by} of its own motion"));
    format!(
        "The motor of {} moves {} too{by}; the model took every motor for one joint's",
        list(&found.by),
        found.moved
    )
}

fn sized(site: &Site, rng: &mut ChaCha8Rng) -> Vec<Drawn> {
    vec![drawn(
        EFFECT.parameters[0].name,
        site.share * either_sign(rng),
    )]
}
