//! A window of a rollout, sample by sample, and the table of windows.

use crate::outcome::rollout::{Example, ExampleJoint};

/// Samples of an example that a result holds.
pub(super) const EXAMPLE_POINTS: usize = 160;

/// A window, sample by sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Window {
    /// `median` or `worst`.
    pub kind: &'static str,
    /// Name of the recording.
    pub recording: String,
    /// s in the recording.
    pub t: Vec<f64>,
    /// Joint by joint.
    pub joints: Vec<WindowJoint>,
}

/// Positions of one joint in a window.
#[derive(Debug, Clone, PartialEq)]
pub struct WindowJoint {
    /// Name of the joint.
    pub joint: String,
    /// rad or m.
    pub unit: &'static str,
    /// As recorded.
    pub recorded: Vec<f64>,
    /// Not a number without such a model, and where it is lost.
    pub before: Vec<f64>,
    /// By the final model; not a number where it is lost.
    pub after: Vec<f64>,
}

impl Window {
    /// Some of the samples, for the picture.
    pub(super) fn thinned(&self) -> Example {
        let every = self.t.len().div_ceil(EXAMPLE_POINTS);
        let thin = |x: &[f64]| -> Vec<f64> { x.iter().step_by(every).copied().collect() };
        let is_simulated = |x: &[f64]| x.iter().any(|value| value.is_finite());
        let start = self.t.first().copied().unwrap_or(0.0);
        Example {
            kind: self.kind.to_string(),
            recording: self.recording.clone(),
            start,
            t: self.t.iter().step_by(every).map(|t| t - start).collect(),
            joints: self
                .joints
                .iter()
                .map(|joint| ExampleJoint {
                    joint: joint.joint.clone(),
                    unit: joint.unit.to_string(),
                    recorded: thin(&joint.recorded),
                    before: match is_simulated(&joint.before) {
                        true => thin(&joint.before),
                        false => Vec::new(),
                    },
                    after: thin(&joint.after),
                })
                .collect(),
        }
    }
}

/// The table of the examples: which window, time, and recorded position, before and after of every joint.
pub fn table(examples: &[Window]) -> String {
    let mut text = String::from("recording,window,t");
    for joint in examples.first().map_or(&[][..], |w| &w.joints) {
        for quantity in ["recorded", "before", "after"] {
            text.push_str(&format!(",{}_{quantity}", joint.joint));
        }
    }
    text.push('\n');
    let number = |x: f64| {
        if x.is_finite() {
            format!("{x:.9}")
        } else {
            String::new()
        }
    };
    for window in examples {
        for (row, t) in window.t.iter().enumerate() {
            let name = window.recording.replace('"', "\"\"");
            text.push_str(&format!("\"{name}\",{},{t:.6}", window.kind));
            for joint in &window.joints {
                for series in [&joint.recorded, &joint.before, &joint.after] {
                    text.push_str(&format!(",{}", number(series[row])));
                }
            }
            text.push('\n');
        }
    }
    text
}
