//! Whether an effect with a beginning and an end has both within the recordings.

use crate::chain::effect::Search;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::ModelFit;

/// What is there for a larger share of the rows at which a joint moves is an offset of all of them: the times at which it may begin
/// and end are tried a tenth of the duration apart, and are known to half of that where a search begins.
const WHOLE: f64 = 0.95;

/// Whether an effect that lasts from one instant to another is there for less than all of what counts of each recording for
/// its joint; true of any other effect.
pub fn is_shorter(context: &Context<'_>, fit: &ModelFit, hypothesis: &Hypothesis) -> bool {
    hypothesis.joints.iter().all(|&joint| {
        let parameters = fit.model.joints()[joint].parameters_of(hypothesis.effect.id);
        let instants = parameters.filter(|(info, _)| matches!(info.search, Search::Instant(_)));
        let instants: Vec<usize> = instants.map(|(_, at)| at).collect();
        let [from, to] = instants[..] else {
            return true;
        };
        let mut channels = fit.model.channels().iter();
        let channel = channels.position(|channel| channel.joint == Some(joint));
        (0..context.data.recordings.len()).all(|k| {
            let values = fit.values_in(context.data, k);
            let recording = &context.data.recordings[k];
            let counts = |row: &usize| channel.is_none_or(|c| recording.counts_for(c, *row));
            let rows: Vec<usize> = (0..recording.rows()).filter(counts).collect();
            let instants = values[from]..=values[to];
            let within = rows
                .iter()
                .filter(|row| instants.contains(&recording.time(**row)));
            rows.is_empty() || (within.count() as f64) < WHOLE * rows.len() as f64
        })
    })
}
