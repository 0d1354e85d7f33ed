//! What the page lets its reader explore: lines over time, residuals over what they may depend on, spectra and postures, in few bytes.
//!
//! The script of the page (`src/report/page/`) reads it as JSON; all numbers of samples are in base 64.

pub(super) mod designed;
mod encoded;
mod forward;
mod law;
pub(super) mod parts;
mod posture;
mod predicted;
mod simulated;
mod spectrum;
mod thinned;

use serde::Serialize;

use crate::outcome::skeleton::Skeleton;
use crate::outcome::{Outcome, Part};
use crate::report::explore::parts::{Correlations, Take};
use crate::report::written::Tables;

/// All that can be explored; default where there is nothing.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub(super) struct Exploration {
    /// Absent where the robot cannot be drawn.
    skeleton: Option<Skeleton>,
    takes: Vec<Take>,
    correlations: Option<Correlations>,
}

/// Most parameters of the picture: more would be less than a few pixels each.
const MOST_CORRELATED: usize = 150;

impl Exploration {
    /// All that the outcome and the tables beside it have to explore.
    pub fn of(outcome: &Outcome, tables: &Tables) -> Self {
        let skeleton = match &outcome.part {
            Part::Design(design) => design.skeleton.clone(),
            Part::Rollout(rollout) => rollout.skeleton.clone(),
            _ => outcome.machine().map(Skeleton::from),
        };
        let takes = match &outcome.part {
            Part::Design(design) => designed::takes(design, skeleton.as_ref()),
            Part::Rollout(rollout) => forward::takes(rollout, skeleton.as_ref()),
            Part::Simulate(simulation) => simulated::takes(simulation, &tables.written),
            _ => predicted::takes(outcome, &tables.predictions),
        };
        Self {
            skeleton: skeleton.filter(|_| takes.iter().any(|take| take.postures.is_some())),
            takes,
            correlations: correlations(outcome),
        }
    }

    /// Whether there are lines to explore.
    pub fn has_takes(&self) -> bool {
        !self.takes.is_empty()
    }

    /// Whether there are correlations to show.
    pub fn has_correlations(&self) -> bool {
        self.correlations.is_some()
    }

    /// As JSON that may stand in an element of HTML: no sign of it ends the element.
    pub fn json(&self) -> String {
        let json = serde_json::to_string(self).unwrap_or_default();
        json.replace('<', "\\u003c")
    }
}

fn correlations(outcome: &Outcome) -> Option<Correlations> {
    let covariance = &outcome.estimate.covariance;
    let deviations: Vec<f64> = (0..covariance.matrix.len())
        .map(|k| covariance.matrix[k].get(k).map_or(f64::NAN, |v| v.sqrt()))
        .collect();
    let kept: Vec<usize> = (0..covariance.parameters.len())
        .filter(|&k| deviations.get(k).is_some_and(|d| *d > 0.0 && d.is_finite()))
        .take(MOST_CORRELATED)
        .collect();
    let share = |a: usize, b: usize| {
        let value = covariance.matrix[a].get(b).copied().unwrap_or(0.0);
        (value / (deviations[a] * deviations[b])).clamp(-1.0, 1.0)
    };
    let entries = kept.iter().flat_map(|&a| kept.iter().map(move |&b| (a, b)));
    (kept.len() > 1).then(|| Correlations {
        names: kept
            .iter()
            .map(|&k| covariance.parameters[k].clone())
            .collect(),
        rows: encoded::hundredths(entries.map(|(a, b)| share(a, b))),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_text_of_users_ends_the_element_that_holds_the_data() {
        let exploration = Exploration {
            correlations: Some(Correlations {
                names: vec!["</script><b>".to_string()],
                rows: String::new(),
            }),
            ..Exploration::default()
        };
        let json = exploration.json();
        assert!(!json.contains('<'));
        let read: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!(read["correlations"]["names"][0], "</script><b>");
    }
}
