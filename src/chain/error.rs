//! What can be wrong with a model.

use thiserror::Error;

/// A model that cannot be built or asked what it is asked.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ModelError {
    #[error("the model has no parameter `{name}`{}", nearest.as_ref().map(|n| format!("; did you mean `{n}`?")).unwrap_or_default())]
    UnknownParameter {
        name: String,
        nearest: Option<String>,
    },
    #[error(
        "`{name}` can be fixed only together with the mass (and, for an inertia, the centre of mass) \
         of the same link: the torque is linear in mass, first moments and inertia about the origin"
    )]
    NeedsMass { name: String },
    #[error("parameter `{name}` = {value} lies outside {lower} .. {upper}")]
    OutOfBounds {
        name: String,
        value: f64,
        lower: f64,
        upper: f64,
    },
    #[error(
        "{joint}: `{effect}` takes a parameter of `{needs}`; list `{needs}` for this joint as well"
    )]
    NeedsEffect {
        joint: String,
        effect: &'static str,
        needs: &'static str,
    },
    #[error("{joint}: `{effect}` knows the motion of joint `{needs}`, which is not there")]
    NeedsJoint {
        joint: String,
        effect: &'static str,
        needs: &'static str,
    },
    #[error("the coupling matrix cannot be inverted; its rows must be independent")]
    SingularCoupling,
}
