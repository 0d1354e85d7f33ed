//! Keys whose value is one word of a fixed list: the words and what they mean.

/// One word of a fixed list.
pub trait Choice: Copy + PartialEq + 'static {
    /// What the word chooses, for messages: `estimator`.
    const NOUN: &'static str;
    /// Code of the error about a word that is not in the list.
    const CODE: &'static str;
    /// Every word and its meaning, in the order in which users see them.
    const WORDS: &'static [(&'static str, Self)];

    /// The word in the problem file.
    fn word(self) -> &'static str {
        Self::WORDS
            .iter()
            .find(|(_, choice)| *choice == self)
            .map_or("", |(word, _)| word)
    }
}

/// What the recordings hold beside the motion.
pub use crate::recording::samples::SignalKind as Signal;

impl Choice for Signal {
    const NOUN: &'static str = "signal";
    const CODE: &'static str = "unknown-signal";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("current", Self::Current),
        ("torque", Self::Torque),
        ("motor_torque", Self::MotorTorque),
        ("link_torque", Self::LinkTorque),
        ("base_wrench", Self::BaseWrench),
        ("both", Self::Both),
        ("position_command", Self::PositionCommand),
    ];
}

/// Where the encoder sits and in whose units it counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PositionSide {
    /// On the motor, given in joint units.
    Joint,
    /// On the motor, in the motor's own turns.
    Motor,
    /// Behind the gear.
    Link,
}

impl Choice for PositionSide {
    const NOUN: &'static str = "position side";
    const CODE: &'static str = "unknown-position-side";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("joint", Self::Joint),
        ("motor", Self::Motor),
        ("link", Self::Link),
    ];
}

/// How positions give velocities and accelerations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DifferentiationMethod {
    /// Fourier series of a periodic recording.
    Fourier,
    /// Fixed-interval smoother, whose bandwidth follows from the noise and the motion.
    Smoother,
    /// Zero-phase 4th-order Butterworth low-pass of the motion, forward and backward.
    Lowpass,
}

impl Choice for DifferentiationMethod {
    const NOUN: &'static str = "differentiation method";
    const CODE: &'static str = "unknown-differentiation-method";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("fourier", Self::Fourier),
        ("smoother", Self::Smoother),
        ("lowpass", Self::Lowpass),
    ];
}

/// How parameters follow from recordings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Estimator {
    /// Least squares in which every channel counts the same.
    OrdinaryLeastSquares,
    /// Least squares in which every channel counts by the deviation of its residual.
    WeightedLeastSquares,
    /// The same with Tukey's biweight of every residual.
    IterativelyReweightedLeastSquares,
    /// By the covariance of the noise across channels and frequencies.
    MaximumLikelihood,
    /// Least squares over parameters of bodies that can exist (semidefinite).
    Feasible,
    /// The same with the weights of maximum likelihood.
    FeasibleMaximumLikelihood,
    /// Motor constants from motions of one joint at constant speed.
    ConstantVelocity,
}

impl Choice for Estimator {
    const NOUN: &'static str = "estimator";
    const CODE: &'static str = "unknown-estimator";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("ols", Self::OrdinaryLeastSquares),
        ("wls", Self::WeightedLeastSquares),
        ("irls", Self::IterativelyReweightedLeastSquares),
        ("maximum_likelihood", Self::MaximumLikelihood),
        ("feasible", Self::Feasible),
        (
            "feasible_maximum_likelihood",
            Self::FeasibleMaximumLikelihood,
        ),
        ("constant_velocity", Self::ConstantVelocity),
    ];
}

/// How a feasible estimate keeps bodies possible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FeasibleBy {
    /// Semidefinite constraints.
    Cones,
    /// Coordinates in which every body is possible.
    LogCholesky,
}

impl Choice for FeasibleBy {
    const NOUN: &'static str = "way to a feasible estimate";
    const CODE: &'static str = "unknown-way-to-feasibility";
    const WORDS: &'static [(&'static str, Self)] =
        &[("cones", Self::Cones), ("log_cholesky", Self::LogCholesky)];
}

/// How a load follows from recordings with it and without it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoadFrom {
    /// One estimate of everything from all recordings.
    Together,
    /// The difference of two fits of the link that carries it.
    Difference,
}

impl Choice for LoadFrom {
    const NOUN: &'static str = "way to the load";
    const CODE: &'static str = "unknown-way-to-the-load";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("together", Self::Together),
        ("difference", Self::Difference),
    ];
}

