//! The user's simulator beside the robot: what differs, what is in one alone, what agrees.

use crate::outcome::simulator::{Contrast, Simulator};
use crate::report::escape::prose;
use crate::report::number::{optional, percent, significant, with_deviation};
use crate::report::section::{Section, Source};
use crate::report::table::{Cell, Table};

pub(super) fn section(source: &Source) -> Option<Section> {
    let simulator = source
        .fit()
        .and_then(|fit| fit.simulator.as_ref())
        .or_else(|| source.diagnosis()?.simulator.as_ref())?;
    let mut body = format!("<p>{}</p>\n", prose(&simulator.summary));
    body.push_str(&list(simulator));
    if !simulator.differences.is_empty() {
        body.push_str(&format!(
            "<h3>What differs</h3>\n{}",
            table(&simulator.differences)
        ));
    }
    if !simulator.agree.is_empty() {
        body.push_str(&format!(
            "<details><summary>What agrees, or is too close to matter ({})</summary>\n{}</details>\n",
            simulator.agree.len(),
            table(&simulator.agree)
        ));
    }
    for note in &simulator.notes {
        body.push_str(&format!("<p class=\"hint\">{}</p>\n", prose(note)));
    }
    Some(Section::new("simulator", "Simulation and robot", body))
}

/// What is in one of the two alone.
fn list(simulator: &Simulator) -> String {
    let all = simulator.only_robot.iter().chain(&simulator.only_simulator);
    let items: Vec<String> = all
        .map(|one| format!("<li>{}</li>", prose(&one.sentence)))
        .collect();
    match items.is_empty() {
        true => String::new(),
        false => format!("<ul>\n{}\n</ul>\n", items.join("\n")),
    }
}

fn table(contrasts: &[Contrast]) -> String {
    let mut table = Table::new(&[
        "Quantity",
        "Unit",
        "Simulation",
        "Robot",
        "Difference",
        "95 % from",
        "to",
        "p",
        "Of the signal",
    ]);
    for contrast in contrasts {
        table.row(vec![
            Cell::name(&contrast.parameter),
            Cell::text(&contrast.unit),
            Cell::Number(with_deviation(
                contrast.simulated,
                contrast.simulated_std_dev,
            )),
            Cell::Number(with_deviation(contrast.robot, contrast.robot_std_dev)),
            Cell::Number(significant(contrast.difference)),
            Cell::Number(optional(contrast.ci95.map(|ends| ends[0]))),
            Cell::Number(optional(contrast.ci95.map(|ends| ends[1]))),
            Cell::Number(significant(contrast.p_value)),
            Cell::Number(percent(contrast.share_of_signal)),
        ]);
    }
    table.html()
}
