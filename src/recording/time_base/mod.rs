//! The time base: rate and evenness of the stamps, and an even clock behind stamps that jitter.

pub mod clock;
pub mod timing;
