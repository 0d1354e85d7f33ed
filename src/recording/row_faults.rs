//! Remarks on rows of a recording that belong to another recording, or to other instants than the rest of the row.

use crate::fault::Description;

/// Rows of a recording that are those of another, as well.
#[derive(Debug, Clone, PartialEq)]
pub struct SharedRows {
    /// Name of the other recording.
    pub other: String,
    /// First row of the longest common run in this recording and in the other, from 1.
    pub first: usize,
    /// First row of that run in the other recording, from 1.
    pub first_of_other: usize,
    /// Rows in common in all.
    pub rows: usize,
    /// Of all common rows.
    pub seconds: f64,
    /// Of the recording's rows.
    pub share: f64,
    /// This recording is held out, and the other one fitted.
    pub held_out: bool,
}

impl SharedRows {
    pub(super) fn describe(&self) -> Description {
        let Self { other, first, .. } = self;
        let what = match self.held_out {
            true => format!("are also in {other}, which is fitted"),
            false => format!("are given twice, also in {other}"),
        };
        let message = format!(
            "{:.4} s of it ({:.1} % of its samples) {what}: samples {first} to {} are those of the other from {} on, to the last \
             digit",
            self.seconds,
            100.0 * self.share,
            first + self.rows - 1,
            self.first_of_other
        );
        match self.held_out {
            true => Description::new(
                "held-out-is-fitted",
                message,
                "what was fitted is not held out: record another motion, or leave recordings.validation out, and `exid \
                 diagnose` holds out blocks",
            ),
            false => Description::new(
                "recording-twice",
                message,
                "what counts twice makes intervals too narrow: remove one of the two, or cut one of them where the other \
                 begins",
            ),
        }
    }
}

/// Channels that repeat or interpolate samples of different instants, each over so many rows.
pub(super) fn describe_held_apart([slow, fast]: [f64; 2]) -> Description {
    let message = format!(
        "channels repeat or interpolate their samples, one over {slow:.4} rows and one over {fast:.4}, and not at the same \
         instants"
    );
    let remedy =
        "export all channels at common instants, without rows that are filled in between them";
    Description::new("held-apart", message, remedy)
}
