//! An elastic gear: the link lags the motor by δ with `K δ + D δ̇ = τ`.

use crate::chain::effect::{
    Confounder, Dependence, Effect, Law, Memory, Needs, ParameterInfo, Search, Unit,
};

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "joint_elasticity",
    sentence: "The gear or the belt twists under load: the link lags the motor.",
    equation: "K·δ + D·dδ/dt = τ, link position = motor position − δ",
    source: "Spong 1987",
    parameters: &[
        ParameterInfo::nonlinear(
            ("K", Unit::TorquePerPosition),
            "stiffness",
            (1e-3, 1e4, 1e12),
            Search::Values(&[1e2, 3e2, 1e3, 3e3, 1e4, 3e4, 1e5]),
        ),
        ParameterInfo::nonlinear(
            ("D", Unit::TorquePerSpeed),
            "damping",
            (0.0, 10.0, 1e9),
            Search::Typical,
        ),
    ],
    depends_on: &[Dependence::Acceleration, Dependence::Load],
    confounded_with: &[
        Confounder {
            with: "rotor_inertia",
            separated_by: "motion at several frequencies, up to a third of the resonance",
        },
        Confounder {
            with: "time_delay",
            separated_by: "a delay is the same for every joint, and acts on friction too",
        },
    ],
    law: Law::Spring,
    needs: Needs {
        memory: Memory::Course,
        ..Needs::NOTHING
    },
};
