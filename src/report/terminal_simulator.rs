//! A simulator beside the robot, on a terminal: what differs and what is in one alone; what agrees as a number.

use crate::outcome::simulator::Simulator;
use crate::report::facts::count;

/// Differences that a terminal shows; the result has all.
const SHOWN: usize = 12;

pub(super) fn lines(simulator: &Simulator) -> Vec<String> {
    let mut lines = vec![format!("simulator: {}", simulator.summary)];
    let one_sided = simulator.only_robot.iter().chain(&simulator.only_simulator);
    lines.extend(one_sided.map(|one| format!("  {}", one.sentence)));
    let shown = simulator.differences.iter().take(SHOWN);
    lines.extend(shown.map(|difference| format!("  {}", difference.sentence)));
    if let Some(more @ 1..) = simulator.differences.len().checked_sub(SHOWN) {
        lines.push(format!(
            "  and {} in the result",
            count(more, "more difference")
        ));
    }
    lines.extend(simulator.notes.iter().map(|note| format!("  note: {note}")));
    lines
}
