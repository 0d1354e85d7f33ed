//! Effects that change from period to period, sought in the samples in the order of time, as averages hide them.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::effect::{Catalogue, Memory};
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::fitting::fit_model;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::residuals::period_changes;
use crate::diagnose::selection::stepwise::{Rules, Selection, Stepwise};
use crate::recording::successive_periods::successive_periods as unrolled_experiment;

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

/// The recordings with their periods one after another. The noise of samples as they were recorded is each row's own,
/// so that every row is used; a filter leaves neighbours alike.
pub fn successive_periods(data: &Dataset) -> Dataset {
    let of = |recording: &Prepared| match unrolled_experiment(&recording.experiment) {
        Some(experiment) => {
            let prepare = match experiment.parallel {
                Some(_) => Prepared::new,
                None => Prepared::with_all_rows,
            };
            let name = recording.name.clone();
            let rows = experiment.rows();
            let commands = recording.commands().map(|all| all.repeated(rows));
            prepare(name, recording.split, recording.loaded, experiment).with_commands(commands)
        }
        None => recording.clone(),
    };
    Dataset {
        recordings: data.recordings.iter().map(of).collect(),
    }
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
