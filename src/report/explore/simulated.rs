//! Recordings of a simulation: the channels of the signal as written, noise and all, above the positions of their joints.

use crate::outcome::simulation::{RealisedNoise, Simulation};
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
        .filter_map(|noise| channel(noise, table, &thinning))
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

fn channel(noise: &RealisedNoise, table: &Written, thinning: &Thinning) -> Option<Channel> {
    let line = |panel, unit: &str, y: &[f64]| Line {
        panel,
        role: "simulated",
        unit: unit.to_string(),
        y: Quantised::of(&thinning.line(y)),
        levels: Vec::new(),
    };
    let mut lines = vec![line("signal", &noise.unit, table.column(&noise.channel)?)];
    // Columns of a joint end alike: i3 and q3.
    let joint = noise
        .channel
        .trim_start_matches(|c: char| !c.is_ascii_digit());
    let position = table.column(&format!("q{joint}"));
    lines.extend(position.map(|y| line("position", "rad or m", y)));
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
            header: ["t", "q3", "i3"].map(str::to_string).to_vec(),
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
            notes: Vec::new(),
        };
        let takes = takes(&simulation, &[table]);
        assert_eq!((takes.len(), takes[0].start), (1, 5.0));
        let panels: Vec<&str> = takes[0].channels[0].lines.iter().map(|l| l.panel).collect();
        assert_eq!(
            (takes[0].channels.len(), panels),
            (1, vec!["signal", "position"])
        );
    }
}
