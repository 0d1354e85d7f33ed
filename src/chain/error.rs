//! What can be wrong with a model.

use thiserror::Error;

/// A model that cannot be built or asked what it is asked.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ModelError {
    /// A name that no parameter bears.
    #[error("the model has no parameter `{name}`{}", nearest.as_ref().map(|n| format!("; did you mean `{n}`?")).unwrap_or_default())]
    UnknownParameter {
        /// As written.
        name: String,
        /// The name of a parameter most like it.
        nearest: Option<String>,
    },
    /// A centre of mass or an inertia about it is given without the mass, in which torques are not linear.
    #[error(
        "`{name}` can be fixed only together with the mass (and, for an inertia, the centre of mass) \
         of the same link: the torque is linear in mass, first moments and inertia about the origin"
    )]
    NeedsMass {
        /// The quantity as written.
        name: String,
    },
    /// A value outside of the parameter's limits.
    #[error("parameter `{name}` = {value} lies outside {lower} .. {upper}")]
    OutOfBounds {
        /// Name of the parameter.
        name: String,
        /// What was given, in its unit.
        value: f64,
        /// Its lower limit.
        lower: f64,
        /// Its upper limit.
        upper: f64,
    },
    /// An effect borrows a parameter of one that the joint does not have.
    #[error(
        "{joint}: `{effect}` takes a parameter of `{needs}`; list `{needs}` for this joint as well"
    )]
    NeedsEffect {
        /// Name of the joint.
        joint: String,
        /// Identifier of the effect.
        effect: &'static str,
        /// Identifier of the effect that is missing.
        needs: &'static str,
    },
    /// An effect knows the motion of a joint that the robot does not have.
    #[error("{joint}: `{effect}` knows the motion of joint `{needs}`, which is not there")]
    NeedsJoint {
        /// Name of the joint that has the effect.
        joint: String,
        /// Identifier of the effect.
        effect: &'static str,
        /// The joint as the effect names it.
        needs: &'static str,
    },
    /// V of `q = V m + offset` has no inverse.
    #[error("the coupling matrix cannot be inverted; its rows must be independent")]
    SingularCoupling,
}
