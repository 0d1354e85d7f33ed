//! Torque ripple: `amplitude·sin(order·m + phase) + amplitude2·sin(2·order·m + phase2)`.

use crate::chain::effect::expression::{Expression, Function, Variable};
use crate::chain::effect::fitted_effect::FittedEffect;
use crate::chain::effect::knowledge::{Drawn, Knowledge, Sine, Sizes, Trial, drawn};
use crate::chain::effect::site::Site;
use crate::chain::effect::{
    Confounder, Contribution, Dependence, Effect, Law, Needs, ParameterInfo, Power, Samples,
    Search, Span, TorqueLaw, Unit,
};
use crate::chain::words::short;
use crate::robot::random::between;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;

/// Quarter turns: a sine of either sign at these phases lies within 45° of any phase.
const PHASES: Search = Search::Values(&[0.0, std::f64::consts::FRAC_PI_2]);

/// What is eccentric at the joint has the order one, about which an estimate scatters by a few percent; what ends at this limit
/// repeats more rarely, and is no ripple.
const LEAST_ORDER: f64 = 0.95;

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "torque_ripple",
    sentence: "Torque varies with the position of the motor: cogging, commutation, teeth and eccentricity of gears.",
    equation: "amplitude·sin(order·q + phase) + amplitude2·sin(2·order·q + phase2)",
    source: "Gandhi, Ghorbel and Dabney 2002 for harmonic drives; the first two terms of its series",
    parameters: &[
        ParameterInfo::nonlinear(
            "order",
            Unit::Order,
            "cycles per turn of the joint, one at least: nothing in a gear repeats more rarely",
            Span {
                lower: LEAST_ORDER,
                typical: 20.0,
                upper: 1e5,
            },
            Search::Cycles,
        ),
        ParameterInfo::linear("amplitude", Unit::Torque, "of the first harmonic", 1.0),
        ParameterInfo::nonlinear(
            "phase",
            Unit::Angle,
            "of the first harmonic at q = 0",
            Span {
                lower: -10.0,
                typical: 0.5,
                upper: 10.0,
            },
            PHASES,
        ),
        ParameterInfo::linear("amplitude2", Unit::Torque, "of the second harmonic", 0.3),
        ParameterInfo::nonlinear(
            "phase2",
            Unit::Angle,
            "of the second harmonic at q = 0",
            Span {
                lower: -10.0,
                typical: 0.5,
                upper: 10.0,
            },
            PHASES,
        ),
    ],
    depends_on: &[Dependence::Position],
    confounded_with: &[
        Confounder {
            with: "joint_spring",
            separated_by: "motion over more than half a cycle",
        },
        Confounder {
            with: "gravity of the link",
            separated_by: "an order other than one, or poses in which gravity acts differently",
        },
    ],
    law: Law::Motor(&Ripple),
    needs: Needs::NOTHING,
    knowledge: Knowledge {
        finding: Some(finding),
        sizes: Sizes::Of {
            names: &["amplitude", "amplitude2"],
            nothing: 0.0,
        },
        trial: Trial::Drawn(sized),
        has_one_shape_of_many: true,
        sines: &[
            Sine {
                amplitude: "amplitude",
                phase: "phase",
            },
            Sine {
                amplitude: "amplitude2",
                phase: "phase2",
            },
        ],
        ..Knowledge::NONE
    },
};

fn finding(found: &FittedEffect<'_>) -> String {
    let size = |name: &str| found.value(name).map_or(0.0, f64::abs);
    let stands_out =
        !found.is_told_from_zero("amplitude") || size("amplitude2") > size("amplitude");
    let second = stands_out && found.is_told_from_zero("amplitude2");
    let (times, size) = match second {
        true => (2.0, "amplitude2"),
        false => (1.0, "amplitude"),
    };
    let text = match found.value("order") {
        Some(order) => format!(
            "has a torque that repeats {} times along its turn, of amplitude",
            short(times * order)
        ),
        None => "has a torque that repeats along its turn, of amplitude".to_string(),
    };
    found.with(&text, size, "the model had a smooth drive")
}

fn sized(site: &Site, rng: &mut ChaCha8Rng) -> Vec<Drawn> {
    let cycles = between(rng, 1.5, 20.0);
    vec![
        drawn("order", PI * cycles / site.half_range),
        drawn("amplitude", site.torque()),
        drawn("phase", between(rng, -PI, PI)),
        drawn("amplitude2", between(rng, 0.0, 0.5) * site.torque()),
        drawn("phase2", between(rng, -PI, PI)),
    ]
}

#[derive(Debug)]
struct Ripple;

impl TorqueLaw for Ripple {
    fn add(&self, samples: Samples<'_>, parameters: &[f64], out: &mut Contribution<'_>) {
        let [order, amplitude, phase, amplitude2, phase2] = *parameters else {
            return;
        };
        for (k, q) in samples.position.iter().enumerate() {
            let (first, first_slope) = (order * q + phase).sin_cos();
            let (second, second_slope) = (2.0 * order * q + phase2).sin_cos();
            out.torque[k] += amplitude * first + amplitude2 * second;
            out.by_parameter[0][k] =
                q * (amplitude * first_slope + 2.0 * amplitude2 * second_slope);
            out.by_parameter[1][k] = first;
            out.by_parameter[2][k] = amplitude * first_slope;
            out.by_parameter[3][k] = second;
            out.by_parameter[4][k] = amplitude2 * second_slope;
        }
    }

    fn power(&self) -> Power {
        Power::Exchanges
    }

    fn torque(&self) -> Expression {
        let [order, amplitude, phase, amplitude2, phase2] =
            [0, 1, 2, 3, 4].map(Expression::parameter);
        let turned = order * Variable::Position;
        amplitude * (turned.clone() + phase).call(Function::Sine)
            + amplitude2 * (turned * 2.0 + phase2).call(Function::Sine)
    }
}
