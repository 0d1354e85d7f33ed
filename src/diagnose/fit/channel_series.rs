//! Predictions, residuals and derivatives of whole recordings, one series per channel over the rows that count.

use crate::chain::dataset::Prepared;
use crate::chain::model::Model;
use crate::estimate::rows::{tasks, visit};
use nalgebra::DVector;
use rayon::prelude::*;

/// Series of every channel over the rows that count for it, recording after recording.
#[derive(Debug, Clone, Default)]
pub struct ChannelSeries {
    /// `[channel][row]`; empty for channels that are not active.
    pub predicted: Vec<Vec<f64>>,
    /// The same over all rows that count, also where the channel's own joint stands still.
    pub loads: Vec<Vec<f64>>,
    /// The signal as recorded, over the same rows.
    pub recorded: Vec<Vec<f64>>,
    /// `[channel][column]`; `None` where the channel does not depend on the column.
    pub columns: Vec<Vec<Option<Vec<f64>>>>,
}

impl ChannelSeries {
    /// Evaluates a model with derivatives with respect to parameters `columns`.
    pub fn of(
        model: &Model,
        values: &DVector<f64>,
        columns: &[usize],
        recordings: &[&Prepared],
    ) -> Self {
        let tasks = tasks(model, recordings.iter().copied());
        let parts: Vec<Self> = tasks
            .par_iter()
            .map(|task| {
                let mut part = Self::empty(model.channels().len(), columns.len());
                visit(model, values, columns, task, |block| {
                    let counting = block.counting();
                    for (c, channel) in model.channels().iter().enumerate() {
                        if !channel.active {
                            continue;
                        }
                        let own = block.counting_for(c);
                        let take = |to: &mut Vec<f64>, from: &[f64]| add(to, from, own.as_deref());
                        let before = part.predicted[c].len();
                        add(&mut part.loads[c], block.predicted(c), counting.as_deref());
                        take(&mut part.predicted[c], block.predicted(c));
                        take(&mut part.recorded[c], block.recorded(c));
                        for k in 0..columns.len() {
                            if let Some(series) = block.derivative(c, k) {
                                let to = part.columns[c][k].get_or_insert_default();
                                // A column can appear late; what came before is zero.
                                to.resize(before, 0.0);
                                take(to, series);
                            }
                        }
                    }
                });
                part
            })
            .collect();
        let mut whole = Self::empty(model.channels().len(), columns.len());
        parts.into_iter().for_each(|part| whole.append(part));
        whole
    }

    /// What a model predicts of one channel.
    pub fn predicted_of(
        channel: usize,
        model: &Model,
        values: &DVector<f64>,
        recordings: &[&Prepared],
    ) -> Vec<f64> {
        let mut series = Self::of(model, values, &[], recordings).predicted;
        std::mem::take(&mut series[channel])
    }

    fn empty(channels: usize, columns: usize) -> Self {
        Self {
            predicted: vec![Vec::new(); channels],
            loads: vec![Vec::new(); channels],
            recorded: vec![Vec::new(); channels],
            columns: vec![vec![None; columns]; channels],
        }
    }

    fn append(&mut self, part: Self) {
        for (c, columns) in part.columns.into_iter().enumerate() {
            let (before, after) = (
                self.predicted[c].len(),
                self.predicted[c].len() + part.predicted[c].len(),
            );
            for (to, from) in self.columns[c].iter_mut().zip(columns) {
                if to.is_none() && from.is_none() {
                    continue;
                }
                let to = to.get_or_insert_default();
                to.resize(before, 0.0);
                to.extend(from.unwrap_or_default());
                to.resize(after, 0.0);
            }
        }
        for (to, from) in self.predicted.iter_mut().zip(part.predicted) {
            to.extend(from);
        }
        for (to, from) in self.loads.iter_mut().zip(part.loads) {
            to.extend(from);
        }
        for (to, from) in self.recorded.iter_mut().zip(part.recorded) {
            to.extend(from);
        }
    }

    /// Residuals `ŝ − s`, `[channel][row]`.
    pub fn residuals(&self) -> Vec<Vec<f64>> {
        let pairs = self.predicted.iter().zip(&self.recorded);
        pairs
            .map(|(p, r)| p.iter().zip(r).map(|(p, r)| p - r).collect())
            .collect()
    }
}

/// Adds values at the rows that are kept; all where there is no list.
fn add(to: &mut Vec<f64>, from: &[f64], kept: Option<&[bool]>) {
    match kept {
        None => to.extend_from_slice(from),
        Some(kept) => {
            let pairs = from.iter().zip(kept).filter(|(_, kept)| **kept);
            to.extend(pairs.map(|(x, _)| *x));
        }
    }
}
