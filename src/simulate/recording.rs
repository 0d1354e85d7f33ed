//! A simulated recording, or a simulated trajectory.

use crate::outcome::simulation::RealisedNoise;
use crate::simulate::sensors::Table;

/// One recording, or one trajectory.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulatedRecording {
    /// File in the results folder, relative to it.
    pub name: String,
    /// Time, motion and signal, as they are written.
    pub table: Table,
    /// What the table holds of noise, per channel of the signal.
    pub noise: Vec<Vec<f64>>,
}

impl SimulatedRecording {
    /// Takes the noise out of the channels, which are named in its order.
    pub fn remove_noise(&mut self, channels: &[RealisedNoise]) {
        for (channel, noise) in channels.iter().zip(std::mem::take(&mut self.noise)) {
            let column = self.table.header.iter().position(|h| *h == channel.channel);
            if let Some(column) = column {
                let pairs = self.table.data[column].iter_mut().zip(noise);
                pairs.for_each(|(to, x)| *to -= x);
            }
        }
    }
}
