//! Which columns of a file hold which channels of a robot, and in which units.

/// Names of the columns. In a pattern `{joint}` stands for the joint's name and `{n}` for its
/// number from 1. The empty map follows the conventions of `column_names`; in any other map the
/// optional channels that it does not name are not read.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ColumnMap {
    /// Time stamps, one column.
    pub time: Option<Column>,
    /// Positions of the joints.
    pub position: Option<Column>,
    /// Velocities of the joints.
    pub velocity: Option<Column>,
    /// Accelerations of the joints.
    pub acceleration: Option<Column>,
    /// Motor currents.
    pub current: Option<Column>,
    /// Torques of joints or motors.
    pub torque: Option<Column>,
    /// Commanded positions.
    pub command: Option<Column>,
    /// Commanded speeds.
    pub velocity_command: Option<Column>,
    /// Torques that are fed forward.
    pub feed_forward: Option<Column>,
    /// Force x, y, z and moment x, y, z.
    pub wrench: Option<[String; 6]>,
    /// Temperatures of the joints, °C.
    pub temperature: Option<Column>,
    /// Samples to count, not 0, and to leave out, 0; one column.
    pub mask: Option<Column>,
}

/// Where a channel stands in a file, and what turns its numbers into SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// By pattern, number or list of columns.
    pub at: ColumnsAt,
    /// What its numbers are multiplied by, one factor for all joints or one for each.
    pub factors: Factors,
}

/// What numbers are multiplied by to be in SI units.
#[derive(Debug, Clone, PartialEq)]
pub enum Factors {
    /// One for all joints.
    Same(f64),
    /// One for each of the problem's joints.
    PerJoint(Vec<f64>),
}

impl Factors {
    /// Of numbers that are in SI units already.
    pub const SI: Self = Self::Same(1.0);
}

/// How the columns of the joints are told.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ColumnsAt {
    /// `{joint}` stands for the joint's name and `{n}` for its number.
    Pattern(String),
    /// Names, one for each of the problem's joints.
    Names(Vec<String>),
    /// Positions in the file from 1, one for each of the problem's joints.
    Numbers(Vec<usize>),
}

impl From<&str> for Column {
    fn from(pattern: &str) -> Self {
        Self {
            at: ColumnsAt::Pattern(pattern.to_string()),
            factors: Factors::SI,
        }
    }
}

impl Column {
    /// The name of the column of a joint with a number from 1; `None` where columns are told by their positions in a file
    /// that is yet to be written.
    pub fn label(&self, name: &str, number: usize) -> Option<String> {
        match &self.at {
            ColumnsAt::Pattern(pattern) => Some(expand(pattern, name, number)),
            ColumnsAt::Names(names) => names.get(number - 1).cloned(),
            ColumnsAt::Numbers(_) => None,
        }
    }

    /// What numbers of a joint with a number from 1 are multiplied by.
    pub fn factor(&self, number: usize) -> f64 {
        match &self.factors {
            Factors::Same(factor) => *factor,
            Factors::PerJoint(factors) => factors.get(number - 1).copied().unwrap_or(1.0),
        }
    }
}

/// The name that a pattern stands for.
pub fn expand(pattern: &str, name: &str, number: usize) -> String {
    // The number first: a joint's name may hold braces, a number cannot.
    pattern
        .replace("{n}", &number.to_string())
        .replace("{joint}", name)
}
