//! `[recordings.columns]`: which column of a file is what, in which unit.

use crate::problem_file::document::{Node, NodeValue};
use crate::problem_file::error::{KeyFault, ProblemFileError, ValueFault};
use crate::problem_file::key::{Form, Key, Length, REQUIRED, Range};
use crate::problem_file::located::{Located, check_length};
use crate::problem_file::reader::Reader;
use crate::problem_file::values;
use crate::recording::column_map::{Column, ColumnsAt, Factors};
use crate::recording::units;
use crate::recording::units::Quantity;

/// Keys of `[recordings.columns]`.
#[rustfmt::skip]
pub(crate) const COLUMNS_KEYS: &[Key] = &[
    Key { name: "time", form: Form::Either(&[Form::Text, Form::Table(TIME_KEYS)]), unit: "s", default: "\"t\" or \"time\"", example: "\"t\"", meaning: "Time stamps" },
    Key { name: "position", form: Form::Either(&[Form::Text, Form::Table(POSITION_KEYS)]), unit: "rad (m)", default: "the usual names", example: "\"q{n}\"", meaning: "Positions, or the motor's turns where position_side is \"motor\"" },
    Key { name: "velocity", form: Form::Either(&[Form::Text, Form::Table(VELOCITY_KEYS)]), unit: "rad/s (m/s)", default: "the usual names, if there", example: "\"dq{n}\"", meaning: "Velocities of the joints, by sensors or by the controller" },
    Key { name: "acceleration", form: Form::Either(&[Form::Text, Form::Table(ACCELERATION_KEYS)]), unit: "rad/s² (m/s²)", default: "the usual names, if there", example: "\"ddq{n}\"", meaning: "Accelerations of the joints" },
    Key { name: "current", form: Form::Either(&[Form::Text, Form::Table(CURRENT_KEYS)]), unit: "A", default: "the usual names", example: "\"i{n}\"", meaning: "Motor currents" },
    Key { name: "torque", form: Form::Either(&[Form::Text, Form::Table(TORQUE_KEYS)]), unit: "N·m (N)", default: "the usual names", example: "\"tau{n}\"", meaning: "Torques, on the side of the gear that recordings.signal says" },
    Key { name: "command", form: Form::Either(&[Form::Text, Form::Table(POSITION_KEYS)]), unit: "rad (m)", default: "the usual names", example: "\"q_cmd_{n}\"", meaning: "Commanded positions, for the signal \"position_command\"" },
    Key { name: "velocity_command", form: Form::Either(&[Form::Text, Form::Table(VELOCITY_KEYS)]), unit: "rad/s (m/s)", default: "the usual names, if there; otherwise the controller damps the speed itself", example: "\"dq_cmd_{n}\"", meaning: "Commanded speeds" },
    Key { name: "feed_forward", form: Form::Either(&[Form::Text, Form::Table(TORQUE_KEYS)]), unit: "N·m (N)", default: "the usual names, if there", example: "\"tau_ff_{n}\"", meaning: "Torques at the joint side that the controller adds" },
    Key { name: "wrench", form: Form::List(&Form::Text, Length::Exactly(6)), unit: "N, N·m", default: "fx, fy, fz, mx, my and mz", example: "[\"fx\", \"fy\", \"fz\", \"mx\", \"my\", \"mz\"]", meaning: "Forces along x, y, z, then moments" },
    Key { name: "temperature", form: Form::Either(&[Form::Text, Form::Table(BARE_KEYS)]), unit: "°C", default: "the usual names, if there", example: "\"temp{n}\"", meaning: "Temperatures of the drives" },
    Key { name: "mask", form: Form::Either(&[Form::Text, Form::Table(BARE_KEYS)]), unit: "", default: "every sample counts", example: "\"valid\"", meaning: "Samples with 0 are left out" },
];

/// Where the columns of a channel are.
pub(super) const COLUMNS_AT: Form = Form::Either(&[
    Form::Text,
    Form::Count(1),
    Form::List(&Form::Text, Length::Some),
    Form::List(&Form::Count(1), Length::Some),
]);

