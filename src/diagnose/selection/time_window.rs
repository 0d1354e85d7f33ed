//! Whether an effect with a beginning and an end has both within the recordings.

use crate::chain::effect::Search;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::ModelFit;

/// What is there for a larger share of a recording is an offset of all of it: the times at which it may begin and end
/// are tried a tenth of the duration apart, and are known to half of that where a search begins.
const WHOLE: f64 = 0.95;

/// Whether an effect that lasts from one instant to another is there for less than all of each recording; true of any
/// other effect.
pub fn is_shorter(context: &Context<'_>, fit: &ModelFit, hypothesis: &Hypothesis) -> bool {
    hypothesis.joints.iter().all(|&joint| {
        let parameters = fit.model.joints()[joint].parameters_of(hypothesis.effect.id);
        let instants = parameters.filter(|(info, _)| matches!(info.search, Search::Instant(_)));
        let instants: Vec<usize> = instants.map(|(_, at)| at).collect();
        let [from, to] = instants[..] else {
            return true;
        };
        (0..context.data.recordings.len()).all(|k| {
            let values = fit.values_in(context.data, k);
            let recording = &context.data.recordings[k];
            let (begin, end) = (recording.time(0), recording.time(recording.rows() - 1));
            let lasts = values[to].min(end) - values[from].max(begin);
            lasts < WHOLE * (end - begin)
        })
    })
}
