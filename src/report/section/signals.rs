//! Recorded and predicted signals: held-out recordings first, the first one unfolded.

use crate::recording::split::Split;
use crate::report::escape::escape;
use crate::report::explore::parts::RECORDINGS;
use crate::report::facts::count;
use crate::report::plots::scatter::scatter;
use crate::report::plots::signals::signals;
use crate::report::plots::{PREDICTED, RECORDED, RESIDUAL, figure, key};
use crate::report::section::explorer::explorer;
use crate::report::section::{Section, Source};
use crate::report::series::{JointSeries, RecordingSeries};

/// Recordings of which there are still pictures, which take more bytes than what the script draws.
const STILL: usize = 2;

pub(super) fn section(source: &Source) -> Option<Section> {
    let mut recordings: Vec<&RecordingSeries> = source.series.recordings.iter().collect();
    if recordings.is_empty() {
        return None;
    }
    recordings.sort_by_key(|recording| recording.split == Split::Train);
    let mut still = format!(
        "<p class=\"hint\">{}{}{} (prediction minus recording, on its own scale)</p>\n",
        key(RECORDED, "recorded"),
        key(PREDICTED, "predicted"),
        key(RESIDUAL, "residual")
    );
    for (index, recording) in recordings.iter().take(STILL).enumerate() {
        still.push_str(&block(source, recording, index));
    }
    let mut body = explorer(source, worst_joint(source), &still);
    if recordings.len() > RECORDINGS {
        let rest = count(recordings.len() - RECORDINGS, "further recording");
        body.push_str(&format!(
            "<p class=\"hint\">{rest} in predictions.csv.</p>\n"
        ));
    }
    Some(Section::new("signals", "Recorded and predicted", body))
}

/// The joint to look at first: that of the strongest finding, else the one that is predicted worst against its noise.
fn worst_joint<'a>(source: &Source<'a>) -> Option<&'a str> {
    if let Some(found) = source.diagnosis().and_then(|d| d.findings.first()) {
        return found.joints.first().map(String::as_str);
    }
    let joints = source.outcome.estimate.joints.iter();
    let judged = joints.filter_map(|joint| Some((joint.lack_of_fit?, joint)));
    judged
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, joint)| joint.joint.as_str())
}

fn block(source: &Source, recording: &RecordingSeries, index: usize) -> String {
    let split = match recording.split {
        Split::Train => "training",
        Split::Validation => "held out",
    };
    let open = if index == 0 { " open" } else { "" };
    let mut out = format!(
        "<details{open}><summary><b>{}</b> ({split})</summary>\n<div class=\"plots\">\n",
        escape(&recording.recording)
    );
    // A joint that has no rows in a recording, such as one that rests there, has nothing to show.
    let shown = |joint: &&JointSeries| joint.recorded.iter().any(|point| point.1.is_finite());
    for joint in recording.joints.iter().filter(shown) {
        let unit = unit(source, &joint.joint);
        let caption = format!("<b>{}</b> [{}]", escape(&joint.joint), escape(unit));
        let label = format!(
            "{} of {}, recorded and predicted",
            joint.joint, recording.recording
        );
        out.push_str(&figure(&caption, &signals(joint, &label)));
    }
    out.push_str("</div>\n");
    out.push_str(&over_speed(source, recording));
    out.push_str("</details>\n");
    out
}

/// Residuals over speed, of the joints whose speed was kept.
fn over_speed(source: &Source, recording: &RecordingSeries) -> String {
    let joints: Vec<&JointSeries> = recording
        .joints
        .iter()
        .filter(|joint| !joint.residual_of_speed.is_empty())
        .collect();
    if joints.is_empty() {
        return String::new();
    }
    let mut out = String::from("<h3>Residual over speed</h3>\n<div class=\"plots\">\n");
    for joint in joints {
        let unit = unit(source, &joint.joint);
        let caption = format!(
            "<b>{}</b> residual [{}]",
            escape(&joint.joint),
            escape(unit)
        );
        let label = format!(
            "{} of {}, residual over speed",
            joint.joint, recording.recording
        );
        out.push_str(&figure(
            &caption,
            &scatter(&joint.residual_of_speed, "joint speed dq", &label),
        ));
    }
    out.push_str("</div>\n");
    out
}

/// Unit of the signal of a joint.
fn unit<'a>(source: &Source<'a>, joint: &str) -> &'a str {
    let figures = source.outcome.estimate.joints.iter();
    figures
        .filter(|figures| figures.joint == joint)
        .map(|figures| figures.unit.as_str())
        .next()
        .unwrap_or_default()
}
