//! The polynomial from current to torque, odd in the current:
//! `τ_mot = sign(i)·(c0 + c1|i| + c2 i² + c3|i|³)`.
//!
//! A model predicts the current that a torque takes, so the polynomial is inverted. Below c0 there is no
//! current; where the polynomial would stop to rise, it goes on with a slope of [`LEAST_SLOPE`](crate::chain::effect::current_polynomial::LEAST_SLOPE) · c1.

use crate::chain::effect::fitted_effect::FittedEffect;
use crate::chain::effect::knowledge::{Drawn, Knowledge, Sizes, Trial, drawn};
use crate::chain::effect::site::Site;
use crate::chain::effect::{
    Confounder, Dependence, Effect, Law, Needs, ParameterInfo, Search, Span, Unit,
};
use rand_chacha::ChaCha8Rng;

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "torque_current_nonlinearity",
    sentence: "Torque is not proportional to current: saturating iron, dead zone of the amplifier.",
    equation: "τ_mot = sign(i)·(c0 + c1·|i| + c2·i² + c3·|i|³)",
    source: "Swevers, Verdonck, Naumer, Pieters and Biber 2002 eq. 4",
    parameters: &[
        coefficient(
            "c0",
            0,
            "torque at which current begins to flow",
            above(-1e6, 0.1),
        ),
        coefficient(
            "c1",
            1,
            "torque constant at small currents",
            above(1e-9, 10.0),
        ),
        coefficient("c2", 2, "growth of the slope", above(-1e9, 0.1)),
        coefficient("c3", 3, "saturation where negative", above(-1e9, 0.01)),
    ],
    depends_on: &[Dependence::Load],
    confounded_with: &[
        Confounder {
            with: "drive_gain",
            separated_by: "currents small and large",
        },
        Confounder {
            with: "load_dependent_friction",
            separated_by: "the same load lifted and lowered",
        },
    ],
    law: Law::Current,
    needs: Needs::NOTHING,
    knowledge: Knowledge {
        finding: Some(finding),
        // Its coefficients trade against one another, and none of them is its size.
        sizes: Sizes::Of {
            names: &[],
            nothing: 0.0,
        },
        trial: Trial::Drawn(sized),
        ..Knowledge::NONE
    },
};

fn finding(found: &FittedEffect<'_>) -> String {
    format!(
        "The torque of {} is not proportional to its current; the model had one torque constant",
        found.who
    )
}

fn sized(site: &Site, _: &mut ChaCha8Rng) -> Vec<Drawn> {
    let constant = site.torque_constant;
    // Torque grows with the current up to five times the usual one.
    let largest = 5.0 * site.usual_torque / constant;
    let bend = site.share * constant / (3.0 * largest.powi(2));
    vec![
        drawn("c0", 0.0),
        drawn("c1", constant),
        drawn("c2", 0.0),
        drawn("c3", -bend),
    ]
}

const fn above(lower: f64, typical: f64) -> Span {
    Span {
        lower,
        typical,
        upper: f64::INFINITY,
    }
}

const fn coefficient(
    name: &'static str,
    power: u8,
    meaning: &'static str,
    span: Span,
) -> ParameterInfo {
    ParameterInfo::nonlinear(
        name,
        Unit::TorquePerCurrent(power),
        meaning,
        span,
        Search::Typical,
    )
}
