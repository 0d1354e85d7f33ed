//! The recordings that `simulate` wrote, and the noise in them.

use crate::outcome::Part;
use crate::report::escape::breakable;
use crate::report::number::significant;
use crate::report::section::explorer::explorer;
use crate::report::section::{Section, Source};
use crate::report::table::{Cell, Table};

pub(super) fn section(source: &Source) -> Option<Section> {
    let Part::Simulate(simulation) = &source.outcome.part else {
        return None;
    };
    let files: String = simulation
        .files
        .iter()
        .map(|file| format!("<li><code>{}</code></li>\n", breakable(file)))
        .collect();
    let mut body = explorer(source, None, "");
    body.push_str(&format!("<h3>Files and noise</h3>\n<ul>\n{files}</ul>\n"));
    let mut table = Table::new(&["Channel", "Noise, realised std. dev.", "Unit"]);
    for noise in &simulation.realised_noise {
        table.row(vec![
            Cell::name(&noise.channel),
            Cell::Number(significant(noise.std_dev)),
            Cell::text(&noise.unit),
        ]);
    }
    if !table.is_empty() {
        body.push_str(&table.html());
    }
    Some(Section::new("simulation", "Simulated recordings", body))
}
