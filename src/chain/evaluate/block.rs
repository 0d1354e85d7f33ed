//! Values and derivatives of successive samples, channel by channel.

/// The signal of some samples and its derivatives.
#[derive(Debug, Clone)]
pub struct Block {
    room: usize,
    samples: usize,
    pub(super) columns: usize,
    pub(super) values: Vec<Vec<f64>>,
    /// `[channel · columns + column]`; empty where absent.
    derivatives: Vec<Vec<f64>>,
    /// Which of them hold an earlier block still: the first to write there overwrites.
    stale: Vec<bool>,
}

/// Samples of one channel, to be added to its series from one of them on.
#[derive(Clone, Copy)]
pub(super) struct SeriesPart<'a> {
    pub channel: usize,
    pub start: usize,
    pub samples: &'a [f64],
}

impl Block {
    pub(super) fn new(channels: usize, columns: usize, room: usize) -> Self {
        Self {
            room,
            samples: 0,
            columns,
            values: vec![vec![0.0; room]; channels],
            derivatives: vec![Vec::new(); channels * columns],
            stale: vec![false; channels * columns],
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

    /// Values become zero, and derivatives do where nothing writes before [`Block::settle`].
    pub(super) fn clear(&mut self, samples: usize) {
        self.samples = samples;
        for value in &mut self.values {
            value.fill(0.0);
        }
        self.stale.fill(true);
    }

    /// Zeros where nothing was written.
    pub(super) fn settle(&mut self) {
        for (series, stale) in self.derivatives.iter_mut().zip(&mut self.stale) {
            if std::mem::take(stale) {
                series.fill(0.0);
            }
        }
    }

    pub(super) fn series(&mut self, channel: usize, column: usize) -> &mut Vec<f64> {
        let at = channel * self.columns + column;
        let series = &mut self.derivatives[at];
        if series.is_empty() {
            series.resize(self.room, 0.0);
        } else if self.stale[at] {
            series.fill(0.0);
        }
        self.stale[at] = false;
        series
    }

    /// What was written to a series so far, to be given back with [`Block::give_back`]; empty where nothing was.
    pub(super) fn lend(&mut self, channel: usize, column: usize) -> Vec<f64> {
        let at = channel * self.columns + column;
        match self.stale[at] {
            true => Vec::new(),
            false => std::mem::take(&mut self.derivatives[at]),
        }
    }

    pub(super) fn give_back(&mut self, channel: usize, column: usize, series: Vec<f64>) {
        let at = channel * self.columns + column;
        if !self.stale[at] {
            self.derivatives[at] = series;
        }
    }

    /// The series of a channel that were written.
    pub(super) fn written(&mut self, channel: usize) -> impl Iterator<Item = &mut Vec<f64>> {
        let own = channel * self.columns..(channel + 1) * self.columns;
        let pairs = self.derivatives[own.clone()]
            .iter_mut()
            .zip(&self.stale[own]);
        pairs
            .filter(|(_, stale)| !**stale)
            .map(|(series, _)| series)
    }

    pub(super) fn add_scaled(&mut self, channel: usize, column: usize, factor: f64, from: &[f64]) {
        let part = SeriesPart {
            channel,
            start: 0,
            samples: from,
        };
        self.add_part(column, factor, part);
    }

    /// Adds a part of a channel's series, times a factor, to a column.
    pub(super) fn add_part(&mut self, column: usize, factor: f64, part: SeriesPart<'_>) {
        let SeriesPart {
            channel,
            start,
            samples: from,
        } = part;
        let at = channel * self.columns + column;
        let first = self.stale[at] || self.derivatives[at].is_empty();
        if first && start == 0 && from.len() >= self.samples {
            self.stale[at] = false;
            let series = &mut self.derivatives[at];
            series.resize(self.room, 0.0);
            let pairs = series.iter_mut().zip(from);
            pairs.for_each(|(to, x)| *to = factor * x);
            return;
        }
        let series = self.series(channel, column);
        for (to, x) in series[start..].iter_mut().zip(from) {
            *to += factor * x;
        }
    }

    /// An empty one of the same shape.
    pub(super) fn like(&self) -> Self {
        Self::new(self.values.len(), self.columns, self.room)
    }

    /// An empty one of values alone.
    pub(super) fn without_columns(&self) -> Self {
        Self::new(self.values.len(), 0, self.room)
    }

    /// Exchanges the value and the derivatives of a channel with those of another block of the same shape.
    pub(super) fn exchange_channel(&mut self, channel: usize, with: &mut Self) {
        self.samples = with.samples;
        std::mem::swap(&mut self.values[channel], &mut with.values[channel]);
        let own = channel * self.columns..(channel + 1) * self.columns;
        self.derivatives[own.clone()].swap_with_slice(&mut with.derivatives[own.clone()]);
        self.stale[own.clone()].swap_with_slice(&mut with.stale[own]);
    }
}
