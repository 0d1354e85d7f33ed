//! Variables of the motion, of which formulas are made.

/// A variable of the motion; others by the number of their joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// q.
    Position,
    /// v.
    Velocity,
    /// v̇.
    Acceleration,
    /// τ_M, what the gear transmits.
    Load,
    /// q of another joint.
    OtherPosition(usize),
    /// v of another joint.
    OtherVelocity(usize),
}

impl Quantity {
    /// The other joint that it is of.
    pub fn other(self) -> Option<usize> {
        match self {
            Self::OtherPosition(joint) | Self::OtherVelocity(joint) => Some(joint),
            _ => None,
        }
    }

    /// Whether it is a position, of whatever joint.
    pub fn is_position(self) -> bool {
        matches!(self, Self::Position | Self::OtherPosition(_))
    }
}
