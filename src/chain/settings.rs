//! Settings of a model: the robot, its drives, the signal and the effects of every joint.

use crate::chain::controller::Controller;
use crate::chain::crosstalk::Heard;
use crate::chain::effect::{Catalogue, Effect, current_polynomial};
use crate::chain::sharing::Sharing;
pub use crate::chain::signal::Signal;
use crate::robot::inertia::{Inertia, PER_LINK};
use crate::robot::tree::Tree;
use nalgebra::{DMatrix, Isometry3, SMatrix};

/// A load on a link, in a frame that is fixed to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Payload {
    /// Position of the joint in the tree whose link carries it.
    pub link: usize,
    /// Placement of the load's frame in the link's frame.
    pub frame: Isometry3<f64>,
}

impl Payload {
    /// T with `π_link = T π_payload` (10 x 10): the load's parameters seen from the link's frame.
    pub fn transfer(&self) -> SMatrix<f64, PER_LINK, PER_LINK> {
        let rotation = self.frame.rotation.to_rotation_matrix();
        let mut transfer = SMatrix::<f64, PER_LINK, PER_LINK>::zeros();
        for k in 0..PER_LINK {
            let mut unit = Inertia::default();
            unit.0[k] = 1.0;
            let seen = unit.seen_from(&rotation, &self.frame.translation.vector);
            transfer.set_column(k, &SMatrix::<f64, PER_LINK, 1>::from(seen.0));
        }
        transfer
    }
}

/// Whether the links' inertial parameters are known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Inertials {
    /// They are unknown.
    Estimate,
    /// They are those of the tree.
    Known,
}

/// What a model is built from; arrays have one entry per joint.
#[derive(Debug, Clone)]
pub struct ModelSettings {
    /// The moving joints with their links.
    pub tree: Tree,
    /// What is measured.
    pub signal: Signal,
    /// Whether the links' parameters are unknown.
    pub inertials: Inertials,
    /// Position controllers, where the signal is their error.
    pub controllers: Option<Vec<Controller>>,
    /// N·m/A at joint scale; `None` where the signal is a torque.
    pub torque_constant: Option<Vec<f64>>,
    /// Relative standard deviations of the torque constants.
    pub torque_constant_std: Option<Vec<f64>>,
    /// c0 to c3 of the torque in powers of the current, instead of the torque constant.
    pub current_polynomial: Option<Vec<[f64; current_polynomial::COEFFICIENTS]>>,
    /// Known rotor inertias, kg·m² at joint scale.
    pub rotor_inertia: Option<Vec<f64>>,
    /// V of `q = V m + offset`; `None` is the identity.
    pub coupling: Option<DMatrix<f64>>,
    /// rad (m); `None` is zero.
    pub offset: Option<Vec<f64>>,
    /// The physics of every joint beside rigid bodies.
    pub effects: Vec<Vec<&'static Effect>>,
    /// Joints whose channels hear others, beside those that list the effect and hear all.
    pub crosstalk: Vec<Heard>,
    /// Effects whose parameters joints have in common.
    pub shared: Vec<Sharing>,
    /// The effects that it may have.
    pub catalogue: Catalogue,
    /// s, after which the motion is declared to repeat.
    pub period: Option<f64>,
    /// A load whose ten parameters are unknown.
    pub payload: Option<Payload>,
    /// Joints that stand still.
    pub locked: Vec<bool>,
}

impl ModelSettings {
    /// Bodies that are estimated and nothing else: no drive, no effect, no load, every joint free to move.
    pub fn bodies(tree: Tree, signal: Signal) -> Self {
        let n = tree.len();
        Self {
            tree,
            signal,
            inertials: Inertials::Estimate,
            controllers: None,
            torque_constant: None,
            torque_constant_std: None,
            current_polynomial: None,
            rotor_inertia: None,
            coupling: None,
            offset: None,
            effects: vec![Vec::new(); n],
            crosstalk: Vec::new(),
            shared: Vec::new(),
            catalogue: Catalogue::known(),
            period: None,
            payload: None,
            locked: vec![false; n],
        }
    }
}
