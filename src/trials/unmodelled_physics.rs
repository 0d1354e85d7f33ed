//! Physics outside the vocabulary, as a part of the current: a diagnosis must leave it without a name.

use crate::simulate::sensors::Table;

/// A law outside the vocabulary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnmodelledLaw {
    /// Dry friction that grows with the square of another joint's speed: a seal that the neighbour's oil presses on.
    FrictionBySpeed,
    /// Dry friction that grows with the position of another joint: a hose that the neighbour pulls tight.
    NeighbourFriction,
    /// Resistance in proportion to the product of the speeds of two joints.
    SpeedProduct,
}

impl UnmodelledLaw {
    /// All of them, in the order in which trials draw them.
    pub const ALL: [Self; 3] = [
        Self::FrictionBySpeed,
        Self::NeighbourFriction,
        Self::SpeedProduct,
    ];

    /// The name in results; no effect has it.
    pub fn name(self) -> &'static str {
        match self {
            Self::FrictionBySpeed => "outside: friction by the neighbour's speed",
            Self::NeighbourFriction => "outside: friction by the neighbour's position",
            Self::SpeedProduct => "outside: product of two speeds",
        }
    }

    /// What the law adds to the current of a joint, up to a factor; positions of the neighbour count from `least`.
    /// `None` where the table lacks a column.
    fn shape(self, table: &Table, at: Neighbours, rate: f64, least: f64) -> Option<Vec<f64>> {
        let Neighbours { joint, neighbour } = at;
        let of = |prefix: &str, j: usize| Some(&table.data[column(table, prefix, j)?]);
        let position = of("q", neighbour)?;
        let speeds = [slope(of("q", joint)?, rate), slope(position, rate)];
        let sign = |v: &f64| v / (v.abs() + 0.004);
        Some(match self {
            Self::FrictionBySpeed => {
                let pairs = speeds[0].iter().zip(&speeds[1]);
                pairs.map(|(v, other)| sign(v) * other * other).collect()
            }
            Self::NeighbourFriction => {
                let wrap = |(v, x): (&f64, &f64)| sign(v) * (x - least).max(0.0);
                speeds[0].iter().zip(position).map(wrap).collect()
            }
            Self::SpeedProduct => {
                let pairs = speeds[0].iter().zip(&speeds[1]);
                pairs.map(|(a, b)| a * b).collect()
            }
        })
    }
}

/// A joint with a law, and the other joint that enters it, by index.
#[derive(Debug, Clone, Copy)]
pub struct Neighbours {
    /// The one whose current the law adds to.
    pub joint: usize,
    /// The one whose motion it depends on.
    pub neighbour: usize,
}

/// What a robot has beyond the vocabulary.
#[derive(Debug, Clone, Copy)]
pub struct Unmodelled {
    /// The law.
    pub law: UnmodelledLaw,
    /// Where it acts.
    pub at: Neighbours,
    /// Its size as a share of the usual current.
    pub share: f64,
}

/// A law of one robot: the same in all of its recordings.
#[derive(Debug, Clone, Copy)]
pub struct UnmodelledTorque {
    law: UnmodelledLaw,
    at: Neighbours,
    rate: f64,
    /// Least position of the neighbour.
    least: f64,
    factor: f64,
}

impl UnmodelledTorque {
    /// The law that adds `size` A of RMS to the current of a joint in a recording at `rate` Hz.
    pub fn of_size(
        law: UnmodelledLaw,
        at: Neighbours,
        table: &Table,
        size: f64,
        rate: f64,
    ) -> Option<Self> {
        let position = &table.data[column(table, "q", at.neighbour)?];
        let least = position.iter().copied().fold(f64::INFINITY, f64::min);
        let shape = law.shape(table, at, rate, least)?;
        let rms = (shape.iter().map(|x| x * x).sum::<f64>() / shape.len().max(1) as f64).sqrt();
        Some(Self {
            law,
            at,
            rate,
            least,
            factor: size / rms,
        })
    }

    /// Adds the law to a recording.
    pub fn add_to(&self, table: &mut Table) {
        let shape = self.law.shape(table, self.at, self.rate, self.least);
        let current = column(table, "i", self.at.joint);
        if let (Some(shape), Some(current)) = (shape, current) {
            let pairs = table.data[current].iter_mut().zip(&shape);
            pairs.for_each(|(to, x)| *to += self.factor * x);
        }
    }
}

fn column(table: &Table, prefix: &str, joint: usize) -> Option<usize> {
    let name = format!("{prefix}{}", joint + 1);
    table.header.iter().position(|h| *h == name)
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

#[cfg(test)]
mod tests {
    use super::*;

    const RATE: f64 = 100.0;

    /// Two joints, `rows` samples; speeds and currents in proportion to `scale`.
    fn table(rows: usize, scale: f64) -> Table {
        let wave = |by: f64| {
            let of = |k: usize| scale * (by * k as f64 / RATE).sin();
            (0..rows).map(of).collect::<Vec<f64>>()
        };
        Table {
            header: ["q1", "q2", "i1", "i2"].map(String::from).to_vec(),
            data: vec![wave(1.0), wave(2.0), wave(3.0), wave(5.0)],
        }
    }

    #[test]
    fn has_the_size_asked_for_in_one_recording_and_the_same_law_in_others() {
        let (law, first) = (UnmodelledLaw::SpeedProduct, table(2000, 1.0));
        let at = Neighbours {
            joint: 0,
            neighbour: 1,
        };
        let added = UnmodelledTorque::of_size(law, at, &first, 0.3, RATE).unwrap();
        let change = |mut table: Table| {
            let before = table.data[2].clone();
            added.add_to(&mut table);
            let pairs = table.data[2].iter().zip(before);
            pairs.map(|(a, b)| a - b).collect::<Vec<f64>>()
        };
        let rms = |x: &[f64]| (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt();
        let of_first = change(first);
        assert!((rms(&of_first) - 0.3).abs() < 1e-12);
        // Speeds that are four times as large, but for the last samples of the shorter one, whose differences are one-sided.
        for (x, first) in change(table(500, 4.0)).iter().zip(of_first).take(490) {
            assert!((x - 16.0 * first).abs() < 1e-12);
        }
    }
}
