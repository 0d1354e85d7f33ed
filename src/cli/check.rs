//! `exid check`: reads everything, runs nothing.
