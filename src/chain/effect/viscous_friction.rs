//! Viscous friction: `Fv·v`.

use crate::chain::effect::expression::{Expression, Variable};
use crate::chain::effect::fitted_effect::FittedEffect;
use crate::chain::effect::knowledge::{Change, JointTerm, Knowledge, Sizes, Trial};
use crate::chain::effect::{
    Confounder, Contribution, Dependence, Effect, Law, Linearity, Needs, ParameterInfo, Power,
    Samples, Search, TorqueLaw, Unit,
};

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "viscous_friction",
    sentence: "Friction in proportion to speed: lubricant, bearings, eddy currents.",
    equation: "Fv·v",
    source: "Swevers, Verdonck, Naumer, Pieters and Biber 2002 eq. 5",
    parameters: &[ParameterInfo {
        name: "Fv",
        unit: Unit::TorquePerSpeed,
        meaning: "friction per speed",
        lower: 0.0,
        upper: f64::INFINITY,
        typical: 1.0,
        linearity: Linearity::Linear,
        search: Search::Typical,
    }],
    depends_on: &[Dependence::Speed],
    confounded_with: &[Confounder {
        with: "coulomb_friction",
        separated_by: "motion at several speeds",
    }],
    law: Law::Motor(&ViscousFriction),
    needs: Needs::NOTHING,
    knowledge: Knowledge {
        finding: Some(finding),
        change: Some(Change::FRICTION),
        sizes: Sizes::First,
        trial: Trial::Declared,
        term: Some(JointTerm::ViscousFriction),
        ..Knowledge::NONE
    },
};

fn finding(found: &FittedEffect<'_>) -> String {
    found.with(
        "has friction that grows with speed, by",
        "Fv",
        "the model had none",
    )
}

#[derive(Debug)]
struct ViscousFriction;

impl TorqueLaw for ViscousFriction {
    fn add(&self, samples: Samples<'_>, parameters: &[f64], out: &mut Contribution<'_>) {
        let [fv] = *parameters else { return };
        for (k, v) in samples.velocity.iter().enumerate() {
            out.torque[k] += fv * v;
            out.by_parameter[0][k] = *v;
        }
    }

    fn power(&self) -> Power {
        Power::Dissipates
    }

    fn torque(&self) -> Expression {
        Expression::parameter(0) * Variable::Velocity
    }
}
