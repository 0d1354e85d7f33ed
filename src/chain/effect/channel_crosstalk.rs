//! Crosstalk of channels: the signal that is recorded of one joint has a share of that of another in it.
//!
//! ```text
//! y_i(recorded) = y_i + Σ_j x_ij y_j,   |x_ij| < 1/4
//! ```
//!
//! It is a property of the measurement: neither the torques of the motors nor the motion change with it. Where the effect is
//! listed for a joint, the shares of all others that have a channel are estimated. Cables and converters next to one another
//! hear far less than a quarter (-12 dB) of each other: what looks like more is something else, such as a coupling of the
//! motors, whose friction goes with the speed of another joint.

use crate::chain::effect::fitted_effect::FittedEffect;
use crate::chain::effect::kinematic_coupling::OTHER_JOINT;
use crate::chain::effect::knowledge::{Drawn, Knowledge, Sizes, Trial, drawn};
use crate::chain::effect::site::{Site, either_sign};
use crate::chain::effect::{
    Confounder, Dependence, Effect, Law, Linearity, Needs, ParameterInfo, Search, Unit,
};
use crate::chain::words::list;
use rand_chacha::ChaCha8Rng;

/// Largest share, either sign.
const MOST: f64 = 0.25;

/// Share of a neighbour's signal in a trial, per share of the usual torque: 0.2 where an effect takes half of that, the most
/// that badly shielded channels next to one another hear.
const PER_SHARE: f64 = 0.4;

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "channel_crosstalk",
    sentence: "The recorded signal of one joint has a share of another's in it: neighbouring cables, channels of one converter.",
    equation: "y_i(recorded) = y_i + Σ x_ij·y_j",
    source: "linear crosstalk of measuring channels: Ott 2009, Electromagnetic Compatibility Engineering, chapter 2",
    parameters: &[ParameterInfo {
        name: OTHER_JOINT,
        unit: Unit::One,
        meaning: "share of the other joint's signal in what is recorded of this joint",
        lower: -MOST,
        upper: MOST,
        typical: 0.05,
        linearity: Linearity::Nonlinear,
        search: Search::Typical,
    }],
    depends_on: &[Dependence::OtherJoints],
    confounded_with: &[Confounder {
        with: "kinematic_coupling",
        separated_by: "motion of the other joint alone, with reversals: a channel hears friction and rotor inertia of the other \
                       motor, and the joint stands still; a coupling carries the torque of the other link alone, or moves the joint",
    }],
    law: Law::Crosstalk,
    needs: Needs::NOTHING,
    knowledge: Knowledge {
        finding: Some(finding),
        sizes: Sizes::First,
        trial: Trial::Drawn(sized),
        ..Knowledge::NONE
    },
};

fn finding(found: &FittedEffect<'_>) -> String {
    let other = found.by.first();
    let share = other.and_then(|other| found.scaled(other, "%", |share| 100.0 * share));
    let share = share.unwrap_or_else(|| "a share".to_string());
    format!(
        "The channel of {} also records {share} of the signal of {}; the model took every channel for one joint's (this is a \
         fault of the measurement, not of the robot)",
        found.moved,
        list(&found.by)
    )
}

fn sized(site: &Site, rng: &mut ChaCha8Rng) -> Vec<Drawn> {
    vec![drawn(
        EFFECT.parameters[0].name,
        PER_SHARE * site.share * either_sign(rng),
    )]
}
