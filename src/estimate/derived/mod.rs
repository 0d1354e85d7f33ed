//! Derived quantities of an estimate: physical parameters and possible bodies, the load, joint torques from base reactions,
//! goodness of fit, comparison of models, and remarks.

pub mod goodness_of_fit;
pub mod load;
pub mod model_comparison;
pub mod physical;
pub mod pseudo_inertia;
pub mod reactions;
pub mod realization;
pub mod remarks;
