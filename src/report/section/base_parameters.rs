//! The combinations of parameters that the motion determines; long ones fold.

use crate::outcome::fit::BaseParameter;
use crate::report::escape::breakable;
use crate::report::facts::count;
use crate::report::number::{ABSENT, optional, percent};
use crate::report::section::{Section, Source};
use crate::report::table::{Cell, Table};

/// Characters of an expression that are always shown: about two lines of a table on a screen.
const SHOWN: usize = 120;

pub(super) fn section(source: &Source) -> Option<Section> {
    let table = table(&source.fit()?.base_parameters)?;
    Some(Section::new("base-parameters", "Base parameters", table))
}

/// The joint-torque model that follows from base reactions.
pub(super) fn of_joint_torques(source: &Source) -> Option<Section> {
    let table = table(&source.fit()?.joint_torque_parameters)?;
    let lead = "<p>The parameters of the joint torques, as combinations of those above: no force inside the \
                robot, friction neither, is in them.</p>";
    Some(Section::new(
        "joint-torque-parameters",
        "Joint-torque model",
        format!("{lead}{table}"),
    ))
}

/// HTML of a list of combinations; `None` where it is empty.
fn table(combinations: &[BaseParameter]) -> Option<String> {
    if combinations.is_empty() {
        return None;
    }
    let headers = ["", "Combination", "Value", "Unit", "Std. dev.", "Relative"];
    let mut table = Table::new(&headers);
    for (index, base) in combinations.iter().enumerate() {
        let relative = match (base.value, base.std_dev) {
            (Some(value), Some(std_dev)) if value != 0.0 => percent(std_dev / value.abs()),
            _ => ABSENT.to_string(),
        };
        table.row(vec![
            Cell::text((index + 1).to_string()),
            Cell::Html(expression(&base.expression)),
            Cell::Number(optional(base.value)),
            Cell::text(&base.unit),
            Cell::Number(optional(base.std_dev)),
            Cell::Number(relative),
        ]);
    }
    Some(table.html())
}

/// The expression, folded after its first terms where it is long.
fn expression(text: &str) -> String {
    match term_starts(text).rfind(|position| *position <= SHOWN) {
        Some(cut) if text.len() > SHOWN => {
            let (shown, rest) = text.split_at(cut);
            let more = count(term_starts(rest).count(), "more term");
            format!(
                "<details><summary><code>{}</code><small>{more}</small></summary>\
                 <code class=\"long\">{}</code></details>",
                breakable(shown.trim_end()),
                breakable(rest)
            )
        }
        _ => format!("<code class=\"long\">{}</code>", breakable(text)),
    }
}

/// Where the signs between terms stand; that of an exponent such as `1e-3` has no space after it.
fn term_starts(text: &str) -> impl DoubleEndedIterator<Item = usize> {
    text.match_indices(['+', '-'])
        .map(|(position, _)| position)
        .filter(|position| text[position + 1..].starts_with(' '))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folds_long_expressions_between_terms_without_losing_any() {
        let terms: Vec<String> = (1..=20).map(|k| format!("1e-3*link{k}.mass")).collect();
        let html = expression(&terms.join(" + ")).replace("<wbr>", "");
        let (shown, hidden) = html.split_once("</summary>").unwrap();
        assert!(shown.starts_with("<details><summary><code>1e-3*link1.mass + "));
        for term in &terms {
            assert!(html.contains(term.as_str()), "{term}");
        }
        let more = hidden.matches("link").count();
        assert!(more > 0 && shown.matches("link").count() == 20 - more);
        assert!(
            shown.contains(&format!("<small>{more} more terms</small>")),
            "{shown}"
        );
    }

    #[test]
    fn leaves_short_expressions_whole() {
        let html = expression("link1.mass + 0.4*link2.mass");
        assert!(!html.contains("<details>"));
    }
}
