//! The split of a problem's recordings into training and validation.

/// Whether a recording was fitted or held out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Split {
    /// It is fitted.
    Train,
    /// It is held out, to judge fits by.
    Validation,
}

impl Split {
    /// Both, in the order of the tables that list them.
    pub const ALL: [Split; 2] = [Split::Train, Split::Validation];

    /// The word in the table.
    pub fn as_str(self) -> &'static str {
        match self {
            Split::Train => "train",
            Split::Validation => "validation",
        }
    }
}
