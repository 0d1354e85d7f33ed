//! A delay of the signal: `s(t) = s_true(t − delay)`.

use crate::chain::effect::fitted_effect::FittedEffect;
use crate::chain::effect::knowledge::{Change, Drawn, Knowledge, Sizes, Trial, drawn};
use crate::chain::effect::site::Site;
use crate::chain::effect::{
    Confounder, Dependence, Effect, Law, Memory, Needs, ParameterInfo, Search, Span, Unit,
};
use crate::chain::signal::Signal;
use crate::chain::words::short;
use rand_chacha::ChaCha8Rng;

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "time_delay",
    sentence: "The torque channel is recorded late, or early, against the motion.",
    equation: "s(t) = s_true(t − delay)",
    source: "the motion at t − delay gives the signal at t",
    parameters: &[ParameterInfo::nonlinear(
        "delay",
        Unit::Time,
        "by which the signal is late",
        Span {
            lower: -0.5,
            typical: 0.005,
            upper: 0.5,
        },
        Search::Values(&[-0.02, 0.0, 0.02]),
    )],
    depends_on: &[Dependence::Time, Dependence::Acceleration],
    confounded_with: &[
        Confounder {
            with: "viscous_friction",
            separated_by: "fast motion: a delay of inertial torque grows with the rate of acceleration",
        },
        Confounder {
            with: "presliding_hysteresis",
            separated_by: "reversals at several rates",
        },
    ],
    law: Law::Delay,
    needs: Needs {
        memory: Memory::WholeMotion,
        ..Needs::NOTHING
    },
    knowledge: Knowledge {
        finding: Some(finding),
        change: Some(Change {
            up: "delay up",
            down: "delay down",
        }),
        sizes: Sizes::First,
        trial: Trial::Drawn(sized),
        ..Knowledge::NONE
    },
};

fn finding(found: &FittedEffect<'_>) -> String {
    let (who, delays) = (&found.who, found.values("delay"));
    let least = delays.iter().copied().fold(f64::INFINITY, f64::min);
    let most = delays.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let (sign, when) = match (least < 0.0, most <= 0.0) {
        (true, true) => (-1.0, "early"),
        (true, false) => (1.0, "late here and early there"),
        (false, _) => (1.0, "late"),
    };
    let by = match delays[..] {
        [] => String::new(),
        [_] => {
            let delay = found.scaled("delay", "ms", |s| sign * 1e3 * s);
            delay.map_or_else(String::new, |delay| format!(" by {delay}"))
        }
        // One clock may carry the channels of all joints, and each its own delay beside.
        _ => {
            let ends = [least, most].map(|s| sign * 1e3 * s);
            let (from, to) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            format!(" by {} to {} ms", short(from), short(to))
        }
    };
    if found.signal == Signal::PositionCommand {
        return format!("The command acts on {who} {when}{by}; the model took it to act at once");
    }
    format!(
        "The torque signal of {who} is {when}{by}; the model took motion and signal for simultaneous (this may be a mistake of the recording)"
    )
}

fn sized(site: &Site, _: &mut ChaCha8Rng) -> Vec<Drawn> {
    vec![drawn("delay", 0.05 * site.share)]
}
