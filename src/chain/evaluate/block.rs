//! Values and derivatives of successive samples, channel by channel.

/// The signal of some samples and its derivatives.
#[derive(Debug, Clone)]
pub struct Block {
    room: usize,
    samples: usize,
    pub(super) columns: usize,
    pub(super) values: Vec<Vec<f64>>,
    /// `[channel · columns + column]`; empty where absent.
    pub(super) derivatives: Vec<Vec<f64>>,
}

impl Block {
    pub(super) fn new(channels: usize, columns: usize, room: usize) -> Self {
        Self {
            room,
            samples: 0,
            columns,
            values: vec![vec![0.0; room]; channels],
            derivatives: vec![Vec::new(); channels * columns],
        }
    }

    /// Predicted signal of a channel.
    pub fn value(&self, channel: usize) -> &[f64] {
        &self.values[channel][..self.samples]
    }

    /// ∂signal/∂parameter of a channel; `None` where it is zero whatever the motion.
    pub fn derivative(&self, channel: usize, column: usize) -> Option<&[f64]> {
        let series = &self.derivatives[channel * self.columns + column];
        series.get(..self.samples)
    }

    pub(super) fn clear(&mut self, samples: usize) {
        self.samples = samples;
        for value in &mut self.values {
            value.fill(0.0);
        }
        for series in &mut self.derivatives {
            series.fill(0.0);
        }
    }

    pub(super) fn series(&mut self, channel: usize, column: usize) -> &mut Vec<f64> {
        let series = &mut self.derivatives[channel * self.columns + column];
        if series.is_empty() {
            series.resize(self.room, 0.0);
        }
        series
    }

    pub(super) fn add_scaled(&mut self, at: (usize, usize), factor: f64, from: &[f64]) {
        for (to, x) in self.series(at.0, at.1).iter_mut().zip(from) {
            *to += factor * x;
        }
    }

    /// Adds to the samples from `start` on.
    pub(super) fn add_part(
        &mut self,
        at: (usize, usize),
        (factor, start): (f64, usize),
        from: &[f64],
    ) {
        let series = self.series(at.0, at.1);
        for (to, x) in series[start..].iter_mut().zip(from) {
            *to += factor * x;
        }
    }

    /// Takes the value and the derivatives of a channel from another block of the same shape.
    pub(super) fn take_channel(&mut self, channel: usize, from: &Self) {
        self.samples = from.samples;
        self.values[channel].clone_from(&from.values[channel]);
        let own = channel * self.columns..(channel + 1) * self.columns;
        self.derivatives[own.clone()].clone_from_slice(&from.derivatives[own]);
    }
}
