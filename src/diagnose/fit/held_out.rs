//! Rows that are held out: of a training recording where no other recording is, and in two halves, one that chooses the
//! model and one that tests what was chosen.
//!
//! A search takes the best of many hypotheses by their error on held-out rows, which makes that error too small
//! (selection bias: Stone 1974; Varma and Simon 2006). Rows that took no part in the choice are free of it.

use crate::chain::dataset::{Dataset, Prepared};
use crate::recording::split::Split;

/// Contiguous blocks into which a recording is cut; each is longer than what residuals remember.
const BLOCKS: usize = 12;

/// One block of so many is held out.
const HELD_OUT: usize = 3;

/// Contiguous blocks of a recording that is held out, which in turn choose and test: two for each of the above, so that
/// either half has rows from everywhere in the motion.
const HALVES: usize = 2 * BLOCKS;

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

/// The held-out recordings of a dataset without rows that are so near to a held-out row of another, of the same recordings, that
/// noise is remembered from one to the other; those of which nothing is left are left out.
pub fn apart(data: &Dataset, from: &Dataset, memory: usize) -> Vec<Prepared> {
    let pairs = data.of(Split::Validation).zip(from.of(Split::Validation));
    let parts = pairs.map(|(recording, other)| {
        let near = near(other, memory);
        recording.part(Split::Validation, |row| !near[row])
    });
    parts
        .filter(|part| part.counting().next().is_some())
        .collect()
}

/// Rows that are at most so many from one that counts; averages over periods end where they begin.
fn near(recording: &Prepared, memory: usize) -> Vec<bool> {
    let mut near = vec![false; recording.rows()];
    let (rows, reach) = (near.len() as isize, memory.min(near.len()) as isize);
    let ends_meet = recording.experiment.periods.is_some();
    for row in recording.counting() {
        for at in row as isize - reach..=row as isize + reach {
            let at = match ends_meet {
                true => at.rem_euclid(rows),
                false => at,
            };
            if (0..rows).contains(&at) {
                near[at as usize] = true;
            }
        }
    }
    near
}

/// What rows that are held out are for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// Choosing among models.
    Selection,
    /// Testing what was chosen.
    Test,
}

/// The dataset with one half of the rows that are held out.
pub fn half(data: &Dataset, purpose: Purpose) -> Dataset {
    let of = |recording: &Prepared| match recording.split {
        Split::Train => recording.clone(),
        Split::Validation => {
            let rows = recording.rows();
            let odd = usize::from(purpose == Purpose::Test);
            recording.part(Split::Validation, |row| (row * HALVES / rows) % 2 == odd)
        }
    };
    Dataset {
        recordings: data.recordings.iter().map(of).collect(),
    }
}
