//! Fitted parameters on a terminal: a row for each joint or link, base parameters side by side.

use std::collections::BTreeSet;

use crate::outcome::fit::BaseParameter;
use crate::outcome::parameter::{Parameter, Source};
use crate::report::number::{significant, with_deviation};
use crate::report::terminal::{GAP, align, cut};

/// Characters of a line: what a terminal shows beside another window.
const LINE: usize = 100;

/// Fewest lines in which some base parameters are told: their number, four of them, and where the rest is.
const LEAST_BASE: usize = 4;

/// Prefix of the parameters of a load, which have a table of their own.
pub(super) const LOAD: &str = "payload.";

/// Lines that tell of the other tables and of base parameters where there is no room for them.
const COUNTED: usize = 2;

/// Rows of some quantities under one head.
struct Table {
    heads: Vec<String>,
    lines: Vec<String>,
}

/// Every estimated parameter that has a value and is not of a load; known ones beside estimates of the same quantity. The first
/// table, and of the others those that `room` lines have space for.
pub(super) fn lines(parameters: &[Parameter], room: usize) -> Vec<String> {
    let of_joint = |p: &&Parameter| p.name.matches('.').count() > 1;
    let valued = || valued(parameters);
    let of_joints: Vec<&Parameter> = valued().filter(of_joint).collect();
    let others = valued().filter(|p| !of_joint(p) && p.source != Source::Known);
    let others: Vec<&Parameter> = others.collect();
    let tables = tables("joint", &of_joints);
    let tables = tables.into_iter().chain(self::tables("of", &others));
    let (mut lines, mut others) = (Vec::new(), Vec::new());
    for (k, table) in tables.enumerate() {
        match k == 0 || lines.len() + table.lines.len() + COUNTED <= room {
            true => lines.extend(table.lines),
            false => others.extend(table.heads),
        }
    }
    if !others.is_empty() {
        let others = others.join(", ");
        lines.push(format!("{others}: in the report and in result.json"));
    }
    lines
}

fn valued(parameters: &[Parameter]) -> impl Iterator<Item = &Parameter> {
    let has_value = |p: &&Parameter| p.value.is_some() && !p.name.starts_with(LOAD);
    parameters.iter().filter(has_value)
}

/// Base parameters that are no parameter by themselves, in at most `room` lines, or one that counts them.
pub(super) fn base(parameters: &[Parameter], base: &[BaseParameter], room: usize) -> Vec<String> {
    let single: BTreeSet<&str> = valued(parameters).map(|p| p.name.as_str()).collect();
    let is_told = |b: &&BaseParameter| {
        let expression = b.expression.as_str();
        single.contains(expression) || expression.starts_with(LOAD)
    };
    let combined: Vec<&BaseParameter> = base.iter().filter(|b| !is_told(b)).collect();
    let mut lines = base_lines(&combined);
    if lines.len() <= room {
        return lines;
    }
    if room < LEAST_BASE {
        let count = combined.len();
        return vec![format!(
            "{count} base parameters: in the report and in result.json"
        )];
    }
    lines.truncate(room - 1);
    lines.push(format!(
        "{GAP}… and the rest in the report and in result.json"
    ));
    lines
}

