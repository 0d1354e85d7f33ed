//! A load on a link: ten inertial parameters more.

use crate::chain::effect::fitted_effect::FittedEffect;
use crate::chain::effect::knowledge::{Drawn, Knowledge, Sizes, Trial, drawn};
use crate::chain::effect::site::Site;
use crate::chain::effect::{
    Confounder, Dependence, Effect, Law, Linearity, Needs, ParameterInfo, Search, Unit,
};
use crate::chain::words::short;
use crate::robot::random::between;
use rand_chacha::ChaCha8Rng;

const fn free(name: &'static str, meaning: &'static str) -> ParameterInfo {
    ParameterInfo {
        name,
        unit: Unit::One,
        meaning,
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        typical: 1.0,
        linearity: Linearity::Linear,
        search: Search::Typical,
    }
}

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "unmodelled_payload",
    sentence: "A load hangs on the link that the model does not have.",
    equation: "τ = Y(q, q̇, q̈) (π + π_payload)",
    source: "Swevers, Verdonck, Naumer, Pieters and Biber 2002 section 2; Atkeson, An and Hollerbach 1986",
    parameters: &[
        free("mass", "kg"),
        free("com_x", "m, in the frame that carries the load"),
        free("com_y", "m"),
        free("com_z", "m"),
        free("inertia_xx", "kg·m², about the load's centre of mass"),
        free("inertia_xy", "kg·m²"),
        free("inertia_xz", "kg·m²"),
        free("inertia_yy", "kg·m²"),
        free("inertia_yz", "kg·m²"),
        free("inertia_zz", "kg·m²"),
    ],
    depends_on: &[
        Dependence::Position,
        Dependence::Acceleration,
        Dependence::Gravity,
    ],
    confounded_with: &[Confounder {
        with: "the inertials of the link that carries it",
        separated_by: "known link inertials, or recordings with and without the load",
    }],
    law: Law::Body,
    needs: Needs::NOTHING,
    knowledge: Knowledge {
        finding: Some(finding),
        sizes: Sizes::Of {
            names: &["m"],
            nothing: 0.0,
        },
        trial: Trial::Drawn(sized),
        ..Knowledge::NONE
    },
};

fn finding(found: &FittedEffect<'_>) -> String {
    let who = &found.who;
    if found.value("mass").is_some_and(|mass| mass < 0.0) {
        let less = found.scaled("mass", "kg", |mass| -mass);
        let less = less.map_or_else(String::new, |less| format!(" by {less}"));
        return format!(
            "What the link that {who} moves carries is lighter{less} than the model has it"
        );
    }
    let what = match found.quantity("mass") {
        Some(mass) => format!("A load of {mass}"),
        None => "Something".to_string(),
    };
    let centre = ["com_x", "com_y", "com_z"].map(|name| found.value(name));
    let place = match centre {
        [Some(x), Some(y), Some(z)] => {
            format!(
                ", its centre of mass at ({}, {}, {}) m",
                short(x),
                short(y),
                short(z)
            )
        }
        _ => String::new(),
    };
    format!("{what} hangs on the link that {who} moves{place}; the model did not carry it")
}

fn sized(site: &Site, rng: &mut ChaCha8Rng) -> Vec<Drawn> {
    let mass = 5.0 * site.share * site.link_mass;
    let inertia = 0.06_f64.powi(2) * mass;
    let mut offset = || between(rng, -0.1, 0.1);
    vec![
        drawn("mass", mass),
        drawn("com_x", offset()),
        drawn("com_y", offset()),
        drawn("com_z", offset()),
        drawn("inertia_xx", inertia),
        drawn("inertia_yy", inertia),
        drawn("inertia_zz", inertia),
    ]
}
