//! Warming up: viscous friction changes by `gain·(1 − exp(−t/T))` of its value at the start.

use crate::chain::effect::expression::{Expression, Variable};
use crate::chain::effect::fitted_effect::FittedEffect;
use crate::chain::effect::knowledge::{Drawn, Knowledge, Sizes, Trial, drawn};
use crate::chain::effect::site::Site;
use crate::chain::effect::{
    Confounder, Contribution, Dependence, Effect, Lasts, Law, Memory, Needs, ParameterInfo, Power,
    Samples, Search, Span, TorqueLaw, Unit,
};
use crate::robot::random::between;
use rand_chacha::ChaCha8Rng;

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "thermal_drift",
    sentence: "Viscous friction changes while the gears warm up.",
    equation: "Fv·gain·(1 − exp(−t/time_constant))·v",
    source: "Bittencourt and Gunnarsson 2012 for friction over temperature; first-order warming",
    parameters: &[
        ParameterInfo::nonlinear(
            "gain",
            Unit::One,
            "relative change of viscous friction after a long time",
            Span {
                lower: -1.0,
                typical: 0.1,
                upper: 20.0,
            },
            Search::Typical,
        ),
        ParameterInfo::nonlinear(
            "time_constant",
            Unit::Time,
            "of the warming",
            Span {
                lower: 0.1,
                typical: 30.0,
                upper: 1e5,
            },
            Search::Duration(&[0.05, 0.15, 0.4, 1.0, 3.0]),
        ),
    ],
    depends_on: &[Dependence::Speed, Dependence::Time],
    confounded_with: &[Confounder {
        with: "viscous_friction",
        separated_by: "several periods of the same motion, not averaged",
    }],
    law: Law::Motor(&Warming),
    needs: Needs {
        memory: Memory::Time,
        borrows: &[("viscous_friction", "Fv")],
        lasts: Lasts::OneRecording,
        ..Needs::NOTHING
    },
    knowledge: Knowledge {
        finding: Some(finding),
        sizes: Sizes::First,
        trial: Trial::Drawn(sized),
        ..Knowledge::NONE
    },
};

fn finding(found: &FittedEffect<'_>) -> String {
    let who = &found.who;
    match (found.quantity("gain"), found.quantity("time_constant")) {
        (Some(gain), Some(time)) => format!(
            "Friction of {who} changes while the recording runs, by {gain} with a time constant of {time}: the joint warms up; the model's friction was constant"
        ),
        _ => format!(
            "Friction of {who} changes while the recording runs: the joint warms up; the model's friction was constant"
        ),
    }
}

fn sized(site: &Site, rng: &mut ChaCha8Rng) -> Vec<Drawn> {
    vec![
        drawn("gain", -(2.0 * site.share).min(0.8)),
        drawn("time_constant", between(rng, 0.2, 0.8) * site.duration),
    ]
}

#[derive(Debug)]
struct Warming;

impl TorqueLaw for Warming {
    fn add(&self, samples: Samples<'_>, parameters: &[f64], out: &mut Contribution<'_>) {
        let [gain, constant, viscous] = *parameters else {
            return;
        };
        for (k, (t, v)) in samples.time.iter().zip(samples.velocity).enumerate() {
            let left = (-t / constant).exp();
            let warmth = 1.0 - left;
            out.torque[k] += viscous * gain * warmth * v;
            out.by_parameter[0][k] = viscous * warmth * v;
            out.by_parameter[1][k] = -viscous * gain * left * t / constant.powi(2) * v;
            out.by_parameter[2][k] = gain * warmth * v;
        }
    }

    /// Beside viscous friction; alone it may give power.
    fn power(&self) -> Power {
        Power::Exchanges
    }

    fn torque(&self) -> Expression {
        let [gain, constant, viscous] = [0, 1, 2].map(Expression::parameter);
        let left = (-(Expression::from(Variable::Time) / constant)).exponential();
        viscous * gain * (Expression::from(1.0) - left) * Variable::Velocity
    }
}