/// A row for each owner, a column for each of its quantities, in as many tables as the width of a line asks for.
fn tables(owner: &str, parameters: &[&Parameter]) -> Vec<Table> {
    let mut owners: Vec<&str> = Vec::new();
    let mut quantities: Vec<&str> = Vec::new();
    for (of, quantity) in parameters.iter().filter_map(|p| p.name.split_once('.')) {
        if !owners.contains(&of) {
            owners.push(of);
        }
        if !quantities.contains(&quantity) {
            quantities.push(quantity);
        }
    }
    let is_estimated = |quantity: &&str| {
        let own = |p: &&&Parameter| p.name.split_once('.').is_some_and(|(_, q)| q == *quantity);
        let mut own = parameters.iter().filter(own);
        own.any(|p| p.source != Source::Known)
    };
    quantities.retain(|quantity| is_estimated(quantity));
    let mut first = vec![owner.to_string()];
    first.extend(owners.iter().map(|of| of.to_string()));
    let columns = quantities.iter().map(|quantity| {
        let own: Vec<&&Parameter> = parameters
            .iter()
            .filter(|p| p.name.split_once('.').is_some_and(|(_, q)| q == *quantity))
            .collect();
        column(short(quantity, &quantities), &own, &owners)
    });
    let groups = grouped(columns.collect(), width(&first)).into_iter();
    let table = |group: Vec<Vec<String>>| {
        let has_any = |row: &usize| group.iter().any(|column| !column[*row].is_empty());
        let rows: Vec<Vec<String>> = (0..first.len())
            .filter(has_any)
            .map(|row| {
                let cells = group.iter().map(|column| column[row].clone());
                std::iter::once(first[row].clone()).chain(cells).collect()
            })
            .collect();
        Table {
            heads: group.iter().map(|column| column[0].clone()).collect(),
            lines: align(&rows, 1),
        }
    };
    groups.map(table).collect()
}

/// The name of a quantity without its effect, where no other has the same.
fn short<'q>(quantity: &'q str, all: &[&str]) -> &'q str {
    let last = |name: &'q str| name.rsplit('.').next().unwrap_or(name);
    let own = last(quantity);
    let alike = all.iter().filter(|q| q.rsplit('.').next() == Some(own));
    match alike.count() {
        1 => own,
        _ => quantity,
    }
}

/// The cells of one quantity, below its name and unit; the unit stands in the cells where joints differ in it.
fn column(name: &str, parameters: &[&&Parameter], owners: &[&str]) -> Vec<String> {
    let units: BTreeSet<&str> = parameters.iter().map(|p| p.unit.as_str()).collect();
    let common = units.first().filter(|_| units.len() == 1);
    let head = match common {
        Some(&"") | None => name.to_string(),
        Some(unit) => format!("{name} [{unit}]"),
    };
    let cell = |of: &&str| {
        let own = parameters
            .iter()
            .find(|p| p.name.split_once('.').is_some_and(|(o, _)| o == *of));
        own.map_or_else(String::new, |parameter| {
            let value = value(parameter);
            match common {
                Some(_) => value,
                None => format!("{value} {}", parameter.unit),
            }
        })
    };
    std::iter::once(head)
        .chain(owners.iter().map(cell))
        .collect()
}

fn value(parameter: &Parameter) -> String {
    let value = parameter.value.unwrap_or(f64::NAN);
    let text = match parameter.std_dev {
        Some(std_dev) => with_deviation(value, std_dev),
        None => significant(value),
    };
    match parameter.source {
        Source::Data | Source::Undetermined => text,
        Source::Known | Source::Bound | Source::Prior => {
            format!("{text} ({})", parameter.source.as_str())
        }
    }
}

fn width(cells: &[String]) -> usize {
    cells
        .iter()
        .map(|cell| cell.chars().count())
        .max()
        .unwrap_or(0)
}

/// Columns in groups that fit into a line beside a first column.
fn grouped(columns: Vec<Vec<String>>, first: usize) -> Vec<Vec<Vec<String>>> {
    let mut groups: Vec<Vec<Vec<String>>> = Vec::new();
    let mut used = LINE;
    for column in columns {
        let needed = GAP.len() + width(&column);
        if used + needed > LINE {
            groups.push(Vec::new());
            used = GAP.len() + first;
        }
        used += needed;
        if let Some(group) = groups.last_mut() {
            group.push(column);
        }
    }
    groups
}

