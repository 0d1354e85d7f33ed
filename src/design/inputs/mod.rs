//! Inputs of a design: what is asked for, model and limits, rival models, and motions stated by their coefficients.

pub mod prepared;
pub mod request;
pub mod rival_models;
pub mod stated_motion;
