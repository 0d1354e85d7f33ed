//! Rows that are held out of a training recording where no other recording is.

use crate::chain::dataset::{Dataset, Prepared};
use crate::recording::split::Split;

/// Contiguous blocks into which a recording is cut; each is longer than what residuals remember.
const BLOCKS: usize = 12;

/// One block of so many is held out.
const HELD_OUT: usize = 3;

/// The dataset with blocks of its training recordings held out; the same if there are validation
/// recordings. The second value says whether blocks were held out.
pub fn with_held_out(data: Dataset) -> (Dataset, bool) {
    if data.of(Split::Validation).next().is_some() {
        return (data, false);
    }
    let parts = data.recordings.iter().flat_map(|recording| {
        [Split::Train, Split::Validation].map(|split| part(recording, split))
    });
    let recordings = parts.collect();
    (Dataset { recordings }, true)
}

fn part(recording: &Prepared, split: Split) -> Prepared {
    let rows = recording.rows();
    recording.part(split, |row| {
        let held_out = (row * BLOCKS / rows) % HELD_OUT == HELD_OUT - 1;
        held_out == (split == Split::Validation)
    })
}
