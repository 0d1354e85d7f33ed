//! Tables of the page: numbers right-aligned at the decimal point, everything else escaped text.

use crate::report::escape::{breakable, escape, prose};

/// Space as wide as a digit, and as wide as a point: they align numbers of unlike precision.
const FIGURE_SPACE: char = '\u{2007}';
const POINT_SPACE: char = '\u{2008}';

/// What a cell holds; text is as given by the user and escaped here.
#[derive(Debug, Clone)]
pub(super) enum Cell {
    Text(String),
    /// An identifier that may break at its points, with a remark below it.
    Name {
        name: String,
        remark: String,
    },
    /// A number already formatted; aligned with the others of its column.
    Number(String),
    /// A word that carries a class of the style sheet of the same name.
    Mark(&'static str),
    /// HTML that is already safe.
    Html(String),
}

/// A table with one header row.
#[derive(Debug, Default)]
pub(super) struct Table {
    headers: Vec<String>,
    rows: Vec<Vec<Cell>>,
    /// Rows before which a rule is drawn.
    groups: Vec<usize>,
}

impl Table {
    pub fn new(headers: &[&str]) -> Self {
        Self {
            headers: headers.iter().map(|header| header.to_string()).collect(),
            ..Self::default()
        }
    }

    pub fn row(&mut self, cells: Vec<Cell>) {
        self.rows.push(cells);
    }

    /// Sets the next row apart from those before it.
    pub fn begin_group(&mut self) {
        self.groups.push(self.rows.len());
    }

    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The table in a box that scrolls sideways; every cell bears the head of its column, which a phone shows above it.
    pub fn html(&self) -> String {
        let fractions = self.fraction_widths();
        let mut out = String::from("<div class=\"scroll\"><table>\n<thead><tr>");
        for (index, header) in self.headers.iter().enumerate() {
            let class = if fractions[index].is_some() {
                " class=\"number\""
            } else {
                ""
            };
            out.push_str(&format!("<th{class}>{}</th>", escape(header)));
        }
        out.push_str("</tr></thead>\n<tbody>\n");
        for (index, row) in self.rows.iter().enumerate() {
            out.push_str(if self.groups.contains(&index) {
                "<tr class=\"group\">"
            } else {
                "<tr>"
            });
            for ((cell, head), fraction) in row.iter().zip(&self.headers).zip(&fractions) {
                let class = match cell {
                    Cell::Number(_) => " class=\"number\"",
                    _ => "",
                };
                let content = cell.html(fraction.unwrap_or(0));
                out.push_str(&format!(
                    "<td{class} data-label=\"{}\">{content}</td>",
                    escape(head)
                ));
            }
            out.push_str("</tr>\n");
        }
        out.push_str("</tbody></table></div>\n");
        out
    }

    /// By column, the longest part from the point on, in characters; absent without numbers.
    fn fraction_widths(&self) -> Vec<Option<usize>> {
        let mut widths = vec![None; self.headers.len()];
        for row in &self.rows {
            for (cell, width) in row.iter().zip(&mut widths) {
                if let Cell::Number(text) = cell {
                    *width = Some(width.unwrap_or(0).max(fraction_width(text)));
                }
            }
        }
        widths
    }
}

impl Cell {
    pub fn text(text: impl Into<String>) -> Self {
        Cell::Text(text.into())
    }

    /// An identifier without a remark.
    pub fn name(name: &str) -> Self {
        Cell::Name {
            name: name.to_string(),
            remark: String::new(),
        }
    }

    /// What stands in the cell; a number has space after it to so many characters from the point on.
    fn html(&self, fraction: usize) -> String {
        match self {
            Cell::Text(text) => prose(text),
            Cell::Name { name, .. } if name.is_empty() => String::new(),
            Cell::Name { name, remark } if remark.is_empty() => {
                format!("<code>{}</code>", breakable(name))
            }
            Cell::Name { name, remark } => format!(
                "<code>{}</code><small>{}</small>",
                breakable(name),
                prose(remark)
            ),
            Cell::Number(text) => escape(&padded(text, fraction)),
            Cell::Mark(word) => format!("<span class=\"{word}\">{word}</span>"),
            Cell::Html(html) => html.clone(),
        }
    }
}

/// Characters from the decimal point on; none for a number with an exponent, which stands alone.
fn fraction_width(text: &str) -> usize {
    if text.contains('e') {
        return 0;
    }
    text.find('.').map_or(0, |point| text.len() - point)
}

/// The number with as much space after it as its fraction lacks to `width` characters.
fn padded(text: &str, width: usize) -> String {
    let own = fraction_width(text);
    let is_plain =
        text.chars().next_back().is_some_and(|c| c.is_ascii_digit()) && !text.contains('e');
    let mut out = text.to_string();
    if is_plain && own < width {
        let mut missing = width - own;
        if own == 0 {
            out.push(POINT_SPACE);
            missing -= 1;
        }
        out.extend(std::iter::repeat_n(FIGURE_SPACE, missing));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimal_points_stand_below_each_other() {
        assert_eq!(padded("12.5", 4), "12.5\u{2007}\u{2007}");
        assert_eq!(padded("12", 3), "12\u{2008}\u{2007}\u{2007}");
        assert_eq!(padded("1.5e7", 4), "1.5e7");
        assert_eq!(padded("6.25 %", 4), "6.25 %");
    }

    #[test]
    fn every_cell_bears_the_head_of_its_column() {
        let mut table = Table::new(&["Joint", "RMSE <held out>"]);
        table.row(vec![Cell::name("a1"), Cell::Number("0.5".to_string())]);
        let html = table.html();
        assert!(html.contains("<td data-label=\"Joint\"><code>a1</code></td>"));
        assert!(
            html.contains("<td class=\"number\" data-label=\"RMSE &lt;held out&gt;\">0.5</td>")
        );
    }

    #[test]
    fn text_of_users_is_escaped_in_every_kind_of_cell() {
        let bad = "<b>&\"".to_string();
        let mut table = Table::new(&["<h>", "b", "c"]);
        table.row(vec![
            Cell::Text(bad.clone()),
            Cell::Name {
                name: bad.clone(),
                remark: bad.clone(),
            },
            Cell::Number(bad),
        ]);
        let html = table.html();
        assert!(!html.contains("<b>") && !html.contains("<h>"));
        assert_eq!(html.matches("&lt;b&gt;&amp;&quot;").count(), 4);
    }
}
