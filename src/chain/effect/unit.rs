//! Units of parameters, which depend on whether the joint turns or slides.

use crate::robot::tree::JointKind;

/// The unit of a parameter of an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// A pure number.
    One,
    /// N·m (N).
    Torque,
    /// N·m·s/rad (N·s/m).
    TorquePerSpeed,
    /// Torque over the power of speed that another parameter states.
    TorquePerSpeedPower,
    /// N·m/rad (N/m).
    TorquePerPosition,
    /// kg·m² (kg).
    Inertia,
    /// rad (m).
    Position,
    /// rad/s (m/s).
    Speed,
    /// s/rad (s/m).
    PerSpeed,
    /// Cycles per turn, or rad per metre.
    Order,
    /// rad, of whichever joint.
    Angle,
    /// s.
    Time,
    /// Torque over this power of a current.
    TorquePerCurrent(u8),
    /// As stated by whoever wrote the law.
    Stated(&'static str),
}

impl Unit {
    /// The unit for a joint of the given kind.
    pub fn of(self, kind: JointKind) -> &'static str {
        let turns = kind == JointKind::Revolute;
        match self {
            Self::One => "1",
            Self::Stated(unit) => unit,
            Self::Torque | Self::TorquePerCurrent(0) => kind.effort_unit(),
            Self::TorquePerSpeed if turns => "N·m·s/rad",
            Self::TorquePerSpeed => "N·s/m",
            Self::TorquePerSpeedPower if turns => "N·m·(s/rad)^p",
            Self::TorquePerSpeedPower => "N·(s/m)^p",
            Self::TorquePerPosition if turns => "N·m/rad",
            Self::TorquePerPosition => "N/m",
            Self::Inertia if turns => "kg·m²",
            Self::Inertia => "kg",
            Self::Position => kind.position_unit(),
            Self::Speed if turns => "rad/s",
            Self::Speed => "m/s",
            Self::PerSpeed if turns => "s/rad",
            Self::PerSpeed => "s/m",
            Self::Order if turns => "1",
            Self::Order => "rad/m",
            Self::Angle => "rad",
            Self::Time => "s",
            Self::TorquePerCurrent(1) if turns => "N·m/A",
            Self::TorquePerCurrent(1) => "N/A",
            Self::TorquePerCurrent(2) if turns => "N·m/A²",
            Self::TorquePerCurrent(2) => "N/A²",
            Self::TorquePerCurrent(_) if turns => "N·m/A³",
            Self::TorquePerCurrent(_) => "N/A³",
        }
    }
}
