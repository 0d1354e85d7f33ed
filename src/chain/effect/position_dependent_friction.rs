//! Friction that is larger or smaller around one position: `dF·exp(−((m − m0)/width)²)·sign(v)`.

use crate::chain::effect::expression::{Expression, Variable};
use crate::chain::effect::fitted_effect::FittedEffect;
use crate::chain::effect::knowledge::{Drawn, Knowledge, Sizes, Trial, drawn};
use crate::chain::effect::site::Site;
use crate::chain::effect::{
    Confounder, Contribution, Dependence, Effect, Law, Needs, ParameterInfo, Power, Samples,
    Search, Span, TorqueLaw, Unit,
};
use crate::robot::random::between;
use rand_chacha::ChaCha8Rng;

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "position_dependent_friction",
    sentence: "Dry friction grows or shrinks over part of the range: a worn or tight spot, a rubbing cover.",
    equation: "dF·exp(−((q − q0)/width)²)·sign(v)",
    source: "a smooth bump of Coulomb friction; Armstrong-Hélouvry 1991 measured friction along the range of a PUMA",
    parameters: &[
        ParameterInfo::linear(
            "dF",
            Unit::Torque,
            "friction beyond Coulomb friction at q0",
            1.0,
        ),
        ParameterInfo::nonlinear(
            "q0",
            Unit::Position,
            "position of the spot",
            Span {
                lower: -1e3,
                typical: 0.5,
                upper: 1e3,
            },
            Search::Position(&[0.05, 0.15, 0.25, 0.35, 0.45, 0.55, 0.65, 0.75, 0.85, 0.95]),
        ),
        ParameterInfo::nonlinear(
            "width",
            Unit::Position,
            "distance at which the excess has fallen to 37 %",
            Span {
                lower: 1e-4,
                typical: 0.3,
                upper: 100.0,
            },
            Search::Range(&[0.05, 0.12, 0.3]),
        ),
    ],
    depends_on: &[Dependence::Position, Dependence::Direction],
    confounded_with: &[Confounder {
        with: "torque_ripple",
        separated_by: "motion over the same positions in both directions: ripple does not change sign",
    }],
    law: Law::Motor(&LocalFriction),
    needs: Needs::NOTHING,
    knowledge: Knowledge {
        finding: Some(finding),
        sizes: Sizes::First,
        trial: Trial::Drawn(sized),
        has_one_shape_of_many: true,
        ..Knowledge::NONE
    },
};

fn finding(found: &FittedEffect<'_>) -> String {
    found.with(
        "has a spot in its range where friction differs by",
        "dF",
        "the model's friction was the same everywhere",
    )
}

fn sized(site: &Site, rng: &mut ChaCha8Rng) -> Vec<Drawn> {
    vec![
        drawn("dF", site.torque()),
        drawn(
            "q0",
            site.middle + between(rng, -0.4, 0.4) * site.half_range,
        ),
        drawn("width", between(rng, 0.15, 0.4) * site.half_range),
    ]
}

#[derive(Debug)]
struct LocalFriction;

impl TorqueLaw for LocalFriction {
    fn add(&self, samples: Samples<'_>, parameters: &[f64], out: &mut Contribution<'_>) {
        let [df, q0, width] = *parameters else { return };
        for (k, (q, sign)) in samples.position.iter().zip(samples.sign).enumerate() {
            let x = (q - q0) / width;
            let bump = (-x * x).exp();
            out.torque[k] += df * bump * sign;
            out.by_sign[k] += df * bump;
            out.by_parameter[0][k] = bump * sign;
            out.by_parameter[1][k] = df * bump * sign * 2.0 * x / width;
            out.by_parameter[2][k] = df * bump * sign * 2.0 * x * x / width;
        }
    }

    /// dF may be negative, as long as Coulomb friction is larger.
    fn power(&self) -> Power {
        Power::Exchanges
    }

    fn torque(&self) -> Expression {
        let [df, q0, width] = [0, 1, 2].map(Expression::parameter);
        let ratio = (Expression::from(Variable::Position) - q0) / width;
        df * (-ratio.squared()).exponential() * Variable::Sign
    }
}
