//! The rival models of a design, with the values that they predict torques with.

use crate::chain::parameter::Role;
use crate::design::criterion::model_discrimination::{Rival, Rivals};
use crate::design::error::{DesignError, Unsuitable};
use crate::design::information::torque_laws::SMOOTHING;
use crate::design::inputs::prepared::Prepared;
use crate::design::inputs::request::{DesignRequest, RivalModel};
use crate::problem_file::choices::Criterion;

/// The rivals where the criterion is to tell them apart.
///
/// # Errors
/// No rival; faults of a rival's effects, values or earlier fit.
pub fn of<'a>(
    request: &DesignRequest<'_>,
    prepared: &'a Prepared,
) -> Result<Option<Rivals<'a>>, DesignError> {
    let criterion = &request.settings.criterion;
    if criterion.value != Criterion::Discriminate {
        return Ok(None);
    }
    if request.rivals.is_empty() {
        return Err(DesignError::unsuitable(
            &criterion.place,
            Unsuitable::NoRivals,
        ));
    }
    let models = request.rivals.iter().map(|one| rival(request, one));
    let models = models.collect::<Result<_, _>>()?;
    Ok(Some(Rivals {
        models,
        loads: &prepared.loads,
        noise: &prepared.noise,
    }))
}

/// A model with its values; where no fit states them, effects act with typical sizes.
fn rival(request: &DesignRequest<'_>, stated: &RivalModel) -> Result<Rival, DesignError> {
    let prepared = Prepared::of(request, &stated.model)?;
    let (model, mut values) = (prepared.model, prepared.values);
    if !stated.model.is_fitted {
        for (value, parameter) in values.iter_mut().zip(model.parameters()) {
            let of_effect = matches!(parameter.role, Role::Effect { .. });
            if of_effect && parameter.is_free() && *value == 0.0 {
                *value = parameter.scale;
            }
        }
    }
    for (joint, limits) in model.joints().iter().zip(&prepared.limits) {
        if let Some(width) = joint.width {
            values[width] = values[width].max(SMOOTHING * limits.velocity);
        }
    }
    let mut unknowns = prepared.base.kept();
    let all = model.parameters().iter().enumerate();
    unknowns.extend(
        all.filter(|(_, p)| p.is_nonlinear_unknown())
            .map(|(k, _)| k),
    );
    let rows = prepared.prior.rows().select_columns(&unknowns);
    Ok(Rival {
        name: stated.name.clone(),
        prior: rows.tr_mul(&rows),
        values,
        unknowns,
        model,
    })
}
