//! What was done to the recordings before the fit.

use crate::outcome::Part;
use crate::report::section::{Section, Source};
use crate::report::table::{Cell, Table};

pub(super) fn section(source: &Source) -> Option<Section> {
    let lines = match &source.outcome.part {
        Part::Fit(fit) => &fit.preprocessing,
        Part::Diagnose(diagnosis) => &diagnosis.preprocessing,
        _ => return None,
    };
    if lines.is_empty() {
        return None;
    }
    let mut table = Table::new(&["Recording", "Channel", "What was done"]);
    let mut recording = "";
    for line in lines {
        if line.recording != recording {
            recording = &line.recording;
            table.begin_group();
        }
        table.row(vec![
            Cell::name(&line.recording),
            Cell::text(line.channel.as_deref().unwrap_or_default()),
            Cell::text(&line.text),
        ]);
    }
    Some(Section::new("preprocessing", "Preprocessing", table.html()))
}
