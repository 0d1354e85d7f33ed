//! Robots to look at on a terminal.

use crate::outcome::fleet::Fleet;
use crate::report::facts::moment;
use crate::report::section::fleet::sure;
use crate::report::terminal::align;

/// Robots that a terminal shows.
const MOST: usize = 20;

/// What a fleet says: the sentence, and the surest of the robots to look at.
pub(super) fn lines(fleet: &Fleet) -> Vec<String> {
    let mut lines = vec![fleet.summary.clone()];
    let headers = ["robot", "type", "look at", "since", "sure"].map(str::to_string);
    let mut rows = vec![headers.to_vec()];
    for look in fleet.look_at.iter().take(MOST) {
        rows.push(vec![
            look.robot.clone(),
            look.kind_of_robot.clone(),
            look.sentence.clone(),
            look.evidence.since.map_or(String::new(), moment),
            sure(look.evidence.probability),
        ]);
    }
    if rows.len() > 1 {
        lines.extend(align(&rows, 4));
    }
    if fleet.look_at.len() > MOST {
        lines.push(format!("and {} more", fleet.look_at.len() - MOST));
    }
    lines.extend(fleet.notes.iter().map(|note| format!("note: {note}")));
    lines
}
