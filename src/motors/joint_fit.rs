//! Steady parts of recordings, and the constants of one joint that follow from them.

use crate::motors::compare::Constant;
use crate::motors::constants::{FirstStage, InverseConstant, Part, SecondStage};
use crate::motors::segments::Segment;
use crate::recording::split::Split;

/// The steady parts of one recording.
pub(super) struct Steady {
    pub name: String,
    pub split: Split,
    pub time: Vec<f64>,
    pub segments: Vec<Segment>,
    pub parts: Vec<Part>,
}

/// The constants of one joint.
pub(super) struct JointFit {
    /// Index in the tree.
    pub index: usize,
    pub name: String,
    /// Unit of its torques, N·m or N.
    pub torque_unit: &'static str,
    pub position_unit: &'static str,
    pub parts: Vec<Part>,
    pub stage: FirstStage,
    pub constant: Source,
    pub friction: Option<SecondStage>,
    /// Gravity is parallel to the axis, so that no load acts on the joint.
    pub vertical: bool,
}

/// What the torque constant rests on; values are of k_ct, N·m/A, with its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Source {
    Data(Constant),
    Given(f64),
    SameType(Constant),
    Undetermined,
}

impl Source {
    pub fn constant(self) -> Option<Constant> {
        match self {
            Self::Data(constant) | Self::SameType(constant) => Some(constant),
            Self::Given(value) => Some((value, 0.0)),
            Self::Undetermined => None,
        }
    }

    /// a = 1/k_ct with its variance, for the second stage; 0 where nothing is known and nothing needed.
    pub fn inverse(self) -> InverseConstant {
        let (value, variance) = match self.constant() {
            Some((k, sigma)) => (1.0 / k, (sigma / (k * k)).powi(2)),
            None => (0.0, 0.0),
        };
        InverseConstant { value, variance }
    }
}
