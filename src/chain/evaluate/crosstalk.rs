//! Channels that record shares of the signals of others, `s_i = y_i + Σ x_ij y_j`, and ∂s_i/∂x_ij = y_j.

use crate::chain::crosstalk::Heard;
use crate::chain::evaluate::Evaluator;

/// The signal of a joint before its channel hears another.
struct Source {
    joint: usize,
    signal: Vec<f64>,
    /// Column and series of each derivative that there is.
    derivatives: Vec<(usize, Vec<f64>)>,
}

impl Evaluator<'_> {
    /// Whether the signal of a channel is asked for, or is in another one that is.
    pub(super) fn is_needed(&self, channel: usize) -> bool {
        let is_in =
            |(heard, _): &(Heard, usize)| heard.source == channel && self.wanted[heard.channel];
        self.wanted[channel] || self.heard.iter().any(is_in)
    }

    /// Adds the shares of other signals to those that are asked for.
    pub(super) fn hear_others(&mut self, samples: usize) {
        let heard: Vec<(Heard, usize)> = self
            .heard
            .iter()
            .copied()
            .filter(|(h, _)| self.wanted[h.channel])
            .collect();
        let mut sources: Vec<Source> = Vec::new();
        for (Heard { source, .. }, _) in &heard {
            if sources.iter().all(|known| known.joint != *source) {
                sources.push(self.source(*source, samples));
            }
        }
        for (Heard { channel, source }, at) in heard {
            let Some(of) = sources.iter().find(|of| of.joint == source) else {
                continue;
            };
            let share = self.values[at];
            let pairs = self.block.values[channel].iter_mut().zip(&of.signal);
            pairs.for_each(|(to, y)| *to += share * y);
            for (column, series) in &of.derivatives {
                self.block.add_scaled(channel, *column, share, series);
            }
            if let Some(column) = self.column[at] {
                self.block.add_scaled(channel, column, 1.0, &of.signal);
            }
        }
    }

    fn source(&mut self, joint: usize, samples: usize) -> Source {
        let derivatives = (0..self.block.columns).filter_map(|column| {
            let series = self.block.lend(joint, column);
            let kept = series
                .get(..samples)
                .map(|series| (column, series.to_vec()));
            self.block.give_back(joint, column, series);
            kept
        });
        Source {
            joint,
            derivatives: derivatives.collect(),
            signal: self.block.values[joint][..samples].to_vec(),
        }
    }
}
