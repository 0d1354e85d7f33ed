//! A model reduced to its rigid bodies, without drives.

use crate::chain::error::ModelError;
use crate::chain::model::{Model, ModelSettings, Signal};

/// The bodies of a model alone, under another signal: no drives, the same inertials known.
///
/// # Errors
/// None that a model which exists can cause.
pub fn rigid_bodies_only(model: &Model, signal: Signal) -> Result<Model, ModelError> {
    let joints = model.joints();
    let mut alone = Model::new(ModelSettings {
        offset: Some(model.offset().as_slice().to_vec()),
        payload: model.payload().map(|(payload, _)| payload),
        locked: joints.iter().map(|joint| joint.locked).collect(),
        ..ModelSettings::bodies(model.tree().clone(), signal)
    })?;
    for parameter in model.parameters().iter().filter(|p| !p.is_free()) {
        if let Some(position) = alone.position(&parameter.name) {
            alone.fix(position, parameter.value)?;
        }
    }
    Ok(alone)
}
