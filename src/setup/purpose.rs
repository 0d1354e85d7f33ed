//! What a model is declared for.

/// What a model is declared for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose {
    /// Its parameters are estimated from recordings.
    Estimation,
    /// Torque constants are sought: those that are not given are one.
    TorqueConstants,
    /// It is the truth of a simulation: bodies and gains are known, and nothing is shared, bounded or known by name.
    Simulation,
}