/// Keys of a column of time stamps.
#[rustfmt::skip]
pub(crate) const TIME_KEYS: &[Key] = &[
    Key { name: "column", form: COLUMNS_AT, unit: "", default: REQUIRED, example: "1", meaning: "A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint" },
    Key { name: "unit", form: Form::Words(time_units), unit: "", default: "SI", example: "\"ms\"", meaning: "Unit of the stamps" },
];

/// Keys of a column of positions.
#[rustfmt::skip]
pub(crate) const POSITION_KEYS: &[Key] = &[
    Key { name: "column", form: COLUMNS_AT, unit: "", default: REQUIRED, example: "\"Winkel_{n}\"", meaning: "A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint" },
    Key { name: "unit", form: Form::Either(&[Form::Words(position_units), Form::List(&Form::Words(position_units), Length::Any)]), unit: "", default: "SI", example: "\"deg\"", meaning: "One for all joints, or one for each" },
    Key { name: "per_turn", form: Form::Number(Range::Positive), unit: "", default: "none", example: "65536", meaning: "Counts in a turn, for the unit \"count\"" },
];

/// Keys of a column of velocities.
#[rustfmt::skip]
pub(crate) const VELOCITY_KEYS: &[Key] = &[
    Key { name: "column", form: COLUMNS_AT, unit: "", default: REQUIRED, example: "[5, 6]", meaning: "A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint" },
    Key { name: "unit", form: Form::Either(&[Form::Words(velocity_units), Form::List(&Form::Words(velocity_units), Length::Any)]), unit: "", default: "SI", example: "\"rpm\"", meaning: "One for all joints, or one for each" },
];

/// Keys of a column of accelerations.
#[rustfmt::skip]
pub(crate) const ACCELERATION_KEYS: &[Key] = &[
    Key { name: "column", form: COLUMNS_AT, unit: "", default: REQUIRED, example: "\"acc_{n}\"", meaning: "A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint" },
    Key { name: "unit", form: Form::Either(&[Form::Words(acceleration_units), Form::List(&Form::Words(acceleration_units), Length::Any)]), unit: "", default: "SI", example: "\"deg/s^2\"", meaning: "One for all joints, or one for each" },
];

/// Keys of a column of currents.
#[rustfmt::skip]
pub(crate) const CURRENT_KEYS: &[Key] = &[
    Key { name: "column", form: COLUMNS_AT, unit: "", default: REQUIRED, example: "[\"left\", \"right\"]", meaning: "A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint" },
    Key { name: "unit", form: Form::Either(&[Form::Words(current_units), Form::List(&Form::Words(current_units), Length::Any)]), unit: "", default: "SI", example: "\"mA\"", meaning: "One for all joints, or one for each" },
];

/// Keys of a column of torques.
#[rustfmt::skip]
pub(crate) const TORQUE_KEYS: &[Key] = &[
    Key { name: "column", form: COLUMNS_AT, unit: "", default: REQUIRED, example: "\"M_{joint}\"", meaning: "A name, in which {joint} stands for the joint's name and {n} for its number from 1; a number from 1; or a list of either, one for each joint" },
    Key { name: "unit", form: Form::Either(&[Form::Words(torque_units), Form::List(&Form::Words(torque_units), Length::Any)]), unit: "", default: "SI", example: "\"mNm\"", meaning: "One for all joints, or one for each" },
];

/// Keys of a column without a unit.
#[rustfmt::skip]
pub(crate) const BARE_KEYS: &[Key] = &[
    Key { name: "column", form: COLUMNS_AT, unit: "", default: REQUIRED, example: "4", meaning: "A name, a number from 1, or a list of either, one for each joint" },
];

