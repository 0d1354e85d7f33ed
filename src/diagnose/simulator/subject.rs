//! The subject of a sentence: robot or simulator.

/// The robot or the simulator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Subject {
    Robot,
    Simulator,
}
