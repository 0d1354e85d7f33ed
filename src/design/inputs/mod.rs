//! Inputs of a design from its problem file: model and limits, rival models, and motions stated by their coefficients.

pub mod prepared;
pub mod rival_models;
pub mod stated_motion;
