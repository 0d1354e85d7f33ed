//! An unknown factor of the torque constant: `true constant = gain · declared constant`.

use crate::chain::effect::{
    Confounder, Dependence, Effect, Law, Linearity, Needs, ParameterInfo, Search, Unit,
};

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "drive_gain",
    sentence: "The true torque constant differs from the declared one by a factor.",
    equation: "s = τ_mot / (k·gain)",
    source: "Gautier and Briot 2014, global identification of drive gains",
    parameters: &[ParameterInfo {
        name: "gain",
        unit: Unit::One,
        meaning: "true over declared torque constant",
        lower: 0.05,
        upper: 20.0,
        typical: 1.0,
        linearity: Linearity::Nonlinear,
        search: Search::Typical,
    }],
    depends_on: &[Dependence::Load],
    confounded_with: &[Confounder {
        with: "all parameters that are free, scaled together",
        separated_by: "a known load, known link inertials or a known rotor inertia",
    }],
    law: Law::Gain,
    needs: Needs::NOTHING,
};
