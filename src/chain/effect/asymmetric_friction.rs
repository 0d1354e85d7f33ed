//! Friction that differs between the two directions: `dFc + dFv·|v|`.

use crate::chain::effect::expression::{Expression, Variable};
use crate::chain::effect::fitted_effect::FittedEffect;
use crate::chain::effect::knowledge::{Change, Drawn, Knowledge, Sizes, Trial, drawn};
use crate::chain::effect::site::{Site, either_sign};
use crate::chain::effect::{
    Confounder, Contribution, Dependence, Effect, Law, Linearity, Needs, ParameterInfo, Power,
    Samples, Search, TorqueLaw, Unit,
};
use crate::robot::random::between;
use rand_chacha::ChaCha8Rng;

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "asymmetric_friction",
    sentence: "Friction is not the same in both directions of motion.",
    equation: "dFc + dFv·|v|",
    source: "friction levels Fc ± dFc and Fv ± dFv of the two directions",
    parameters: &[
        ParameterInfo {
            name: "dFc",
            unit: Unit::Torque,
            meaning: "half the difference of the Coulomb levels; the same torque as a constant offset",
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
            typical: 0.1,
            linearity: Linearity::Linear,
            search: Search::Typical,
        },
        ParameterInfo {
            name: "dFv",
            unit: Unit::TorquePerSpeed,
            meaning: "half the difference of the viscous coefficients",
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
            typical: 0.1,
            linearity: Linearity::Linear,
            search: Search::Typical,
        },
    ],
    depends_on: &[Dependence::Direction, Dependence::Speed],
    confounded_with: &[Confounder {
        with: "torque_offset",
        separated_by: "nothing for dFc: it is the same torque; dFv by motion at several speeds",
    }],
    law: Law::Motor(&AsymmetricFriction),
    needs: Needs::NOTHING,
    knowledge: Knowledge {
        finding: Some(finding),
        change: Some(Change::both("friction by direction")),
        sizes: Sizes::Of {
            names: &["dFc", "dFv"],
            nothing: 0.0,
        },
        trial: Trial::Drawn(sized),
        ..Knowledge::NONE
    },
};

fn finding(found: &FittedEffect<'_>) -> String {
    match found.is_told_from_zero("dFc") || !found.is_told_from_zero("dFv") {
        true => found.with(
            "needs more torque in one direction than in the other, half the difference being",
            "dFc",
            "the model was the same in both (a constant offset of the signal is the same torque)",
        ),
        false => found.with(
            "has friction that depends on the direction of motion; with speed the difference grows by",
            "dFv",
            "the model had the same in both directions",
        ),
    }
}

fn sized(site: &Site, rng: &mut ChaCha8Rng) -> Vec<Drawn> {
    let torque = site.torque();
    vec![
        drawn("dFc", torque * either_sign(rng)),
        drawn("dFv", between(rng, -1.0, 1.0) * torque / site.fastest),
    ]
}

#[derive(Debug)]
struct AsymmetricFriction;

impl TorqueLaw for AsymmetricFriction {
    fn add(&self, samples: Samples<'_>, parameters: &[f64], out: &mut Contribution<'_>) {
        let [dfc, dfv] = *parameters else { return };
        for (k, v) in samples.velocity.iter().enumerate() {
            out.torque[k] += dfc + dfv * v.abs();
            out.by_parameter[0][k] = 1.0;
            out.by_parameter[1][k] = v.abs();
        }
    }

    fn power(&self) -> Power {
        Power::Exchanges
    }

    fn torque(&self) -> Expression {
        let [dfc, dfv] = [0, 1].map(Expression::parameter);
        dfc + dfv * Expression::from(Variable::Velocity).magnitude()
    }
}
