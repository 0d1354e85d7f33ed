//! Viscous friction that is not proportional to speed: `Fn·|v|^p·sgn(v)`, beside viscous friction.
//!
//! p < 1 with Fn > 0 saturates, p > 1 grows; p = 1 is viscous friction itself.

use crate::chain::effect::expression::{Expression, Function, Variable};
use crate::chain::effect::fitted_effect::FittedEffect;
use crate::chain::effect::knowledge::{Change, Drawn, Knowledge, Sizes, Trial, drawn};
use crate::chain::effect::site::Site;
use crate::chain::effect::{
    Confounder, Contribution, Dependence, Effect, Law, Needs, ParameterInfo, Power, Samples,
    Search, Span, TorqueLaw, Unit, law,
};
use crate::robot::random::between;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "viscous_nonlinearity",
    sentence: "Viscous friction saturates or grows with speed: thinning grease, churning oil, drag of air.",
    equation: "Fn·|v|^p·sgn(v)",
    source: "power law of a non-Newtonian film; Waiboer, Aarts and Jonker 2005 for its place in robot joints",
    parameters: &[
        ParameterInfo::linear(
            "Fn",
            Unit::TorquePerSpeedPower,
            "torque at unit speed beyond viscous friction",
            1.0,
        ),
        ParameterInfo::nonlinear(
            "p",
            Unit::One,
            "power of speed",
            Span {
                lower: 0.1,
                typical: 2.0,
                upper: 4.0,
            },
            Search::Values(&[0.5, 2.0, 3.0]),
        ),
    ],
    depends_on: &[Dependence::Speed],
    confounded_with: &[
        Confounder {
            with: "viscous_friction",
            separated_by: "motion at several speeds up to the limit",
        },
        Confounder {
            with: "stribeck_friction",
            separated_by: "more samples at low speed and at high speed",
        },
    ],
    law: Law::Motor(&PowerLaw),
    needs: Needs {
        refines: &["viscous_friction"],
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
    format!(
        "Friction of {} is not proportional to speed; the model's viscous friction was",
        found.who
    )
}

fn sized(site: &Site, rng: &mut ChaCha8Rng) -> Vec<Drawn> {
    let power = match rng.random::<bool>() {
        true => between(rng, 1.6, 3.0),
        false => between(rng, 0.3, 0.6),
    };
    vec![
        drawn("Fn", site.torque() / (0.5 * site.fastest).powf(power)),
        drawn("p", power),
    ]
}

#[derive(Debug)]
struct PowerLaw;

impl TorqueLaw for PowerLaw {
    fn add(&self, samples: Samples<'_>, parameters: &[f64], out: &mut Contribution<'_>) {
        let [size, p] = *parameters else { return };
        for (k, v) in samples.velocity.iter().enumerate() {
            let speed = v.abs();
            if speed == 0.0 {
                continue;
            }
            let power = speed.powf(p) * law::signum(*v);
            out.torque[k] += size * power;
            out.by_parameter[0][k] = power;
            out.by_parameter[1][k] = size * power * speed.ln();
        }
    }

    /// Fn is negative where friction saturates beside viscous friction.
    fn power(&self) -> Power {
        Power::Exchanges
    }

    fn torque(&self) -> Expression {
        let [size, power] = [0, 1].map(Expression::parameter);
        let velocity = Expression::from(Variable::Velocity);
        let speed = velocity.clone().magnitude();
        size * speed.call_with(Function::Power, power) * velocity.call(Function::Signum)
    }
}