/// Base parameters, two to a line.
fn base_lines(base: &[&BaseParameter]) -> Vec<String> {
    if base.is_empty() {
        return Vec::new();
    }
    let cells = |b: &&BaseParameter| {
        let value = match (b.value, b.std_dev) {
            (Some(value), Some(std_dev)) => with_deviation(value, std_dev),
            (value, _) => value.map_or_else(String::new, significant),
        };
        [cut(&b.expression), format!("{value} {}", b.unit)]
    };
    let half = base.len().div_ceil(2);
    let rows = (0..half).map(|row| {
        let right = base.get(half + row).map(cells);
        let [name, value] = cells(&base[row]);
        let [other, its_value] = right.unwrap_or_default();
        vec![name, value, other, its_value]
    });
    let rows: Vec<Vec<String>> = rows.collect();
    let mut lines = vec![format!("{} base parameters:", base.len())];
    lines.extend(align(&rows, 4));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameter(name: &str, unit: &str, value: f64, std_dev: f64) -> Parameter {
        Parameter {
            value: Some(value),
            std_dev: Some(std_dev),
            source: Source::Data,
            ..Parameter::undetermined(name, unit)
        }
    }

    #[test]
    fn every_parameter_stands_in_the_row_of_its_joint() {
        let parameters = [
            parameter("a1.coulomb_friction.Fc", "N·m", 5.0123, 0.012),
            parameter("a2.coulomb_friction.Fc", "N·m", 2.5, 0.1),
            parameter("a2.viscous_friction.Fv", "N·m·s/rad", 1.25, 0.03),
        ];
        let expected = [
            "  joint      Fc [N·m]  Fv [N·m·s/rad]",
            "  a1     5.012 ± 0.012",
            "  a2       2.50 ± 0.10     1.250 ± 0.030",
        ];
        let lines = lines(&parameters, 40);
        let columns = |line: &str| {
            line.split_whitespace()
                .map(str::to_string)
                .collect::<Vec<_>>()
        };
        assert_eq!(lines.len(), 3);
        for (line, expected) in lines.iter().zip(expected) {
            assert_eq!(columns(line), columns(expected));
        }
    }

    #[test]
    fn base_parameters_keep_to_their_room() {
        let parameter = |k: usize| BaseParameter {
            expression: format!("link{k}.Ixx + link{k}.m"),
            unit: "kg·m²".to_string(),
            value: Some(1.0),
            std_dev: Some(0.1),
            ci95: None,
        };
        let all: Vec<BaseParameter> = (0..20).map(parameter).collect();
        for room in 0..15 {
            let lines = base(&[], &all, room);
            assert!(lines.len() <= room.max(1), "{room}: {lines:?}");
            assert!(lines[0].starts_with("20 base parameters"), "{lines:?}");
        }
        assert!(base(&[], &[], 0).is_empty());
    }

    #[test]
    fn no_line_is_wider_than_a_terminal() {
        let joints = ["shoulder_pan_joint", "wrist_3_joint"];
        let effects = ["Fc", "Fv", "w", "Fs", "vs", "sigma0", "sigma1", "R", "Jm"];
        let all = joints.iter().flat_map(|joint| {
            let own = effects
                .iter()
                .map(move |p| format!("{joint}.effect_{p}.{p}"));
            own.map(|name| parameter(&name, "N·m·s/rad", 1234.5, 0.01))
        });
        let all: Vec<Parameter> = all.collect();
        let shown = |room: usize| super::lines(&all, room);
        let lines = shown(40);
        assert!(
            lines
                .iter()
                .all(|line| line.chars().count() <= LINE + GAP.len())
        );
        // Every parameter has a value somewhere.
        let values = lines
            .iter()
            .map(|line| line.matches('±').count())
            .sum::<usize>();
        assert_eq!(values, all.len());
        // Without room for all there is the first table, and what is in the others.
        let few = shown(6);
        assert_eq!(few.len(), 4);
        assert_eq!(few[..3], lines[..3]);
        let last = &few[3];
        assert!(last.ends_with("in the report and in result.json"), "{last}");
        assert!(last.contains("Jm") && !last.contains("Fc"), "{last}");
    }
}
