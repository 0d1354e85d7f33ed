//! Which parameters the recordings tell apart badly: their correlations as a picture, and the strongest in a table.

use crate::report::escape::breakable;
use crate::report::number::ABSENT;
use crate::report::section::{Section, Source};
use crate::report::table::{Cell, Table};

/// From this correlation on, the interval of one parameter is more than twice as wide as it would be with the other known:
/// 1/√(1 − ρ²) ≥ 2.3.
const STRONG: f64 = 0.9;

/// Pairs that are listed.
const LISTED: usize = 12;

struct Pair<'a> {
    names: [&'a str; 2],
    correlation: f64,
}

pub(super) fn section(source: &Source) -> Option<Section> {
    if !source.exploration.has_correlations() {
        return None;
    }
    let mut pairs = strong(source);
    pairs.sort_by(|a, b| b.correlation.abs().total_cmp(&a.correlation.abs()));
    let count = pairs.len();
    let mut body = String::from(
        "<p class=\"hint\">Blue: two parameters that rise together; orange: one rises where the other falls. A strong \
         correlation means that the recordings show a combination of the two better than either by itself.</p>\n\
         <div id=\"correlation-map\"></div>\n",
    );
    if count == 0 {
        body.push_str("<p>No two parameters are correlated by more than 0.9.</p>\n");
    } else {
        let mut table = Table::new(&["Parameter", "and", "Correlation", "Intervals wider by"]);
        for pair in pairs.iter().take(LISTED) {
            let widened = 1.0 / (1.0 - pair.correlation * pair.correlation).sqrt();
            table.row(vec![
                Cell::Html(format!("<code>{}</code>", breakable(pair.names[0]))),
                Cell::Html(format!("<code>{}</code>", breakable(pair.names[1]))),
                Cell::Number(format!("{:.3}", pair.correlation)),
                Cell::Number(match widened.is_finite() {
                    true => format!("{widened:.1}"),
                    false => ABSENT.to_string(),
                }),
            ]);
        }
        let more = match count > LISTED {
            true => format!(" The {LISTED} strongest:"),
            false => String::new(),
        };
        body.push_str(&format!(
            "<p>{count} pairs are correlated by more than 0.9.{more}</p>\n{}",
            table.html()
        ));
    }
    Some(Section::new("correlations", "Correlations", body))
}

fn strong<'a>(source: &Source<'a>) -> Vec<Pair<'a>> {
    let covariance = &source.outcome.estimate.covariance;
    let (names, matrix) = (&covariance.parameters, &covariance.matrix);
    let mut pairs = Vec::new();
    for a in 0..names.len() {
        for b in 0..a {
            let correlation = matrix[a][b] / (matrix[a][a] * matrix[b][b]).sqrt();
            if correlation.abs() > STRONG {
                pairs.push(Pair {
                    names: [&names[b], &names[a]],
                    correlation: correlation.clamp(-1.0, 1.0),
                });
            }
        }
    }
    pairs
}
