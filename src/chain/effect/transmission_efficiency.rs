//! Efficiency of the gear: the motor gives `τ_M/R` when it drives and `R·τ_M` when it is driven.
//!
//! ```text
//! τ_in = a τ_M + b |τ_M| sign(ṁ),   a = (1/R + R)/2,   b = (1/R − R)/2
//! ```
//!
//! is the same law in one line. It is continuous in τ_M, and with a transition speed w in ṁ; its
//! slope jumps where τ_M changes sign, and the derivatives below are those of the side on which a sample
//! lies. A search rounds |τ_M| off over a width that shrinks below the noise
//! (see `estimate/solve/smoothing_method.rs`); predictions and simulations have the law itself.

use crate::chain::effect::expression::{Expression, Variable};
use crate::chain::effect::fitted_effect::FittedEffect;
use crate::chain::effect::knowledge::{Change, Drawn, Knowledge, Sizes, Trial, drawn};
use crate::chain::effect::law::size;
use crate::chain::effect::site::Site;
use crate::chain::effect::{
    Confounder, Dependence, Effect, Law, Needs, ParameterInfo, Samples, Search, Span,
    TransmissionLaw, Transmitted, Unit,
};
use rand_chacha::ChaCha8Rng;

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "transmission_efficiency",
    sentence: "The gear loses a share of the torque that it transmits, in either direction of power.",
    equation: "τ_in = τ_M/R where the motor drives (τ_M·ṁ > 0), R·τ_M where it is driven",
    source: "Swevers, Verdonck, Naumer, Pieters and Biber 2002 eq. 8",
    parameters: &[ParameterInfo::nonlinear(
        "R",
        Unit::One,
        "share of the torque that arrives",
        Span {
            lower: 0.05,
            typical: 0.9,
            upper: 1.0,
        },
        Search::Values(&[0.95, 0.85]),
    )],
    depends_on: &[Dependence::Load, Dependence::Direction],
    confounded_with: &[Confounder {
        with: "load_dependent_friction",
        separated_by: "known link inertials or a known load: with these the gain (1/R + R)/2 shows",
    }],
    law: Law::Transmission(&Efficiency),
    needs: Needs::NOTHING,
    knowledge: Knowledge {
        finding: Some(finding),
        change: Some(Change {
            up: "efficiency up",
            down: "efficiency down",
        }),
        sizes: Sizes::Of {
            names: &["R"],
            nothing: 1.0,
        },
        trial: Trial::Drawn(sized),
        ..Knowledge::NONE
    },
};

fn finding(found: &FittedEffect<'_>) -> String {
    // What lies beyond a lossless gearbox is the interval's, not the gearbox's.
    let loss = found.scaled("R", "%", |r| 100.0 * (1.0 - r).max(0.0));
    let loss = loss.unwrap_or_else(|| "part".to_string());
    format!(
        "{} loses {loss} of the torque that it transmits; the model had a lossless gearbox",
        found.who
    )
}

fn sized(site: &Site, _: &mut ChaCha8Rng) -> Vec<Drawn> {
    vec![drawn("R", 1.0 - site.share)]
}

#[derive(Debug)]
struct Efficiency;

impl TransmissionLaw for Efficiency {
    fn add(
        &self,
        samples: Samples<'_>,
        load: &[f64],
        parameters: &[f64],
        out: &mut Transmitted<'_>,
    ) {
        let [r] = *parameters else { return };
        let (mean, half) = (0.5 * (1.0 / r + r), 0.5 * (1.0 / r - r));
        let (mean_slope, half_slope) = (0.5 * (1.0 - 1.0 / (r * r)), -0.5 * (1.0 + 1.0 / (r * r)));
        for (k, (load, sign)) in load.iter().zip(samples.sign).enumerate() {
            let (size, slope) = size(*load, out.rounding);
            out.torque[k] += (mean - 1.0) * load + half * size * sign;
            out.by_load[k] += mean - 1.0 + half * slope * sign;
            out.by_parameter[0][k] = mean_slope * load + half_slope * size * sign;
            out.by_sign[k] += half * size;
        }
    }

    fn added(&self) -> Expression {
        let r = || Expression::parameter(0);
        let inverse = || Expression::from(1.0) / r();
        let (mean, half) = ((inverse() + r()) * 0.5, (inverse() - r()) * 0.5);
        let load = || Expression::from(Variable::Load);
        (mean - 1.0) * load() + half * load().magnitude() * Variable::Sign
    }
}
