//! The load as a body: its principal axes, and whether a body can have its parameters.

use crate::report::number::{optional, significant};
use crate::report::section::{Section, Source};
use crate::report::table::{Cell, Table};

pub(super) fn section(source: &Source) -> Option<Section> {
    let load = source.fit()?.payload.as_ref()?;
    let mut body = match load.possible {
        Some(true) => "<p>A body with these ten parameters exists.</p>\n".to_string(),
        Some(false) => "<p>No body has these ten parameters.</p>\n".to_string(),
        None => format!(
            "<p>Not determined by the recordings, each by itself: {}.</p>\n",
            load.undetermined.join(", ")
        ),
    };
    if !load.principal.is_empty() {
        let mut table = Table::new(&[
            "Principal moment",
            "Unit",
            "Std. dev.",
            "95 % from",
            "to",
            "Axis x",
            "y",
            "z",
        ]);
        for moment in &load.principal {
            let mut cells = vec![
                Cell::Number(significant(moment.value)),
                Cell::text("kg·m²"),
                Cell::Number(optional(moment.std_dev)),
            ];
            let ends = [0, 1].map(|k| optional(moment.ci95.map(|ci| ci[k])));
            cells.extend(ends.map(Cell::Number));
            cells.extend(moment.axis.map(|x| Cell::Number(significant(x))));
            table.row(cells);
        }
        body.push_str(&table.html());
    }
    Some(Section::new("load", "The load as a body", body))
}
