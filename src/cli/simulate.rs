//! `exid simulate`: recordings from a model.
