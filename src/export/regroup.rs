//! Regrouped bodies with the same joint torques and as few parameters as possible: every parameter that is not a base
//! parameter moves into those that are, `π_kept ← π_kept + C π_dependent` (Khalil and Kleinfinger 1987).
//!
//! They are no bodies any more, but their inverse dynamics takes about half the operations.

use crate::chain::base_parameters::BaseParameters;
use crate::chain::error::ModelError;
use crate::chain::model::{Model, ModelSettings, Signal};
use crate::robot::tree::Tree;
use nalgebra::DMatrix;

/// Parameters of all links (10 n) that give the same joint torques as the tree's own in every motion.
///
/// # Errors
/// None that the tree can cause: its model has neither drives nor couplings.
pub fn minimal(tree: &Tree) -> Result<Vec<f64>, ModelError> {
    let model = Model::new(ModelSettings::bodies(tree.clone(), Signal::Torque))?;
    let count = model.parameters().len();
    let base = BaseParameters::structural(&model, &[false], &DMatrix::zeros(0, count));
    let given = tree.parameters();
    let mut minimal = vec![0.0; count];
    for combination in &base.base {
        let others = combination.others.iter();
        let moved: f64 = others.map(|&(k, coefficient)| coefficient * given[k]).sum();
        minimal[combination.parameter] = given[combination.parameter] + moved;
    }
    Ok(minimal)
}
