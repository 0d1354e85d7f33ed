//! What is left of a selection: names that explain too little, that only resemble the physics that is missing or whose size may be
//! none are withdrawn, and the rest is confirmed on rows that no choice has seen.

pub mod confirmation;
pub mod confounding;
pub mod explanation;
pub mod last_selection;
pub mod weak_findings;
pub mod zero_size;
