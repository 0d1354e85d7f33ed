//! A spring at the joint: `k·(q − q0)`.

use crate::chain::effect::expression::{Expression, Variable};
use crate::chain::effect::fitted_effect::FittedEffect;
use crate::chain::effect::knowledge::{Change, Drawn, JointTerm, Knowledge, Sizes, Trial, drawn};
use crate::chain::effect::site::Site;
use crate::chain::effect::{
    Confounder, Contribution, Dependence, Effect, Law, Needs, ParameterInfo, Power, Samples,
    Search, Span, TorqueLaw, Unit,
};
use crate::robot::random::between;
use rand_chacha::ChaCha8Rng;

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "joint_spring",
    sentence: "A spring pulls the joint towards one position: gravity compensator, hose, cable.",
    equation: "k·(q − q0)",
    source: "Hooke 1678",
    parameters: &[
        ParameterInfo::linear("k", Unit::TorquePerPosition, "stiffness", 10.0),
        ParameterInfo::nonlinear(
            "q0",
            Unit::Position,
            "position without torque",
            Span {
                lower: -1e3,
                typical: 0.1,
                upper: 1e3,
            },
            Search::Position(&[0.0, 0.5, 1.0]),
        ),
    ],
    depends_on: &[Dependence::Position],
    confounded_with: &[
        Confounder {
            with: "torque_ripple",
            separated_by: "motion over more than half a cycle of the ripple",
        },
        Confounder {
            with: "gravity of the link",
            separated_by: "motion over a wide range, or with other joints in other positions",
        },
    ],
    law: Law::Joint(&Spring),
    needs: Needs::NOTHING,
    knowledge: Knowledge {
        finding: Some(finding),
        change: Some(Change::both("spring or balancer")),
        sizes: Sizes::First,
        trial: Trial::Drawn(sized),
        term: Some(JointTerm::Spring),
        ..Knowledge::NONE
    },
};

fn finding(found: &FittedEffect<'_>) -> String {
    found.with(
        "is pulled by a spring of",
        "k",
        "the model had none: look for a gravity compensator, a hose or a cable",
    )
}

fn sized(site: &Site, rng: &mut ChaCha8Rng) -> Vec<Drawn> {
    vec![
        drawn("k", site.torque() / site.half_range),
        drawn(
            "q0",
            site.middle + between(rng, -1.0, 1.0) * site.half_range,
        ),
    ]
}

#[derive(Debug)]
struct Spring;

impl TorqueLaw for Spring {
    fn add(&self, samples: Samples<'_>, parameters: &[f64], out: &mut Contribution<'_>) {
        let [stiffness, rest] = *parameters else {
            return;
        };
        for (k, q) in samples.position.iter().enumerate() {
            out.torque[k] += stiffness * (q - rest);
            out.by_parameter[0][k] = q - rest;
            out.by_parameter[1][k] = -stiffness;
            out.by_position[k] += stiffness;
        }
    }

    fn power(&self) -> Power {
        Power::Exchanges
    }

    fn torque(&self) -> Expression {
        let [stiffness, rest] = [0, 1].map(Expression::parameter);
        stiffness * (Expression::from(Variable::Position) - rest)
    }
}
