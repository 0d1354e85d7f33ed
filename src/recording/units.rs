//! Units in which recordings may be written, and the factors that turn them into SI.

use std::f64::consts::{PI, TAU};

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// s.
    Time,
    /// rad or m.
    Position,
    /// rad/s or m/s.
    Velocity,
    /// rad/s² or m/s².
    Acceleration,
    /// A.
    Current,
    /// N·m or N.
    Torque,
}

const DEGREE: f64 = PI / 180.0;

/// Name of the unit of encoders, whose size the problem file states.
pub const COUNT: &str = "count";

/// Lowest rate of a recording of dynamics, Hz: slower than this, friction and gravity is all it can show.
pub const SLOWEST_HZ: f64 = 2.0;

/// Highest rate of drives and their bus, Hz.
pub const FASTEST_HZ: f64 = 50_000.0;

/// Units of each quantity by their names: s, rad or m, rad/s or m/s, rad/s² or m/s², A, N·m or N are one.
const UNITS: &[(Quantity, &[(&str, f64)])] = &[
    (
        Quantity::Time,
        &[
            ("s", 1.0),
            ("ms", 1e-3),
            ("us", 1e-6),
            ("ns", 1e-9),
            ("min", 60.0),
        ],
    ),
    (
        Quantity::Position,
        &[
            ("rad", 1.0),
            ("mrad", 1e-3),
            ("deg", DEGREE),
            ("rev", TAU),
            ("m", 1.0),
            ("cm", 1e-2),
            ("mm", 1e-3),
            ("um", 1e-6),
        ],
    ),
    (
        Quantity::Velocity,
        &[
            ("rad/s", 1.0),
            ("deg/s", DEGREE),
            ("rev/s", TAU),
            ("rpm", TAU / 60.0),
            ("m/s", 1.0),
            ("mm/s", 1e-3),
        ],
    ),
    (
        Quantity::Acceleration,
        &[
            ("rad/s^2", 1.0),
            ("deg/s^2", DEGREE),
            ("rev/s^2", TAU),
            ("m/s^2", 1.0),
            ("mm/s^2", 1e-3),
        ],
    ),
    (Quantity::Current, &[("A", 1.0), ("mA", 1e-3), ("kA", 1e3)]),
    (
        Quantity::Torque,
        &[
            ("Nm", 1.0),
            ("mNm", 1e-3),
            ("Ncm", 1e-2),
            ("kNm", 1e3),
            ("N", 1.0),
            ("mN", 1e-3),
            ("kN", 1e3),
        ],
    ),
];

/// Units of a quantity.
fn units(quantity: Quantity) -> &'static [(&'static str, f64)] {
    let row = UNITS.iter().find(|(of, _)| *of == quantity);
    row.map_or(&[], |(_, units)| units)
}

/// The factor that turns a unit of a quantity into SI; `None` of a unit that is not known.
pub fn factor(quantity: Quantity, unit: &str) -> Option<f64> {
    let mut units = units(quantity).iter();
    units
        .find(|(name, _)| *name == unit)
        .map(|(_, factor)| *factor)
}

/// Whether a word is a unit of any quantity, also in brackets as under the names of a table.
pub(super) fn is_unit(word: &str) -> bool {
    let inner = word.trim_matches(['[', ']', '(', ')']);
    let spelt = inner
        .replace('·', "")
        .replace('°', "deg")
        .replace('²', "^2");
    let known =
        |(_, units): &(Quantity, &[(&str, f64)])| units.iter().any(|(name, _)| *name == spelt);
    spelt == COUNT || UNITS.iter().any(known)
}

/// The factor of an encoder's counts, so many in a turn.
pub fn of_counts(per_turn: f64) -> f64 {
    TAU / per_turn
}

/// Names of the units of a quantity.
pub fn names(quantity: Quantity) -> Vec<&'static str> {
    let mut names: Vec<&str> = units(quantity).iter().map(|(name, _)| *name).collect();
    if quantity == Quantity::Position {
        names.push(COUNT);
    }
    names
}
