//! What changes from period to period: averages hide it, so it is sought in the samples in the order of time.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::effect::{EFFECTS, Memory};
use crate::diagnose::bench::Bench;
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::periods;
use crate::diagnose::refit::{Refit, refit};
use crate::diagnose::search::{Grown, Rules, grow};
use crate::recording::unrolled::unrolled as unrolled_experiment;

/// Effects of time to look for where the recordings were averaged and change from period to period.
pub fn sought(data: &Dataset, rules: Rules<'_>) -> Option<Vec<String>> {
    let averaged = data
        .recordings
        .iter()
        .any(|r| r.experiment.periods.is_some());
    if !averaged || !periods::change(data, rules.significance) {
        return None;
    }
    let of_time = EFFECTS.iter().filter(|e| e.needs.memory == Memory::Time);
    let wanted = of_time.map(|e| e.id.to_string()).filter(|id| {
        let listed = |ids: &[String]| ids.contains(id);
        rules.sought.is_none_or(listed)
    });
    let wanted: Vec<String> = wanted.collect();
    (!wanted.is_empty()).then_some(wanted)
}

/// The recordings with their periods one after another. The noise of samples as they were recorded is each row's own,
/// so that every row is used; a filter leaves neighbours alike.
pub fn unrolled(data: &Dataset) -> Dataset {
    let of = |recording: &Prepared| match unrolled_experiment(&recording.experiment) {
        Some(experiment) => {
            let prepare = match experiment.parallel {
                Some(_) => Prepared::new,
                None => Prepared::with_all_rows,
            };
            let name = recording.name.clone();
            prepare(name, recording.split, recording.loaded, experiment)
        }
        None => recording.clone(),
    };
    Dataset {
        recordings: data.recordings.iter().map(of).collect(),
    }
}

/// The model that explains the averages, grown by what changes with time; `None` where nothing does.
pub fn found(
    bench: &Bench<'_>,
    (full, rules): (&Refit, Rules<'_>),
) -> Result<Option<Grown>, DiagnoseError> {
    let again = refit(bench, &full.hypotheses, (&full.start(), &full.deviations()))?;
    let grown = grow(bench, again, (rules, &|_| ()))?;
    let any = grown.steps.iter().any(|step| step.accepted);
    Ok(any.then_some(grown))
}
