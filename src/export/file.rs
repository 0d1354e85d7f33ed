//! The files of an export.

/// A file of an export.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct File {
    /// Name without folder.
    pub name: String,
    /// Its whole content.
    pub text: String,
}

/// The files of an export, and what a reader has to know of them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Export {
    /// The main one first.
    pub files: Vec<File>,
    /// What the format has no place for, one sentence each.
    pub notes: Vec<String>,
}
