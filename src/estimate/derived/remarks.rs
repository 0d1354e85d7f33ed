//! Remarks on a fit in sentences: preprocessing, assumptions, lack of fit.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::model::Model;
use crate::estimate::derived::goodness_of_fit::tells_noise;
use crate::outcome::fit::{Fit, Preprocessing};
use crate::outcome::joint::JointFigures;
use crate::recording::experiment::Chosen;
use crate::recording::settings::Method;

/// Mean square of what a model leaves over that of the noise from which on the model misses as much as the noise is.
const AS_MUCH_AS_NOISE: f64 = 2.0;

/// Share of a signal that a model leaves where it explains nothing of weight: less than a tenth of its squares.
const NOTHING: f64 = 0.95;

/// What a model leaves beyond the noise, and signals of which it explains nothing: what intervals do not know of.
pub(in crate::estimate) fn misfit(joints: &[JointFigures]) -> Vec<String> {
    let listed = |figure: &dyn Fn(&JointFigures) -> Option<String>| -> Vec<String> {
        joints.iter().filter_map(figure).collect()
    };
    let left = listed(&|joint| {
        let lack = joint.lack_of_fit.filter(|lack| *lack > AS_MUCH_AS_NOISE)?;
        Some(format!("{:.1} times at {}", lack.sqrt(), joint.joint))
    });
    let unexplained = listed(&|joint| {
        (joint.relative_train > NOTHING).then(|| {
            let share = 100.0 * joint.relative_train;
            format!("{share:.0} % of its RMS are left at {}", joint.joint)
        })
    });
    let mut notes = Vec::new();
    if !left.is_empty() {
        notes.push(format!(
            "The model misses something: its errors are {} what the noise alone would make them, and intervals do not \
             count that. `exid check` looks for mistakes in the inputs, `exid diagnose` for the physics.",
            left.join(", ")
        ));
    }
    if !unexplained.is_empty() {
        notes.push(format!(
            "The model explains next to nothing of a signal: {}. Is it the right column?",
            unexplained.join(", ")
        ));
    }
    notes
}

/// What was done to the recordings before the fit, in words.
pub fn preprocessing(model: &Model, data: &Dataset) -> Vec<Preprocessing> {
    let mut lines = Vec::new();
    for recording in &data.recordings {
        lines.push(Preprocessing {
            recording: recording.name.clone(),
            channel: None,
            text: of_recording(recording),
        });
        for (joint, bandwidth) in model.joints().iter().zip(&recording.experiment.bandwidth) {
            if joint.locked {
                continue;
            }
            let chosen = match bandwidth.chosen {
                Chosen::Given => "given",
                Chosen::Data => "chosen from the data",
            };
            let text = match bandwidth.harmonics {
                Some(count) => format!(
                    "{count} harmonics, up to {:.4} Hz, {chosen}",
                    bandwidth.cutoff_hz
                ),
                None => format!(
                    "{} at {:.4} Hz, {chosen}{}",
                    match recording.experiment.method {
                        Method::Smoother => "smoothed",
                        _ => "low-pass",
                    },
                    bandwidth.cutoff_hz,
                    match bandwidth.reversals {
                        0 => String::new(),
                        count => format!(", wider about {count} reversals"),
                    }
                ),
            };
            lines.push(Preprocessing {
                recording: recording.name.clone(),
                channel: Some(joint.name.clone()),
                text,
            });
        }
    }
    lines
}

fn of_recording(recording: &Prepared) -> String {
    let experiment = &recording.experiment;
    let mut text = format!(
        "{} samples at {:.6} Hz",
        experiment.raw.t.len(),
        experiment.timing.rate_hz
    );
    if !experiment.timing.uniform {
        text.push_str(&format!(
            ", jitter {:.2} ms",
            1e3 * experiment.timing.jitter_rms_s
        ));
    }
    match &experiment.periods {
        Some(periods) => text.push_str(&format!(
            "; average over {} periods of {:.6} s, {}",
            periods.count,
            periods.period,
            match periods.chosen {
                Chosen::Given => "as given",
                Chosen::Data => "found in the motion, which repeats",
            }
        )),
        None => text.push_str(&format!(
            "; {} of the motion, the signal as recorded, {:.3} s dropped at both ends",
            match experiment.method {
                Method::Smoother => "fixed-interval smoother",
                _ => "zero-phase low-pass",
            },
            experiment.edge_s
        )),
    }
    if let (Some(noise), None) = (&experiment.noise, &experiment.periods) {
        text.push_str(&format!(
            ", the noise from periods of {:.6} s, which hold no whole number of samples",
            noise.period
        ));
    }
    if let Some(filter) = &experiment.parallel {
        text.push_str(&format!(
            "; low-pass at {:.4} Hz over the signal and every column of the model",
            filter.cutoff_hz()
        ));
    }
    if recording.stride > 1 {
        text.push_str(&format!("; every {}th row used", recording.stride));
    }
    text
}

/// What of the load the recordings leave open.
pub(in crate::estimate) fn undetermined_load(fit: &Fit) -> Option<String> {
    let open = &fit.payload.as_ref()?.undetermined;
    (!open.is_empty()).then(|| {
        format!(
            "The recordings do not determine {}, each by itself: rank {} of {}. The combinations that they do \
             determine are the base parameters. A load shows all of itself to a motion of the last axes together \
             with one axis before them that lifts it.",
            open.join(", "),
            fit.rank,
            fit.unknowns
        )
    })
}

/// What the reader of a result should know.
pub fn notes(model: &Model, data: &Dataset) -> Vec<String> {
    let mut notes = Vec::new();
    let remarks = data.recordings.iter().flat_map(|r| &r.experiment.remarks);
    notes.extend(remarks.cloned());
    let filtered = data
        .recordings
        .iter()
        .any(|r| r.experiment.parallel.is_some());
    if filtered {
        notes.push(
            "Errors are of low-passed signals, which hides what lies above the cut-off; the figures \
             named raw are of every recorded sample."
                .to_string(),
        );
    }
    if data.recordings.iter().all(|r| r.experiment.noise.is_none()) {
        let what = match tells_noise(model, data) {
            true => {
                "the noise is what successive samples differ by, and slower noise counts as lack of fit"
            }
            false => "nothing tells noise from lack of fit",
        };
        notes.push(format!(
            "No recording was averaged over periods of its motion, so {what}."
        ));
    }
    let assumed = model.joints().iter().any(|joint| joint.width.is_some());
    if assumed
        && model.joints().iter().all(|j| {
            j.width
                .is_none_or(|w| !model.parameters()[model.estimated_as(w)].is_free())
        })
    {
        notes.push(
            "The transition speed w of Coulomb friction is taken as given; left out of the problem, it is \
             estimated."
                .to_string(),
        );
    }
    notes
}
