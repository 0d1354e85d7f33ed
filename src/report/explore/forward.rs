//! Windows of a rollout: positions as recorded and as models give them when they are simulated forward.

use crate::outcome::rollout::{Example, ExampleJoint, Rollout};
use crate::outcome::skeleton::Skeleton;
use crate::report::explore::encoded::{Quantised, floats};
use crate::report::explore::parts::{Channel, Line, Take};
use crate::report::explore::posture::Postures;

/// One take for each window that the result keeps.
pub(super) fn takes(rollout: &Rollout, skeleton: Option<&Skeleton>) -> Vec<Take> {
    let shown = rollout
        .examples
        .iter()
        .filter(|window| !window.t.is_empty());
    shown.map(|window| take(window, skeleton)).collect()
}

fn take(window: &Example, skeleton: Option<&Skeleton>) -> Take {
    let postures = skeleton.and_then(|skeleton| {
        Postures::new(skeleton, &window.t, |name| {
            let own = window.joints.iter().find(|joint| joint.joint == name)?;
            Some(&own.recorded)
        })
    });
    Take {
        name: window.recording.clone(),
        kind: format!("{} window", window.kind),
        start: window.start,
        t: floats(window.t.iter().copied()),
        channels: window.joints.iter().map(channel).collect(),
        postures,
    }
}

fn channel(joint: &ExampleJoint) -> Channel {
    let models = [("declared", &joint.before), ("final", &joint.after)];
    let models = || {
        models
            .iter()
            .filter(|(_, y)| y.iter().any(|value| value.is_finite()))
    };
    let line = |panel, role, y: &[f64]| Line {
        panel,
        role,
        unit: joint.unit.clone(),
        y: Quantised::of(y),
        levels: Vec::new(),
    };
    let mut lines = vec![line("position", "recorded", &joint.recorded)];
    lines.extend(models().map(|(role, y)| line("position", role, y)));
    lines.extend(models().map(|(role, y)| {
        let error: Vec<f64> = y.iter().zip(&joint.recorded).map(|(m, r)| m - r).collect();
        line("error", role, &error)
    }));
    Channel {
        name: joint.joint.clone(),
        lines,
        cloud: None,
        spectrum: None,
    }
}
