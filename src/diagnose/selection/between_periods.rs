//! Effects that change from period to period, sought in the samples in the order of time, as averages hide them.

use crate::chain::dataset::Dataset;
use crate::chain::effect::{Catalogue, Memory};
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::fitting::fit_model;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::residuals::period_changes;
use crate::diagnose::selection::stepwise::{Rules, Selection, Stepwise};

/// Effects of time to look for where the recordings were averaged and change from period to period.
pub fn sought(data: &Dataset, catalogue: &Catalogue, rules: Rules<'_>) -> Option<Vec<String>> {
    let averaged = data
        .recordings
        .iter()
        .any(|r| r.experiment.periods.is_some());
    if !averaged || !period_changes::change(data, rules.significance) {
        return None;
    }
    let of_time = catalogue
        .effects()
        .iter()
        .filter(|e| e.needs.memory == Memory::Time);
    let wanted = of_time.map(|e| e.id.to_string()).filter(|id| {
        let listed = |ids: &[String]| ids.contains(id);
        rules.sought.is_none_or(listed)
    });
    let wanted: Vec<String> = wanted.collect();
    (!wanted.is_empty()).then_some(wanted)
}

/// The model that explains the averages, grown by what changes with time; `None` where nothing does.
pub fn found(
    context: &Context<'_>,
    full: &ModelFit,
    rules: Rules<'_>,
) -> Result<Option<Selection>, DiagnoseError> {
    let again = fit_model(context, &full.hypotheses, &full.warm_start())?;
    let stepwise = Stepwise {
        context,
        rules,
        progress: &|_| (),
    };
    let selection = stepwise.forward(again)?;
    let any = selection.steps.iter().any(|step| step.accepted);
    Ok(any.then_some(selection))
}
