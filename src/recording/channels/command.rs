//! Commands of position controllers: positions, and beside them perhaps speeds and torques.
//!
//! The signal of a recording begins with the commanded positions of the joints; commanded speeds and torques that are fed
//! forward follow where they were recorded.

use crate::recording::channels::column_map::{Column, ColumnMap};
use crate::recording::channels::samples::{Commanded, Recording};

impl Commanded {
    /// The columns of the commands of a map, in the order of the signal.
    pub(in crate::recording) fn columns(self, map: &ColumnMap) -> Vec<&Option<Column>> {
        let speeds = self.velocity.then_some(&map.velocity_command);
        let torques = self.feed_forward.then_some(&map.feed_forward);
        let positions = std::iter::once(&map.command);
        positions.chain(speeds).chain(torques).collect()
    }
}

impl Recording {
    /// The same with `command − position` in the place of the commanded positions.
    pub fn with_position_errors(mut self) -> Self {
        for (command, position) in self.signal.iter_mut().zip(&self.position) {
            let pairs = command.iter_mut().zip(position);
            pairs.for_each(|(command, position)| *command -= position);
        }
        self
    }
}