/// The table `[recordings.columns]`: names of columns or channels, in which `{joint}` stands for
/// the joint's name and `{n}` for its number from 1, or tables `{ column = …, unit = … }`. Every key
/// is optional; an absent one leaves
/// the name to the reader of recordings.
#[derive(Debug, Clone)]
pub struct ColumnsTable {
    /// s.
    pub time: Option<Located<Column>>,
    /// rad (m), or the motor's turns in rad.
    pub position: Option<Located<Column>>,
    /// rad/s (m/s).
    pub velocity: Option<Located<Column>>,
    /// rad/s² (m/s²).
    pub acceleration: Option<Located<Column>>,
    /// A.
    pub current: Option<Located<Column>>,
    /// N·m (N).
    pub torque: Option<Located<Column>>,
    /// Commanded positions, rad (m).
    pub command: Option<Located<Column>>,
    /// Commanded speeds, rad/s (m/s).
    pub velocity_command: Option<Located<Column>>,
    /// Torques that are fed forward, N·m (N).
    pub feed_forward: Option<Located<Column>>,
    /// Forces along x, y, z in N, then moments in N·m.
    pub wrench: Option<Located<[String; 6]>>,
    /// °C.
    pub temperature: Option<Located<Column>>,
    /// Samples with 0 are left out.
    pub mask: Option<Located<Column>>,
}

impl ColumnsTable {
    /// Checks that lists of columns and of units have an entry for each joint.
    ///
    /// # Errors
    /// `wrong-length`, where one has not.
    pub fn check_one_per_joint(&self, joints: &[String]) -> Result<(), ProblemFileError> {
        let given = [
            &self.position,
            &self.velocity,
            &self.acceleration,
            &self.current,
            &self.torque,
            &self.command,
            &self.velocity_command,
            &self.feed_forward,
            &self.temperature,
        ];
        for entry in given.into_iter().flatten() {
            let columns = match &entry.at {
                ColumnsAt::Pattern(_) => None,
                ColumnsAt::Names(names) => Some(names.len()),
                ColumnsAt::Numbers(numbers) => Some(numbers.len()),
            };
            let units = match &entry.factors {
                Factors::Same(_) => None,
                Factors::PerJoint(factors) => Some(factors.len()),
            };
            for found in columns.into_iter().chain(units) {
                check_length(found, joints, "", &entry.place)?;
            }
        }
        Ok(())
    }

    pub(super) fn from_node(node: &Node) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, COLUMNS_KEYS)?;
        Ok(Self {
            time: reader.optional("time", |n| column(n, TIME_KEYS, Some(Quantity::Time)))?,
            position: reader.optional("position", |n| {
                column(n, POSITION_KEYS, Some(Quantity::Position))
            })?,
            velocity: reader.optional("velocity", |n| {
                column(n, VELOCITY_KEYS, Some(Quantity::Velocity))
            })?,
            acceleration: reader.optional("acceleration", |n| {
                column(n, ACCELERATION_KEYS, Some(Quantity::Acceleration))
            })?,
            current: reader.optional("current", |n| {
                column(n, CURRENT_KEYS, Some(Quantity::Current))
            })?,
            torque: reader
                .optional("torque", |n| column(n, TORQUE_KEYS, Some(Quantity::Torque)))?,
            command: reader.optional("command", |n| {
                column(n, POSITION_KEYS, Some(Quantity::Position))
            })?,
            velocity_command: reader.optional("velocity_command", |n| {
                column(n, VELOCITY_KEYS, Some(Quantity::Velocity))
            })?,
            feed_forward: reader.optional("feed_forward", |n| {
                column(n, TORQUE_KEYS, Some(Quantity::Torque))
            })?,
            wrench: reader.optional("wrench", |n| {
                values::array(
                    n,
                    "six names, of forces x, y, z and moments x, y, z",
                    values::text,
                )
            })?,
            temperature: reader.optional("temperature", |n| column(n, BARE_KEYS, None))?,
            mask: reader.optional("mask", |n| column(n, BARE_KEYS, None))?,
        })
    }
}

