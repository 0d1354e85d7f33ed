//! The time base: rate and evenness of the stamps, an even clock behind stamps that jitter, and rows at samples that do not come
//! evenly.

pub mod clock;
pub mod sample_rows;
pub mod timing;
