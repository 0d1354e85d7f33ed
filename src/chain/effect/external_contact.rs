//! A torque from one time to another: `torque·(S((t − from)/r) − S((t − to)/r))`, S the logistic function.

use crate::chain::effect::expression::{self, Expression, Variable};
use crate::chain::effect::fitted_effect::FittedEffect;
use crate::chain::effect::knowledge::{Drawn, Knowledge, Sizes, Trial, drawn};
use crate::chain::effect::site::{Site, either_sign};
use crate::chain::effect::{
    Confounder, Contribution, Dependence, Effect, Lasts, Law, Memory, Needs, ParameterInfo, Power,
    Samples, Search, Span, TorqueLaw, Unit,
};
use crate::chain::words::short;
use crate::robot::random::between;
use rand_chacha::ChaCha8Rng;

/// Time constant r of the rise and the fall, s: a contact of links and hands builds up within some
/// hundredths of a second.
const RISE: f64 = 0.01;

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "external_contact",
    sentence: "Something pushed against the robot for some time.",
    equation: "torque for from < t < to, 0 before and after",
    source: "De Luca and Mattone 2005 for contact as a residual of the model",
    parameters: &[
        ParameterInfo::nonlinear(
            "torque",
            Unit::Torque,
            "at the joint while the contact lasts",
            Span {
                lower: f64::NEG_INFINITY,
                typical: 1.0,
                upper: f64::INFINITY,
            },
            Search::Typical,
        ),
        ParameterInfo::nonlinear(
            "from",
            Unit::Time,
            "when the contact begins, from the start of the recording",
            Span {
                lower: -1e6,
                typical: 1.0,
                upper: 1e6,
            },
            Search::Instant(&[0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9]),
        ),
        ParameterInfo::nonlinear(
            "to",
            Unit::Time,
            "when the contact ends",
            Span {
                lower: -1e6,
                typical: 2.0,
                upper: 1e6,
            },
            Search::Instant(&[0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0]),
        ),
    ],
    depends_on: &[Dependence::Time],
    confounded_with: &[Confounder {
        with: "unmodelled_payload",
        separated_by: "a repetition of the same motion without contact",
    }],
    law: Law::Joint(&Contact),
    needs: Needs {
        memory: Memory::Time,
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
    let when = match (found.value("from"), found.value("to")) {
        (Some(from), Some(to)) => format!(" from {} s to {} s", short(from), short(to)),
        _ => String::new(),
    };
    let text = format!("was pushed by something during the recording{when}, with");
    found.with(&text, "torque", "the model moved freely")
}

fn sized(site: &Site, rng: &mut ChaCha8Rng) -> Vec<Drawn> {
    let from = between(rng, 0.1, 0.7) * site.duration;
    vec![
        drawn("torque", site.torque() * either_sign(rng)),
        drawn("from", from),
        drawn("to", from + between(rng, 0.04, 0.2) * site.duration),
    ]
}

#[derive(Debug)]
struct Contact;

/// The logistic function and its derivative.
fn logistic(x: f64) -> (f64, f64) {
    let e = (-x.abs()).exp();
    let (small, slope) = (e / (1.0 + e), e / (1.0 + e).powi(2));
    (if x >= 0.0 { 1.0 - small } else { small }, slope)
}

impl TorqueLaw for Contact {
    fn add(&self, samples: Samples<'_>, parameters: &[f64], out: &mut Contribution<'_>) {
        let [torque, from, to] = *parameters else {
            return;
        };
        for (k, t) in samples.time.iter().enumerate() {
            let (on, on_slope) = logistic((t - from) / RISE);
            let (off, off_slope) = logistic((t - to) / RISE);
            out.torque[k] += torque * (on - off);
            out.by_parameter[0][k] = on - off;
            out.by_parameter[1][k] = -torque * on_slope / RISE;
            out.by_parameter[2][k] = torque * off_slope / RISE;
        }
    }

    fn power(&self) -> Power {
        Power::Exchanges
    }

    fn torque(&self) -> Expression {
        let [torque, from, to] = [0, 1, 2].map(Expression::parameter);
        let since = |at| (Expression::from(Variable::Time) - at) / RISE;
        torque * (expression::logistic(since(from)) - expression::logistic(since(to)))
    }
}
