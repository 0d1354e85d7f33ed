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

/// Other spellings of units, in lower case.
const SPELLINGS: &[(&str, &[&str])] = &[
    ("s", &["sec", "second", "seconds", "sek", "sekunden"]),
    ("ms", &["msec", "millisecond", "milliseconds"]),
    ("us", &["µs", "μs", "usec", "microsecond", "microseconds"]),
    ("ns", &["nsec", "nanosecond", "nanoseconds"]),
    ("rad", &["radian", "radians"]),
    ("deg", &["°", "degree", "degrees", "grad"]),
    ("rev", &["turn", "turns", "revolution", "revolutions"]),
    ("um", &["µm", "μm"]),
    ("rad/s", &["rad/sec"]),
    (
        "deg/s",
        &["°/s", "deg/sec", "degree/s", "degrees/s", "grad/s"],
    ),
    ("rpm", &["/min", "u/min", "r/min", "rev/min"]),
    ("rad/s^2", &["rad/s²"]),
    ("deg/s^2", &["deg/s²", "°/s^2", "°/s²"]),
    ("m/s^2", &["m/s²"]),
    ("A", &["amp", "amps", "ampere", "amperes"]),
    (
        "mA",
        &["milliamp", "milliamps", "milliampere", "milliamperes"],
    ),
    ("Nm", &["n·m", "n*m", "newtonmeter"]),
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

/// The unit of a quantity that a word spells.
fn spelt(quantity: Quantity, word: &str) -> Option<&'static str> {
    let lower = word.to_lowercase();
    let known = names(quantity);
    let is_other = |name: &str| {
        let of = SPELLINGS.iter().find(|(unit, _)| *unit == name);
        of.is_some_and(|(_, others)| others.contains(&lower.as_str()))
    };
    let exact = known.iter().find(|name| **name == word);
    let alike = || known.iter().find(|name| name.eq_ignore_ascii_case(word));
    let other = || known.iter().find(|name| is_other(name));
    exact.or_else(alike).or_else(other).copied()
}

/// The unit of a quantity that a name states, as in `q1 [°]`, `q1_deg`, `q1/deg` or `angle (degrees)`.
pub fn stated(quantity: Quantity, name: &str) -> Option<&'static str> {
    let is_part = |c: char| c.is_alphabetic() || "/°·*²^".contains(c);
    let words: Vec<&str> = name.split(|c| !is_part(c)).collect();
    let last = |word: &str| {
        word.rsplit('/')
            .next()
            .and_then(|part| spelt(quantity, part))
    };
    let mut from_the_end = words.iter().rev();
    from_the_end.find_map(|word| spelt(quantity, word).or_else(|| last(word)))
}

/// Whether a word is a unit of any quantity, also in brackets as under the names of a table.
pub(super) fn is_unit(word: &str) -> bool {
    let inner = word.trim_matches(['[', ']', '(', ')']);
    UNITS.iter().any(|(of, _)| spelt(*of, inner).is_some())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_state_units_in_many_spellings() {
        use Quantity::{Acceleration, Current, Position, Time, Torque, Velocity};
        for (quantity, name, unit) in [
            (Position, "q1 [°]", Some("deg")),
            (Position, "q1 (degrees)", Some("deg")),
            (Position, "Winkel 1 [Grad]", Some("deg")),
            (Position, "q_{n}_deg", Some("deg")),
            (Position, "q1 [rad]", Some("rad")),
            (Position, "x_mm", Some("mm")),
            (Position, "q1", None),
            (Velocity, "dq1 [°/s]", Some("deg/s")),
            (Velocity, "Drehzahl [1/min]", Some("rpm")),
            (Acceleration, "ddq1 [rad/s²]", Some("rad/s^2")),
            (Time, "t [µs]", Some("us")),
            (Time, "Zeit/ms", Some("ms")),
            (Position, "/joint_states/a1/position", None),
            (Time, "timestamp_ms", Some("ms")),
            (Current, "strom_1_mA", Some("mA")),
            (Current, "i1", None),
            (Torque, "tau1 [N·m]", Some("Nm")),
        ] {
            assert_eq!(stated(quantity, name), unit, "{name}");
        }
    }

    #[test]
    fn every_other_spelling_is_of_a_unit_and_of_no_other() {
        for (unit, others) in SPELLINGS {
            for other in *others {
                let found = UNITS.iter().filter_map(|(of, _)| spelt(*of, other));
                assert_eq!(found.collect::<Vec<_>>(), [*unit], "{other}");
                assert!(is_unit(&format!("[{other}]")));
            }
        }
    }
}
