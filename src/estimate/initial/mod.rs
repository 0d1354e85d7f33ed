//! Initial values of a nonlinear fit: the range of each nonlinear parameter, local searches from the points of a grid in
//! it, gaps of gears with play held at the values of theirs, and the linear unknowns at their optimum.

pub mod gap_search;
pub mod search_range;
pub mod start;
pub mod start_grid;
