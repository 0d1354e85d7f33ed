//! From a selected model to what is reported: findings with their probabilities and sentences, what is left without a
//! name, the verdict, and the experiment that would tell rivals apart.

pub mod compared;
pub mod corrections;
pub mod finding;
pub mod formulas;
pub mod next_experiment;
pub mod probability;
pub mod report;
pub mod sentences;
pub mod summary;
pub mod unexplained;
pub mod verdict;
