//! Why a mechanism has no motion.

use thiserror::Error;

/// The first sample of a motion at which a mechanism has no position.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("sample {sample}: {error}")]
pub struct OpenLoop {
    /// Its index in the motion, from 0.
    pub sample: usize,
    /// Why there is no position.
    pub error: MechanismError,
}

/// A fault of a mechanism or of a position that it is asked for.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MechanismError {
    /// Fewer conditions than joints without a motor.
    #[error(
        "{conditions} conditions close the loops of {passive} joints without a motor: at least one moves \
         freely; list more closed joints or fewer passive ones"
    )]
    Loose {
        /// Independent rows of all conditions.
        conditions: usize,
        /// Joints without a motor.
        passive: usize,
    },
    /// A joint that is not in the tree, or listed twice.
    #[error("joint {joint} cannot be passive: the robot has {joints} joints, each is listed once")]
    NoSuchJoint {
        /// The index that was asked for.
        joint: usize,
        /// Joints of the tree.
        joints: usize,
    },
    /// The loops stay open.
    #[error(
        "the loops do not close at the motor positions {motors}: a gap of {gap:.3e} m or rad is left, so the \
         position lies outside of the workspace; check lengths, zero positions and signs"
    )]
    OutsideWorkspace {
        /// Positions of the motors, rad or m, as text.
        motors: String,
        /// The largest entry of g that is left, m or rad.
        gap: f64,
    },
    /// Passive joints that the motors do not hold.
    #[error(
        "the motor positions {motors} are singular: the least singular value of ∂g/∂q_p is {ratio:.1e} of the \
         largest, so the motors do not hold the mechanism there; keep away from it"
    )]
    Singular {
        /// Positions of the motors, rad or m, as text.
        motors: String,
        /// Least over largest singular value of ∂g/∂q_p.
        ratio: f64,
    },
    /// No lever reaches the platform.
    #[error(
        "chain {chain} does not reach the platform: its rod would have to be {needed:.4} m away from the \
         lever's circle; the pose lies outside of the workspace"
    )]
    OutOfReach {
        /// Number of the chain, from 1.
        chain: usize,
        /// What the rod is short of, beyond the lever's circle, m.
        needed: f64,
    },
    /// A length that no robot has.
    #[error("{name} = {value} is not a length; give a positive number of metres")]
    NotALength {
        /// What the length is of.
        name: &'static str,
        /// What was given, m.
        value: f64,
    },
}
