//! Coulomb friction: `Fc·v/(|v| + w)`.

use crate::chain::effect::expression::{Expression, Variable};
use crate::chain::effect::fitted_effect::FittedEffect;
use crate::chain::effect::knowledge::{Change, JointTerm, Knowledge, Sizes, Transition, Trial};
use crate::chain::effect::{
    Confounder, Contribution, Dependence, Effect, Law, Linearity, Needs, ParameterInfo, Power,
    Samples, Search, TorqueLaw, Unit,
};

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "coulomb_friction",
    sentence: "Dry friction of constant size opposes the motion; near standstill it grows over a narrow band of speed.",
    equation: "Fc·v/(|v| + w)",
    source: "Coulomb 1785; Swevers, Verdonck, Naumer, Pieters and Biber 2002 eq. 5; transition width as in regularised friction laws",
    parameters: &[
        ParameterInfo {
            name: "Fc",
            unit: Unit::Torque,
            meaning: "friction at speeds well above w",
            lower: 0.0,
            upper: f64::INFINITY,
            typical: 1.0,
            linearity: Linearity::Linear,
            search: Search::Typical,
        },
        ParameterInfo {
            name: "w",
            unit: Unit::Speed,
            meaning: "speed at which half of Fc is reached",
            lower: 0.0,
            upper: 1.0,
            typical: TYPICAL_WIDTH,
            linearity: Linearity::Nonlinear,
            search: Search::Typical,
        },
    ],
    depends_on: &[Dependence::Direction, Dependence::Speed],
    confounded_with: &[Confounder {
        with: "viscous_friction",
        separated_by: "motion at several speeds, slow ones among them",
    }],
    law: Law::Motor(&CoulombFriction),
    needs: Needs::NOTHING,
    knowledge: Knowledge {
        finding: Some(finding),
        change: Some(Change::FRICTION),
        sizes: Sizes::First,
        trial: Trial::Declared,
        term: Some(JointTerm::DryFriction),
        transition: Some(Transition {
            speed: WIDTH,
            size: FC,
            least: TYPICAL_WIDTH,
            stands_for: JointTerm::ViscousFriction,
        }),
        ..Knowledge::NONE
    },
};

fn finding(found: &FittedEffect<'_>) -> String {
    found.with("has dry friction of", "Fc", "the model had none")
}

/// Positions of the parameters within the effect's.
pub const FC: usize = 0;
/// Position of the transition speed w among the parameters.
pub const WIDTH: usize = 1;

/// Transition speed of most gears, rad/s or m/s at joint scale.
const TYPICAL_WIDTH: f64 = 0.005;

#[derive(Debug)]
struct CoulombFriction;

impl TorqueLaw for CoulombFriction {
    fn add(&self, samples: Samples<'_>, parameters: &[f64], out: &mut Contribution<'_>) {
        let [fc, _] = *parameters else { return };
        for k in 0..samples.sign.len() {
            out.torque[k] += fc * samples.sign[k];
            out.by_sign[k] += fc;
            out.by_parameter[FC][k] = samples.sign[k];
        }
    }

    fn power(&self) -> Power {
        Power::Dissipates
    }

    fn torque(&self) -> Expression {
        Expression::parameter(FC) * Variable::Sign
    }
}
