//! Physics that no effect of the vocabulary has, as a part of the current: what comes of it has to stay unnamed.

use crate::simulate::sensors::Table;

/// A law outside the vocabulary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outside {
    /// A channel also hears the current of another joint.
    Crosstalk,
    /// Dry friction that grows with the position of another joint: a hose that the neighbour pulls tight.
    NeighbourFriction,
    /// Resistance in proportion to the product of the speeds of two joints.
    SpeedProduct,
}

impl Outside {
    pub const ALL: [Self; 3] = [Self::Crosstalk, Self::NeighbourFriction, Self::SpeedProduct];

    /// The name in results; no effect has it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Crosstalk => "outside: crosstalk of channels",
            Self::NeighbourFriction => "outside: friction by the neighbour's position",
            Self::SpeedProduct => "outside: product of two speeds",
        }
    }

    /// Adds the law to the current of a joint (its index, with that of its neighbour), `size` A of RMS.
    pub fn add(
        self,
        table: &mut Table,
        (joint, neighbour): (usize, usize),
        (size, rate): (f64, f64),
    ) {
        let column = |prefix: &str, j: usize| {
            let name = format!("{prefix}{}", j + 1);
            table.header.iter().position(|h| *h == name)
        };
        let (Some(current), Some(q), Some(other), Some(other_current)) = (
            column("i", joint),
            column("q", joint),
            column("q", neighbour),
            column("i", neighbour),
        ) else {
            return;
        };
        let (speed, other_speed) = (slope(&table.data[q], rate), slope(&table.data[other], rate));
        let shape: Vec<f64> = match self {
            Self::Crosstalk => table.data[other_current].clone(),
            Self::NeighbourFriction => {
                let range = spread(&table.data[other]);
                let wrap = |(v, x): (&f64, &f64)| v / (v.abs() + 0.004) * (x - range.0) / range.1;
                speed.iter().zip(&table.data[other]).map(wrap).collect()
            }
            Self::SpeedProduct => {
                let pairs = speed.iter().zip(&other_speed);
                pairs.map(|(a, b)| a * b).collect()
            }
        };
        let rms = (shape.iter().map(|x| x * x).sum::<f64>() / shape.len().max(1) as f64).sqrt();
        for (to, x) in table.data[current].iter_mut().zip(&shape) {
            *to += size * x / rms;
        }
    }
}

/// Central differences over four samples to either side, which quantisation hardly enters.
fn slope(series: &[f64], rate: f64) -> Vec<f64> {
    const REACH: usize = 4;
    let last = series.len() - 1;
    let at = |k: usize| {
        let (from, to) = (k.saturating_sub(REACH), (k + REACH).min(last));
        (series[to] - series[from]) * rate / (to - from) as f64
    };
    (0..series.len()).map(at).collect()
}

/// Least value and range.
fn spread(series: &[f64]) -> (f64, f64) {
    let least = series.iter().copied().fold(f64::INFINITY, f64::min);
    let greatest = series.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (least, (greatest - least).max(f64::MIN_POSITIVE))
}
