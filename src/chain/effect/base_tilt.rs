//! A tilted base: gravity is not where the model says.
//!
//! ```text
//! g = (R_y(pitch) R_x(roll))ᵀ g_declared
//! ```

use crate::chain::effect::fitted_effect::FittedEffect;
use crate::chain::effect::knowledge::{Change, Drawn, Knowledge, Sizes, Trial, drawn};
use crate::chain::effect::site::{Site, either_sign};
use crate::chain::effect::{
    Confounder, Dependence, Effect, Law, Needs, ParameterInfo, Search, Span, Unit,
};
use crate::chain::words::list;
use rand_chacha::ChaCha8Rng;

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "base_tilt",
    sentence: "The base does not stand as the model says: gravity comes from another direction.",
    equation: "g = (R_y(pitch)·R_x(roll))ᵀ·g_declared",
    source: "the base turned about its x axis, then about the y axis of the level frame",
    parameters: &[
        ParameterInfo::nonlinear(
            "roll",
            Unit::Angle,
            "about x",
            Span {
                lower: -std::f64::consts::PI,
                typical: 0.05,
                upper: std::f64::consts::PI,
            },
            Search::Values(&[0.0]),
        ),
        ParameterInfo::nonlinear(
            "pitch",
            Unit::Angle,
            "about y",
            Span {
                lower: -std::f64::consts::PI,
                typical: 0.05,
                upper: std::f64::consts::PI,
            },
            Search::Values(&[0.0]),
        ),
    ],
    depends_on: &[Dependence::Gravity, Dependence::Position],
    confounded_with: &[Confounder {
        with: "first moments of the links, where the first axis stands vertical",
        separated_by: "motion of the first joint with the arm stretched out",
    }],
    law: Law::Tilt,
    needs: Needs::NOTHING,
    knowledge: Knowledge {
        finding: Some(finding),
        change: Some(Change::both("base tilted")),
        sizes: Sizes::Of {
            names: &["roll", "pitch"],
            nothing: 0.0,
        },
        trial: Trial::Drawn(sized),
        ..Knowledge::NONE
    },
};

fn finding(found: &FittedEffect<'_>) -> String {
    let angle = |name: &str| {
        let degrees = found.scaled(name, "°", f64::to_degrees)?;
        Some(format!("{name} {degrees}"))
    };
    let told = ["roll", "pitch"].into_iter();
    let told = told.filter(|name| found.is_told_from_zero(name));
    let angles: Vec<String> = told.filter_map(angle).collect();
    let by = match angles.is_empty() {
        true => String::new(),
        false => format!(", {}", list(&angles)),
    };
    format!(
        "The base does not stand as the model says{by}: gravity comes from elsewhere (this may be a mistake of the mounting in the problem file)"
    )
}

fn sized(site: &Site, rng: &mut ChaCha8Rng) -> Vec<Drawn> {
    let mut angle = || 0.2 * site.share * either_sign(rng);
    vec![drawn("roll", angle()), drawn("pitch", angle())]
}
