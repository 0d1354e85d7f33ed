//! The columns of the table: what stands before those of the joints, and what a column of a joint holds.

/// The columns before those of the joints.
pub(super) const LEADING: [&str; 3] = ["recording", "split", "t"];

/// What a column of a joint holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// The signal as recorded, after preprocessing.
    Recorded,
    /// The signal as the model gives it.
    Predicted,
    /// As the model gives it before effects were added.
    Baseline,
    /// As the model gives it with all effects found.
    Final,
    /// Speed of the joint in rad/s or m/s.
    Velocity,
    /// Position of the joint in rad or m.
    Position,
    /// Acceleration of the joint in rad/s² or m/s².
    Acceleration,
}

/// A column: a quantity of a joint.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Name of the joint, or of the channel of a force.
    pub joint: String,
    /// What the column holds of it.
    pub quantity: Quantity,
}

impl Quantity {
    /// All of them, in the order of the columns of a joint.
    pub const ALL: [Quantity; 7] = [
        Quantity::Recorded,
        Quantity::Predicted,
        Quantity::Baseline,
        Quantity::Final,
        Quantity::Velocity,
        Quantity::Position,
        Quantity::Acceleration,
    ];

    /// The word after the joint's name in the header.
    pub fn as_str(self) -> &'static str {
        match self {
            Quantity::Recorded => "recorded",
            Quantity::Predicted => "predicted",
            Quantity::Baseline => "baseline",
            Quantity::Final => "final",
            Quantity::Velocity => "velocity",
            Quantity::Position => "position",
            Quantity::Acceleration => "acceleration",
        }
    }
}
