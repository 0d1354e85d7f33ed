//! Which of the two is spoken of.

/// The robot or the simulator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Who {
    Robot,
    Simulator,
}
