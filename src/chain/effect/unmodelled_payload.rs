//! A load on a link: ten inertial parameters more.

use crate::chain::effect::{
    Confounder, Dependence, Effect, Law, Linearity, Needs, ParameterInfo, Search, Unit,
};

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
};
