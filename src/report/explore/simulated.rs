//! Recordings of a simulation: the channels of the signal as written, noise and all, above the positions of their joints.

use crate::outcome::simulation::{RealisedNoise, RecordedPosition, Simulation};
use crate::report::explore::encoded::{Quantised, floats};
use crate::report::explore::parts::{Channel, Line, Take};
use crate::report::explore::thinned::Thinning;
use crate::report::written::Written;

/// Points of a line at most: a hundred lines of them are half a megabyte.
const POINTS: usize = 2000;

/// One take for each recording that has times.
pub(super) fn takes(simulation: &Simulation, written: &[Written]) -> Vec<Take> {
    written
        .iter()
        .filter_map(|table| take(simulation, table))
        .collect()
}

fn take(simulation: &Simulation, table: &Written) -> Option<Take> {
    let t = table.column("t")?;
    let start = *t.first()?;
    let thinning = Thinning::new(t.len(), POINTS);
    let channels = simulation.realised_noise.iter();
    let channels: Vec<Channel> = channels
        .filter_map(|noise| {
            let mut positions = simulation.positions.iter();
            let position = positions.find(|position| position.channel == noise.channel);
            channel(noise, position, table, &thinning)
        })
        .collect();
    (!channels.is_empty()).then(|| Take {
        name: table.name.clone(),
        kind: "simulated".to_string(),
        start,
        t: floats(thinning.times(t).into_iter().map(|t| t - start)),
        channels,
        postures: None,
    })
}

fn channel(
    noise: &RealisedNoise,
    position: Option<&RecordedPosition>,
    table: &Written,
    thinning: &Thinning,
) -> Option<Channel> {
    let line = |panel, unit: &str, y: &[f64]| Line {
        panel,
        role: "simulated",
        unit: unit.to_string(),
        y: Quantised::of(&thinning.line(y)),
        levels: Vec::new(),
    };
    let mut lines = vec![line("signal", &noise.unit, table.column(&noise.channel)?)];
    if let Some(position) = position
        && let Some(recorded) = table.column(&position.column)
    {
        let y: Vec<f64> = recorded.iter().map(|x| position.factor * x).collect();
        lines.push(line("position", &position.unit, &y));
    }
    Some(Channel {
        name: noise.channel.clone(),
        lines,
        cloud: None,
        spectrum: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_channel_stands_above_the_position_of_its_joint() {
        let table = Written {
            name: "train.csv".to_string(),
            header: ["t", "lift", "i3"].map(str::to_string).to_vec(),
            columns: vec![vec![5.0, 6.0], vec![0.1, 0.2], vec![1.0, 2.0]],
        };
        let noise = |channel: &str| RealisedNoise {
            channel: channel.to_string(),
            unit: "A".to_string(),
            std_dev: 0.1,
        };
        let simulation = Simulation {
            files: Vec::new(),
            realised_noise: vec![noise("i3"), noise("i4")],
            positions: vec![RecordedPosition {
                joint: "spindle".to_string(),
                channel: "i3".to_string(),
                column: "lift".to_string(),
                unit: "m".to_string(),
                factor: 1e-3,
            }],
            notes: Vec::new(),
        };
        let takes = takes(&simulation, &[table]);
        assert_eq!((takes.len(), takes[0].start), (1, 5.0));
        let panels: Vec<&str> = takes[0].channels[0].lines.iter().map(|l| l.panel).collect();
        assert_eq!(
            (takes[0].channels.len(), panels),
            (1, vec!["signal", "position"])
        );
        assert_eq!(takes[0].channels[0].lines[1].unit, "m");
    }
}
