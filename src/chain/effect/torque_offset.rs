//! A constant torque: zero error of sensor or amplifier.

use crate::chain::effect::expression::Expression;
use crate::chain::effect::fitted_effect::FittedEffect;
use crate::chain::effect::knowledge::{Change, Drawn, JointTerm, Knowledge, Sizes, Trial, drawn};
use crate::chain::effect::site::{Site, either_sign};
use crate::chain::effect::{
    Confounder, Contribution, Dependence, Effect, Law, Linearity, Needs, ParameterInfo, Power,
    Samples, Search, TorqueLaw, Unit,
};
use rand_chacha::ChaCha8Rng;

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "torque_offset",
    sentence: "The torque channel does not read zero at zero torque.",
    equation: "offset",
    source: "zero error of a sensor or amplifier",
    parameters: &[ParameterInfo {
        name: "offset",
        unit: Unit::Torque,
        meaning: "torque that is read in addition",
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        typical: 0.1,
        linearity: Linearity::Linear,
        search: Search::Typical,
    }],
    depends_on: &[Dependence::Nothing],
    confounded_with: &[Confounder {
        with: "asymmetric_friction",
        separated_by: "nothing for its dFc: it is the same torque",
    }],
    law: Law::Motor(&TorqueOffset),
    needs: Needs::NOTHING,
    knowledge: Knowledge {
        finding: Some(finding),
        change: Some(Change::both("torque offset")),
        sizes: Sizes::First,
        trial: Trial::Drawn(sized),
        term: Some(JointTerm::Offset),
        ..Knowledge::NONE
    },
};

fn finding(found: &FittedEffect<'_>) -> String {
    found.with(
        "needs more torque in one direction than in the other, half the difference being",
        "offset",
        "the model was the same in both (a constant offset of the signal is the same torque)",
    )
}

fn sized(site: &Site, rng: &mut ChaCha8Rng) -> Vec<Drawn> {
    vec![drawn("offset", site.torque() * either_sign(rng))]
}

#[derive(Debug)]
struct TorqueOffset;

impl TorqueLaw for TorqueOffset {
    fn add(&self, _: Samples<'_>, parameters: &[f64], out: &mut Contribution<'_>) {
        let [offset] = *parameters else { return };
        for (torque, column) in out.torque.iter_mut().zip(&mut out.by_parameter[0]) {
            *torque += offset;
            *column = 1.0;
        }
    }

    fn power(&self) -> Power {
        Power::Exchanges
    }

    fn torque(&self) -> Expression {
        Expression::parameter(0)
    }
}
