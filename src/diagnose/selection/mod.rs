//! Choosing among models: stepwise selection, rival models, what only resembles the physics that is missing, and the
//! confirmation of what was chosen on rows that no choice has seen.

pub mod between_periods;
pub mod confirmation;
pub mod confounding;
pub mod exact_fit;
pub mod explanation;
pub mod forecast;
pub mod hypothesis_test;
pub mod last_selection;
pub mod law_range;
pub mod rival_models;
pub mod search_bounds;
pub mod stepwise;
pub mod time_window;
pub mod weak_findings;
pub mod zero_size;
