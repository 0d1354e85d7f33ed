//! Stribeck friction: `Fs·exp(−(|v|/vs)²)·sign(v)`, beside Coulomb friction.
//!
//! Gilbert, Maina and Byiringiro 2024 eq. 13 writes `exp(−|v|·ks/vs)` with two parameters of which only
//! the quotient has an effect; here vs alone sets the scale, and the exponent is the square of Armstrong-Hélouvry.

use crate::chain::effect::expression::{Expression, Variable};
use crate::chain::effect::fitted_effect::FittedEffect;
use crate::chain::effect::knowledge::{Change, Drawn, Knowledge, Sizes, Trial, drawn};
use crate::chain::effect::site::Site;
use crate::chain::effect::{
    Confounder, Contribution, Dependence, Effect, Law, Needs, ParameterInfo, Power, Samples,
    Search, Span, TorqueLaw, Unit,
};
use crate::robot::random::between;
use rand_chacha::ChaCha8Rng;

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "stribeck_friction",
    sentence: "Dry friction is larger at low speed, before a film of lubricant builds up.",
    equation: "Fs·exp(−(|v|/vs)²)·sign(v)",
    source: "Stribeck 1902; Armstrong-Hélouvry, Dupont and Canudas de Wit 1994; Gilbert, Maina and Byiringiro 2024 eq. 13",
    parameters: &[
        ParameterInfo::linear(
            "Fs",
            Unit::Torque,
            "friction at standstill beyond Coulomb friction",
            1.0,
        )
        .within(0.0, f64::INFINITY),
        ParameterInfo::nonlinear(
            "vs",
            Unit::Speed,
            "speed at which the excess has fallen to 37 %",
            Span {
                lower: 1e-5,
                typical: 0.1,
                upper: 100.0,
            },
            Search::Speed(&[0.01, 0.03, 0.06, 0.12, 0.25]),
        ),
    ],
    depends_on: &[Dependence::Speed, Dependence::Direction],
    confounded_with: &[
        Confounder {
            with: "coulomb_friction",
            separated_by: "motion at speeds below and well above vs",
        },
        Confounder {
            with: "presliding_hysteresis",
            separated_by: "reversals of small amplitude, where the bristles bend without sliding",
        },
        Confounder {
            with: "viscous_nonlinearity",
            separated_by: "more samples at low speed and at high speed",
        },
    ],
    law: Law::Motor(&Stribeck),
    needs: Needs {
        refines: &["coulomb_friction", "sigmoid_friction"],
        ..Needs::NOTHING
    },
    knowledge: Knowledge {
        finding: Some(finding),
        change: Some(Change::FRICTION),
        sizes: Sizes::First,
        trial: Trial::Drawn(sized),
        ..Knowledge::NONE
    },
};

fn finding(found: &FittedEffect<'_>) -> String {
    found.with(
        "sticks at low speed: near standstill its friction is higher by",
        "Fs",
        "the model had the same dry friction at every speed",
    )
}

fn sized(site: &Site, rng: &mut ChaCha8Rng) -> Vec<Drawn> {
    vec![
        drawn("Fs", site.torque()),
        drawn("vs", between(rng, 0.02, 0.15) * site.fastest),
    ]
}

#[derive(Debug)]
struct Stribeck;

impl TorqueLaw for Stribeck {
    fn add(&self, samples: Samples<'_>, parameters: &[f64], out: &mut Contribution<'_>) {
        let [fs, vs] = *parameters else { return };
        for (k, (v, sign)) in samples.velocity.iter().zip(samples.sign).enumerate() {
            let x = (v / vs).powi(2);
            let excess = (-x).exp();
            out.torque[k] += fs * excess * sign;
            out.by_sign[k] += fs * excess;
            out.by_parameter[0][k] = excess * sign;
            out.by_parameter[1][k] = fs * excess * sign * 2.0 * x / vs;
        }
    }

    /// Fs may be negative where friction falls at low speed, as long as Coulomb friction is larger.
    fn power(&self) -> Power {
        Power::Exchanges
    }

    fn torque(&self) -> Expression {
        let [fs, vs] = [0, 1].map(Expression::parameter);
        let ratio = Expression::from(Variable::Velocity) / vs;
        fs * (-ratio.squared()).exponential() * Variable::Sign
    }
}
