//! Columns of text on a terminal.

/// Space between two columns.
pub(super) const GAP: &str = "  ";

/// Rows of equal columns: the first `left` of them to the left, the others to the right.
pub(super) fn align<Row: AsRef<[String]>>(rows: &[Row], left: usize) -> Vec<String> {
    let count = rows.iter().map(|row| row.as_ref().len()).max().unwrap_or(0);
    let width = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.as_ref().get(column));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..count).map(width).collect();
    let line = |row: &Row| {
        let cells = row.as_ref().iter().zip(&widths).enumerate();
        let padded = cells.map(|(column, (cell, &width))| match column < left {
            true => format!("{cell:<width$}"),
            false => format!("{cell:>width$}"),
        });
        let padded: Vec<String> = padded.collect();
        format!("{GAP}{}", padded.join(GAP).trim_end())
    };
    rows.iter().map(line).collect()
}

/// Characters of an expression; reports and results have all of it.
const EXPRESSION: usize = 34;

/// The beginning of an expression that is too long for a column.
pub(super) fn cut(expression: &str) -> String {
    match expression.chars().count() > EXPRESSION {
        true => {
            let kept: String = expression.chars().take(EXPRESSION - 1).collect();
            format!("{}…", kept.trim_end())
        }
        false => expression.to_string(),
    }
}
