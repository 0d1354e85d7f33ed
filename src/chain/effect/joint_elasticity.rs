//! An elastic gear: the link lags the motor by δ with `K δ + D δ̇ = τ`.

use crate::chain::effect::fitted_effect::FittedEffect;
use crate::chain::effect::knowledge::{Change, Drawn, Knowledge, Sizes, Trial, drawn};
use crate::chain::effect::site::Site;
use crate::chain::effect::{
    Confounder, Dependence, Effect, Law, Memory, Needs, ParameterInfo, Search, Span, Unit,
};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "joint_elasticity",
    sentence: "The gear or the belt twists under load: the link lags the motor.",
    equation: "K·δ + D·dδ/dt = τ, link position = motor position − δ",
    source: "Spong 1987",
    parameters: &[
        ParameterInfo::nonlinear(
            "K",
            Unit::TorquePerPosition,
            "stiffness",
            Span {
                lower: 1e-3,
                typical: 1e4,
                upper: 1e12,
            },
            Search::Values(&[1e2, 3e2, 1e3, 3e3, 1e4, 3e4, 1e5]),
        ),
        ParameterInfo::nonlinear(
            "D",
            Unit::TorquePerSpeed,
            "damping",
            Span {
                lower: 0.0,
                typical: 10.0,
                upper: 1e9,
            },
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
        memory: Memory::WholeMotion,
        ..Needs::NOTHING
    },
    knowledge: Knowledge {
        finding: Some(finding),
        change: Some(Change::both("stiffness of the gear")),
        sizes: Sizes::First,
        trial: Trial::Drawn(sized),
        ..Knowledge::NONE
    },
};

fn finding(found: &FittedEffect<'_>) -> String {
    found.with(
        "is not rigid between motor and link, its stiffness being",
        "K",
        "the model had a rigid gearbox",
    )
}

fn sized(site: &Site, _: &mut ChaCha8Rng) -> Vec<Drawn> {
    // Links of robots swing above 8 Hz.
    let softest = site.inertia * (TAU * 8.0).powi(2);
    let bend = 0.02 * site.share * site.half_range;
    let stiffness = (site.usual_torque / bend).max(softest);
    let damping = 0.2 * (stiffness * site.inertia).sqrt();
    vec![drawn("K", stiffness), drawn("D", damping)]
}
