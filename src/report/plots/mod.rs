//! Plots as inline SVG, drawn at twice the size at which the page shows them.
//!
//! The drawing library places points on whole units, so twice the size gives lines half as coarse.

pub(super) mod agreement;
pub(super) mod bars;
pub(super) mod boxes;
pub(super) mod curves;
mod frame;
pub(super) mod law;
pub(super) mod rows;
pub(super) mod scatter;
pub(super) mod signals;

pub(super) use crate::report::plots::frame::{
    Area, Below, Drawn, INK, KIND, PREDICTED, RECORDED, RESIDUAL, draw, figure, key, padded_range,
    resolvable,
};
use crate::report::plots::frame::{GRID, TEXT_HEIGHT, X_LABEL_UNITS, axes, line, text_style};