/// Whether joint angles are free of noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// The Fourier series of the averaged angles is the motion.
    Exact,
    /// Its coefficients are estimated with the parameters, from angles and signals together.
    Noisy,
}

impl Choice for Motion {
    const NOUN: &'static str = "motion";
    const CODE: &'static str = "unknown-motion";
    const WORDS: &'static [(&'static str, Self)] =
        &[("exact", Self::Exact), ("noisy", Self::Noisy)];
}

/// What a prior on the parameters penalises.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PriorKind {
    /// Squared differences of the parameters.
    Euclidean,
    /// Bregman divergence of −log det of the pseudo-inertias.
    Entropic,
    /// Euclidean with the metric of the prior's own pseudo-inertias, constant.
    Pullback,
    /// Absolute values of the linear parameters, friction included.
    Lasso,
}

impl Choice for PriorKind {
    const NOUN: &'static str = "kind of prior";
    const CODE: &'static str = "unknown-prior-kind";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("euclidean", Self::Euclidean),
        ("entropic", Self::Entropic),
        ("pullback", Self::Pullback),
        ("lasso", Self::Lasso),
    ];
}

/// Whether link parameters are estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Inertials {
    /// Link parameters are unknown.
    Estimate,
    /// Link parameters are taken from the robot file.
    Known,
}

impl Choice for Inertials {
    const NOUN: &'static str = "treatment of the inertials";
    const CODE: &'static str = "unknown-inertials";
    const WORDS: &'static [(&'static str, Self)] =
        &[("estimate", Self::Estimate), ("known", Self::Known)];
}

/// A robot whose kinematics is written in the tool, not in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mechanism {
    /// The parallel robot H4.
    H4,
}

impl Choice for Mechanism {
    const NOUN: &'static str = "mechanism";
    const CODE: &'static str = "unknown-mechanism";
    const WORDS: &'static [(&'static str, Self)] = &[("h4", Self::H4)];
}

/// A joint that closes a loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ClosedJoint {
    /// One axis.
    Hinge,
    /// A ball joint.
    Ball,
    /// A massless rod with a ball joint at both ends.
    Rod,
}

impl Choice for ClosedJoint {
    const NOUN: &'static str = "closed joint";
    const CODE: &'static str = "unknown-closed-joint";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("hinge", Self::Hinge),
        ("ball", Self::Ball),
        ("rod", Self::Rod),
    ];
}

/// The family of motions among which a design searches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DesignKind {
    /// Finite Fourier series, periodic.
    Fourier,
    /// Strokes at constant velocity.
    ConstantVelocity,
}

impl Choice for DesignKind {
    const NOUN: &'static str = "kind of trajectory";
    const CODE: &'static str = "unknown-design-kind";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("fourier", Self::Fourier),
        ("constant_velocity", Self::ConstantVelocity),
    ];
}

/// What a design minimises, M the information matrix of the parameters of interest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Criterion {
    /// Condition number of the regressor.
    Condition,
    /// −log det M.
    DOptimal,
    /// trace M⁻¹.
    AOptimal,
    /// −λ_min(M).
    EOptimal,
    /// Distance between the predictions of rival models.
    Discriminate,
}

impl Choice for Criterion {
    const NOUN: &'static str = "criterion";
    const CODE: &'static str = "unknown-criterion";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("condition", Self::Condition),
        ("d_optimal", Self::DOptimal),
        ("a_optimal", Self::AOptimal),
        ("e_optimal", Self::EOptimal),
        ("discriminate", Self::Discriminate),
    ];
}

/// How the regressor is scaled before the criterion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scaling {
    /// Each column by its norm.
    Columns,
    /// The bare base regressor.
    None,
    /// Each row by the noise.
    Whitened,
}

impl Choice for Scaling {
    const NOUN: &'static str = "scaling";
    const CODE: &'static str = "unknown-scaling";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("columns", Self::Columns),
        ("none", Self::None),
        ("whitened", Self::Whitened),
    ];
}

/// How a simulation follows its trajectory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SimulationMode {
    /// The motion is the trajectory; the signal is what it takes.
    Inverse,
    /// Forward dynamics under a PD controller with feed-forward.
    ClosedLoop,
}

impl Choice for SimulationMode {
    const NOUN: &'static str = "mode";
    const CODE: &'static str = "unknown-simulation-mode";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("inverse", Self::Inverse),
        ("closed_loop", Self::ClosedLoop),
    ];
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_estimator_gives_its_word_back() {
        for (word, estimator) in Estimator::WORDS {
            assert_eq!(estimator.word(), *word);
        }
    }
}
