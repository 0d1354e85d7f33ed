//! Rows at which the whole robot rests: what holds it there is static friction of any size, of which neither the
//! declared model nor a law of motion says anything.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::model::Model;
use crate::estimate::standstill;

/// The dataset without the rows at which every joint stands still.
pub fn left_out(model: &Model, data: Dataset) -> Dataset {
    let all: Vec<&Prepared> = data.recordings.iter().collect();
    let Some(factors) = standstill::factors(model, &all) else {
        return data;
    };
    let channels: Vec<usize> = (0..model.channels().len())
        .filter(|&c| model.channels()[c].active)
        .collect();
    let pairs = data.recordings.iter().zip(&factors);
    let recordings = pairs.map(|(recording, factors)| {
        let moves = |row: usize| channels.iter().any(|&c| factors[c][row] != 0.0);
        recording.part(recording.split, moves)
    });
    Dataset {
        recordings: recordings.collect(),
    }
}
