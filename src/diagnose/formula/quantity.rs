//! Variables of the motion that formulas are made of.

/// A variable of the motion; others by the number of their joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Quantity {
    Position,
    Velocity,
    Acceleration,
    /// τ_M, what the gear transmits.
    Load,
    OtherPosition(usize),
    OtherVelocity(usize),
}

impl Quantity {
    /// Whether it is of another joint.
    pub fn other(self) -> Option<usize> {
        match self {
            Self::OtherPosition(joint) | Self::OtherVelocity(joint) => Some(joint),
            _ => None,
        }
    }
}