/// A channel by the pattern of its columns, or by a table with columns and unit.
pub(super) fn column(
    node: &Node,
    keys: &[Key],
    quantity: Option<Quantity>,
) -> Result<Column, ProblemFileError> {
    if let NodeValue::Text(_) = node.value {
        return Ok(Column::from(values::text(node)?.as_str()));
    }
    if let (None, NodeValue::Table(table)) = (quantity, &node.value)
        && let Some(unit) = table.get("unit")
    {
        return Err(ProblemFileError::new(
            &unit.place,
            KeyFault::Conflict {
                found: "a unit of what has none".into(),
                remedy: "leave the unit out".into(),
            },
        ));
    }
    let reader = Reader::open(node, keys)?;
    let remedy = "name the column, or give its number from 1";
    let at = reader.required("column", remedy, columns_at)?.value;
    let per_turn = reader.optional("per_turn", values::positive)?;
    let unit = reader.node("unit");
    let Some(quantity) = quantity else {
        return Ok(Column {
            at,
            factors: Factors::SI,
        });
    };
    let listed = match unit.map(|node| &node.value) {
        Some(NodeValue::List(units)) => units.iter().collect(),
        _ => Vec::from_iter(unit),
    };
    let is_count =
        |node: &&Node| matches!(&node.value, NodeValue::Text(unit) if unit == units::COUNT);
    if let (Some(size), false) = (&per_turn, listed.iter().any(is_count)) {
        return Err(ProblemFileError::new(
            &size.place,
            KeyFault::Conflict {
                found: "per_turn without the unit \"count\"".into(),
                remedy: "say unit = \"count\", or leave per_turn out".into(),
            },
        ));
    }
    let factor = |node: &Node| factor(node, quantity, per_turn.as_ref());
    let factors = match unit {
        None => Factors::SI,
        Some(node) => match &node.value {
            NodeValue::List(_) if quantity == Quantity::Time => {
                return Err(values::wrong_type(node, "one unit"));
            }
            NodeValue::List(units) => {
                Factors::PerJoint(units.iter().map(factor).collect::<Result<_, _>>()?)
            }
            _ => Factors::Same(factor(node)?),
        },
    };
    Ok(Column { at, factors })
}

pub(super) fn time_units() -> Vec<&'static str> {
    units::names(Quantity::Time)
}

pub(super) fn position_units() -> Vec<&'static str> {
    units::names(Quantity::Position)
}

pub(super) fn velocity_units() -> Vec<&'static str> {
    units::names(Quantity::Velocity)
}

pub(super) fn acceleration_units() -> Vec<&'static str> {
    units::names(Quantity::Acceleration)
}

pub(super) fn current_units() -> Vec<&'static str> {
    units::names(Quantity::Current)
}

pub(super) fn torque_units() -> Vec<&'static str> {
    units::names(Quantity::Torque)
}

/// A pattern, a number, or a list of either, one for each joint.
pub(super) fn columns_at(node: &Node) -> Result<ColumnsAt, ProblemFileError> {
    let is_text = |node: &Node| matches!(node.value, NodeValue::Text(_));
    match &node.value {
        NodeValue::Text(_) => Ok(ColumnsAt::Pattern(values::text(node)?)),
        NodeValue::List(items) if items.is_empty() => Err(values::wrong_type(
            node,
            "a name, a number, or a list of either",
        )),
        NodeValue::List(items) if items.iter().all(is_text) => {
            let names = items.iter().map(values::text);
            Ok(ColumnsAt::Names(names.collect::<Result<_, _>>()?))
        }
        NodeValue::List(items) => {
            let numbers = items.iter().map(values::count);
            Ok(ColumnsAt::Numbers(numbers.collect::<Result<_, _>>()?))
        }
        _ => Ok(ColumnsAt::Numbers(vec![values::count(node)?])),
    }
}

/// What turns a unit into SI.
pub(super) fn factor(
    node: &Node,
    quantity: Quantity,
    per_turn: Option<&Located<f64>>,
) -> Result<f64, ProblemFileError> {
    let unit = values::text(node)?;
    match (
        per_turn,
        unit == units::COUNT && quantity == Quantity::Position,
    ) {
        (Some(per_turn), true) => Ok(units::of_counts(per_turn.value)),
        (None, true) => Err(ProblemFileError::new(
            &node.place,
            KeyFault::Conflict {
                found: "the unit \"count\" without its size".into(),
                remedy: "say how many counts make a turn: per_turn = 65536".into(),
            },
        )),
        (_, false) => units::factor(quantity, &unit).ok_or_else(|| {
            let known = units::names(quantity).into_iter().map(String::from);
            ProblemFileError::new(
                &node.place,
                ValueFault::UnknownWord {
                    noun: "unit",
                    code: "unknown-unit",
                    found: unit.clone(),
                    known: known.collect(),
                },
            )
        }),
    }
}
