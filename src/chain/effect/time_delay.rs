//! A delay of the signal: `s(t) = s_true(t − delay)`.

use crate::chain::effect::{
    Confounder, Dependence, Effect, Law, Memory, Needs, ParameterInfo, Search, Unit,
};

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "time_delay",
    sentence: "The torque channel is recorded late, or early, against the motion.",
    equation: "s(t) = s_true(t − delay)",
    source: "the motion at t − delay gives the signal at t",
    parameters: &[ParameterInfo::nonlinear(
        ("delay", Unit::Time),
        "by which the signal is late",
        (-0.5, 0.005, 0.5),
        Search::Values(&[-0.02, 0.0, 0.02]),
    )],
    depends_on: &[Dependence::Time, Dependence::Acceleration],
    confounded_with: &[
        Confounder {
            with: "viscous_friction",
            separated_by: "fast motion: a delay of inertial torque grows with the rate of acceleration",
        },
        Confounder {
            with: "presliding_hysteresis",
            separated_by: "reversals at several rates",
        },
    ],
    law: Law::Delay,
    needs: Needs {
        memory: Memory::Course,
        ..Needs::NOTHING
    },
};
