//! Why a mechanism has no motion.

use thiserror::Error;

/// The first sample of a motion at which a mechanism has no position.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("sample {sample}: {error}")]
pub struct OpenLoop {
    pub sample: usize,
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
    Loose { conditions: usize, passive: usize },
    /// A joint that is not in the tree, or listed twice.
    #[error("joint {joint} cannot be passive: the robot has {joints} joints, each is listed once")]
    NoSuchJoint { joint: usize, joints: usize },
    /// The loops stay open.
    #[error(
        "the loops do not close at the motor positions {motors}: a gap of {gap:.3e} m or rad is left, so the \
         position lies outside of the workspace; check lengths, zero positions and signs"
    )]
    OutsideWorkspace { motors: String, gap: f64 },
    /// Passive joints that the motors do not hold.
    #[error(
        "the motor positions {motors} are singular: the least singular value of ∂g/∂q_p is {ratio:.1e} of the \
         largest, so the motors do not hold the mechanism there; keep away from it"
    )]
    Singular { motors: String, ratio: f64 },
    /// No lever reaches the platform.
    #[error(
        "chain {chain} does not reach the platform: its rod would have to be {needed:.4} m away from the \
         lever's circle; the pose lies outside of the workspace"
    )]
    OutOfReach { chain: usize, needed: f64 },
    /// A length that no robot has.
    #[error("{name} = {value} is not a length; give a positive number of metres")]
    NotALength { name: &'static str, value: f64 },
}
