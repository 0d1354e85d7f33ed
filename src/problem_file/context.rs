//! What the tables of a problem file need to know besides their own text.

use std::path::Path;

/// What the tables need to know besides their own text.
pub(super) struct Context<'a> {
    /// Folder that relative paths start from: the problem file's own.
    pub(super) folder: &'a Path,
    /// Identifiers that lists of effects may hold.
    pub(super) effect_ids: &'a [&'a str],
}
