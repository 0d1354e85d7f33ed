//! A constant torque: zero error of sensor or amplifier.

use crate::chain::effect::expression::Expression;
use crate::chain::effect::{
    Confounder, Contribution, Dependence, Effect, Law, Linearity, Needs, ParameterInfo, Power,
    Samples, Search, TorqueLaw, Unit,
};

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
};

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
