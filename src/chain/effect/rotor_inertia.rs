//! Rotor inertia: `Jm·m̈`.

use crate::chain::effect::expression::{Expression, Variable};
use crate::chain::effect::fitted_effect::FittedEffect;
use crate::chain::effect::knowledge::{Change, Drawn, JointTerm, Knowledge, Sizes, Trial, drawn};
use crate::chain::effect::site::Site;
use crate::chain::effect::{
    Confounder, Contribution, Dependence, Effect, Law, Linearity, Needs, ParameterInfo, Power,
    Samples, Search, TorqueLaw, Unit,
};
use rand_chacha::ChaCha8Rng;

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "rotor_inertia",
    sentence: "Rotor and fast gear wheels are accelerated with the motor.",
    equation: "Jm·m̈",
    source: "Swevers, Verdonck, Naumer, Pieters and Biber 2002 eq. 6",
    parameters: &[ParameterInfo {
        name: "Jm",
        unit: Unit::Inertia,
        meaning: "inertia of rotor and gear, reflected to the joint",
        lower: 0.0,
        upper: f64::INFINITY,
        typical: 0.1,
        linearity: Linearity::Linear,
        search: Search::Typical,
    }],
    depends_on: &[Dependence::Acceleration],
    confounded_with: &[Confounder {
        with: "link inertia about the joint's axis",
        separated_by: "gravity or other axes, where the link's mass distribution enters another way",
    }],
    law: Law::Motor(&RotorInertia),
    needs: Needs::NOTHING,
    knowledge: Knowledge {
        finding: Some(finding),
        change: Some(Change {
            up: "rotor inertia up",
            down: "rotor inertia down",
        }),
        sizes: Sizes::First,
        trial: Trial::Drawn(sized),
        term: Some(JointTerm::RotorInertia),
        ..Knowledge::NONE
    },
};

fn finding(found: &FittedEffect<'_>) -> String {
    found.with(
        "has a rotor and gear whose inertia at the joint is",
        "Jm",
        "the model had none",
    )
}

fn sized(site: &Site, _: &mut ChaCha8Rng) -> Vec<Drawn> {
    vec![drawn("Jm", site.share * site.inertia)]
}

#[derive(Debug)]
struct RotorInertia;

impl TorqueLaw for RotorInertia {
    fn add(&self, samples: Samples<'_>, parameters: &[f64], out: &mut Contribution<'_>) {
        let [inertia] = *parameters else { return };
        for (k, a) in samples.acceleration.iter().enumerate() {
            out.torque[k] += inertia * a;
            out.by_parameter[0][k] = *a;
        }
    }

    fn power(&self) -> Power {
        Power::Exchanges
    }

    fn torque(&self) -> Expression {
        Expression::parameter(0) * Variable::Acceleration
    }
}
