//! The load as a body: what follows from its ten parameters beside the list of parameters.

use serde::{Deserialize, Serialize};

use crate::outcome::number;

/// A load with its principal axes, in the axes of its frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Load {
    /// Whether a body can have the estimated parameters: positive mass, and principal moments of which none
    /// exceeds the sum of the others. Absent where the recordings do not determine all ten.
    pub possible: Option<bool>,
    /// Moments of inertia about the principal axes through the centre of mass, the largest first.
    pub principal: Vec<PrincipalMoment>,
    /// Parameters of the load that the recordings do not determine, each by itself.
    pub undetermined: Vec<String>,
}

/// One principal moment, kg·m².
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PrincipalMoment {
    /// About the axis through the centre of mass.
    #[serde(with = "number::nullable")]
    pub value: f64,
    /// Absent where the recordings do not determine it.
    #[serde(with = "number::optional")]
    pub std_dev: Option<f64>,
    /// 95 % confidence interval, lower and upper end.
    #[serde(with = "number::interval")]
    pub ci95: Option<[f64; 2]>,
    /// Unit vector; its largest component is positive.
    pub axis: [f64; 3],
}
