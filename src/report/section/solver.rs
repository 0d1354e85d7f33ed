//! How the solver ended.

use crate::report::number::significant;
use crate::report::section::{Section, Source};
use crate::report::table::{Cell, Table};

pub(super) fn section(source: &Source) -> Option<Section> {
    let solver = source.outcome.estimate.solver.as_ref()?;
    let mut table = Table::new(&[
        "Solver",
        "Stopped by",
        "Converged",
        "Iterations",
        "Evaluations",
        "Cost",
    ]);
    table.row(vec![
        Cell::text(&solver.name),
        Cell::text(solver.stop.replace('_', " ")),
        Cell::text(if solver.converged { "yes" } else { "no" }),
        Cell::Number(solver.iterations.to_string()),
        Cell::Number(solver.evaluations.to_string()),
        Cell::Number(significant(solver.cost)),
    ]);
    Some(Section::new("solver", "Solver", table.html()))
}
