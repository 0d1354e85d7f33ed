//! The zero of an encoder: the joint stands elsewhere than it is recorded, by a constant.
//!
//! ```text
//! q = V m + offset + encoder_offset,   ∂τ/∂encoder_offset = ∂τ/∂q
//! ```
//!
//! Torques show it by gravity and by what other joints' motions exert; of a first joint that stands vertical nothing
//! shows it. Of a last joint whose load has ten unknown parameters the load turned the other way is the same torque.

use crate::chain::effect::knowledge::{Change, Knowledge, Sizes};
use crate::chain::effect::{
    Confounder, Dependence, Effect, Law, Needs, ParameterInfo, Search, Span, Unit,
};

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "encoder_offset",
    sentence: "The encoder's zero is not where the model has it: a joint stands elsewhere than it is recorded.",
    equation: "q = V·m + offset + encoder_offset",
    source: "Hollerbach, Khalil and Gautier 2016, Springer Handbook of Robotics, chapter 6: joint offsets",
    parameters: &[ParameterInfo::nonlinear(
        "offset",
        Unit::Position,
        "by which the joint stands further than it is recorded",
        Span {
            lower: -std::f64::consts::PI,
            typical: 0.01,
            upper: std::f64::consts::PI,
        },
        Search::Values(&[0.0]),
    )],
    depends_on: &[Dependence::Gravity, Dependence::Position],
    confounded_with: &[
        Confounder {
            with: "base_tilt",
            separated_by: "motion of the joints before it, or of any where the joint is not the first",
        },
        Confounder {
            with: "first moments of the links, where they are unknown",
            separated_by: "links and load whose centres of mass are known",
        },
        Confounder {
            with: "torque_offset",
            separated_by: "motion over a wide range of positions",
        },
    ],
    law: Law::Encoder,
    needs: Needs::NOTHING,
    knowledge: Knowledge {
        change: Some(Change::both("encoder offset")),
        sizes: Sizes::First,
        ..Knowledge::NONE
    },
};
