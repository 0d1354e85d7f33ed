//! Sigmoid friction: `ψ1/(1 + exp(−ψ2 (v + ψ3))) − ψ1/(1 + exp(−ψ2 ψ3))`.

use crate::chain::effect::expression::{self, Expression, Variable};
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
    id: "sigmoid_friction",
    sentence: "Friction follows a sigmoid of speed that passes through zero: Coulomb friction with a smooth, shifted switch.",
    equation: "psi1/(1 + exp(−psi2·(v + psi3))) − psi1/(1 + exp(−psi2·psi3))",
    source: "Gaz, Cognetti, Oliva, Robuffo Giordano and De Luca 2019; Gilbert, Maina and Byiringiro 2024 eq. 14",
    parameters: &[
        ParameterInfo::linear(
            "psi1",
            Unit::Torque,
            "difference between friction at high speed in both directions",
            1.0,
        )
        .within(0.0, f64::INFINITY),
        ParameterInfo::nonlinear(
            "psi2",
            Unit::PerSpeed,
            "steepness of the switch",
            Span {
                lower: 1e-3,
                typical: 20.0,
                upper: 1e6,
            },
            Search::OverSpeed(&[3.0, 10.0, 30.0, 150.0]),
        ),
        ParameterInfo::nonlinear(
            "psi3",
            Unit::Speed,
            "shift of the switch",
            Span {
                lower: -10.0,
                typical: 0.01,
                upper: 10.0,
            },
            Search::Speed(&[-0.3, -0.1, 0.0, 0.1, 0.3]),
        ),
    ],
    depends_on: &[Dependence::Speed, Dependence::Direction],
    confounded_with: &[
        Confounder {
            with: "coulomb_friction",
            separated_by: "slow motion: the two differ only where |v|·psi2 is of the order of one",
        },
        Confounder {
            with: "asymmetric_friction",
            separated_by: "slow motion in both directions",
        },
    ],
    law: Law::Motor(&Sigmoid),
    needs: Needs::NOTHING,
    knowledge: Knowledge {
        finding: Some(finding),
        change: Some(Change::FRICTION),
        sizes: Sizes::First,
        trial: Trial::Drawn(sized),
        ..Knowledge::NONE
    },
};

fn finding(found: &FittedEffect<'_>) -> String {
    format!(
        "Friction of {} switches smoothly, and off standstill, like a sigmoid of speed; the model's switched with the direction",
        found.who
    )
}

fn sized(site: &Site, rng: &mut ChaCha8Rng) -> Vec<Drawn> {
    vec![
        drawn("psi1", 2.0 * site.torque()),
        drawn("psi2", between(rng, 5.0, 40.0) / site.fastest),
        drawn("psi3", between(rng, -0.2, 0.2) * site.fastest),
    ]
}

#[derive(Debug)]
struct Sigmoid;

/// `1/(1 + e^(−x))`, without overflow.
fn logistic(x: f64) -> f64 {
    if x >= 0.0 {
        1.0 / (1.0 + (-x).exp())
    } else {
        let e = x.exp();
        e / (1.0 + e)
    }
}

impl TorqueLaw for Sigmoid {
    fn add(&self, samples: Samples<'_>, parameters: &[f64], out: &mut Contribution<'_>) {
        let [psi1, psi2, psi3] = *parameters else {
            return;
        };
        let rest = logistic(psi2 * psi3);
        let rest_slope = rest * (1.0 - rest);
        for (k, v) in samples.velocity.iter().enumerate() {
            let s = logistic(psi2 * (v + psi3));
            let slope = s * (1.0 - s);
            out.torque[k] += psi1 * (s - rest);
            out.by_parameter[0][k] = s - rest;
            out.by_parameter[1][k] = psi1 * (slope * (v + psi3) - rest_slope * psi3);
            out.by_parameter[2][k] = psi1 * psi2 * (slope - rest_slope);
        }
    }

    /// For psi1 and psi2 of one sign the torque has the sign of v, whatever the shift.
    fn power(&self) -> Power {
        Power::Dissipates
    }

    fn torque(&self) -> Expression {
        let [psi1, psi2, psi3] = [0, 1, 2].map(Expression::parameter);
        let moving = psi2.clone() * (Expression::from(Variable::Velocity) + psi3.clone());
        psi1 * (expression::logistic(moving) - expression::logistic(psi2 * psi3))
    }
}
