//! Choosing among models: the exact fit and the test of a hypothesis, stepwise selection, and rival models.

pub mod between_periods;
pub mod common_delay;
pub mod exact_fit;
pub mod forecast;
pub mod hypothesis_test;
pub mod law_range;
pub mod rival_models;
pub mod rivals_of_all;
pub mod search_bounds;
pub mod stepwise;
pub mod time_window;
