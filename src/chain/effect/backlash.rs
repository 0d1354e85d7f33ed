//! Play of the gear: the link lags the motor by δ, and torque passes only at the ends of the play.
//!
//! ```text
//! τ = K_c (δ ∓ gap/2) + D_c δ̇  beyond ± gap/2, 0 between
//! ```
//!
//! K_c and D_c are those of a contact that is stiff against everything the recording resolves.

use crate::chain::effect::fitted_effect::FittedEffect;
use crate::chain::effect::knowledge::{Drawn, Knowledge, Sizes, Trial, drawn};
use crate::chain::effect::site::Site;
use crate::chain::effect::{
    Confounder, Dependence, Effect, Law, Memory, Needs, ParameterInfo, Search, Span, Unit,
};
use rand_chacha::ChaCha8Rng;

/// Even in their roots, to which the time is proportional that the link takes to cross them: it strikes a flank at
/// another row where the gap is another, and a strike that comes at the wrong row explains nothing.
const GAPS: &[f64] = &[
    0.0004, 0.001, 0.0018, 0.003, 0.0044, 0.006, 0.0079, 0.0101, 0.0125, 0.0153, 0.0182, 0.0215,
    0.025, 0.0287, 0.0328,
];

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "backlash",
    sentence: "Teeth have play: when the transmitted torque changes sign, the link falls from one flank to the other.",
    equation: "|δ| < gap/2: τ = 0; link position = motor position − δ",
    source: "Nordin and Gutman 2002, dead zone with a stiff shaft",
    parameters: &[ParameterInfo::nonlinear(
        "gap",
        Unit::Position,
        "total play between motor and link",
        Span {
            lower: 0.0,
            typical: 0.005,
            upper: 1.0,
        },
        Search::Rising(GAPS),
    )],
    depends_on: &[Dependence::Load, Dependence::Direction],
    confounded_with: &[
        Confounder {
            with: "joint_elasticity",
            separated_by: "loads of several sizes: play does not grow with the load",
        },
        Confounder {
            with: "coulomb_friction",
            separated_by: "changes of the sign of the load without a reversal of the motion",
        },
    ],
    law: Law::Play,
    needs: Needs {
        memory: Memory::WholeMotion,
        ..Needs::NOTHING
    },
    knowledge: Knowledge {
        finding: Some(finding),
        sizes: Sizes::First,
        trial: Trial::Drawn(sized),
        ..Knowledge::NONE
    },
};

fn finding(found: &FittedEffect<'_>) -> String {
    found.with(
        "has play between motor and link of",
        "gap",
        "the model had none",
    )
}

fn sized(site: &Site, _: &mut ChaCha8Rng) -> Vec<Drawn> {
    vec![drawn("gap", 0.02 * site.share * site.half_range)]
}
