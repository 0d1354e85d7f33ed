//! An unknown factor of the torque constant: `true constant = gain · declared constant`.

use crate::chain::effect::fitted_effect::FittedEffect;
use crate::chain::effect::knowledge::{Change, Drawn, Knowledge, Sizes, Trial, drawn};
use crate::chain::effect::site::{Site, either_sign};
use crate::chain::effect::{
    Confounder, Dependence, Effect, Law, Linearity, Needs, ParameterInfo, Search, Unit,
};
use crate::chain::signal::Signal;
use rand_chacha::ChaCha8Rng;

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "drive_gain",
    sentence: "The true torque constant differs from the declared one by a factor.",
    equation: "s = τ_mot / (k·gain)",
    source: "Gautier and Briot 2014, global identification of drive gains",
    parameters: &[ParameterInfo {
        name: "gain",
        unit: Unit::One,
        meaning: "true over declared torque constant",
        lower: 0.05,
        upper: 20.0,
        typical: 1.0,
        linearity: Linearity::Nonlinear,
        search: Search::Typical,
    }],
    depends_on: &[Dependence::Load],
    confounded_with: &[Confounder {
        with: "all parameters that are free, scaled together",
        separated_by: "a known load, known link inertials or a known rotor inertia",
    }],
    law: Law::Gain,
    needs: Needs::NOTHING,
    knowledge: Knowledge {
        finding: Some(finding),
        change: Some(Change {
            up: "torque constant up",
            down: "torque constant down",
        }),
        sizes: Sizes::Of {
            names: &["gain"],
            nothing: 1.0,
        },
        trial: Trial::Drawn(sized),
        ..Knowledge::NONE
    },
};

/// A torque sensor has no torque constant.
fn finding(found: &FittedEffect<'_>) -> String {
    let who = &found.who;
    let factor = found.quantity("gain");
    if found.signal == Signal::PositionCommand {
        let factor = factor.map_or_else(|| "not one times".to_string(), |f| format!("{f} times"));
        return format!("The gains of the controller of {who} are {factor} the declared ones");
    }
    let is_current = found.signal == Signal::Current;
    match (is_current, factor) {
        (true, Some(factor)) => {
            format!("The torque constant of {who} is {factor} times the declared one")
        }
        (true, None) => format!("The torque constant of {who} is not the declared one"),
        (false, Some(factor)) => format!("The torque of {who} is {factor} times the recorded one"),
        (false, None) => format!("The torque of {who} is not the recorded one"),
    }
}

fn sized(site: &Site, rng: &mut ChaCha8Rng) -> Vec<Drawn> {
    vec![drawn("gain", 1.0 + site.share * either_sign(rng))]
}
