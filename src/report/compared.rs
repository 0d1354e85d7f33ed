//! Two results side by side on a terminal.

use crate::outcome::compare::{Compared, ComparedFinding, ComparedJoint, ComparedParameter};
use crate::report::facts::count;
use crate::report::number::{optional, percent, significant};
use crate::report::terminal::{GAP, align, cut};

/// Lines of a brief comparison: a screen.
const MOST_LINES: usize = 40;

/// Rows of a brief comparison that do not differ, joints and findings.
const NEAREST: usize = 10;
const MOST_JOINTS: usize = 8;
const MOST_FINDINGS: usize = 6;

/// Lines around the rows of parameters: both names, the heads of the columns, and what is not shown.
const AROUND: usize = 4;

/// Characters of a line of names.
const LINE: usize = 100;

/// How much of a comparison is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// What differs, and the nearest of what does not, on one screen.
    Brief,
    /// Every row and every name.
    Everything,
}

impl Extent {
    /// The first of a list that are told.
    fn first<T>(self, all: &[T], most: usize) -> &[T] {
        match self {
            Self::Brief => &all[..all.len().min(most)],
            Self::Everything => all,
        }
    }
}

/// What two results, by their names, say of the same.
pub fn text(compared: &Compared, names: [&str; 2], extent: Extent) -> String {
    let [first, second] = names;
    let mut rest = test_lines(compared, extent);
    rest.extend(joint_lines(&compared.joints, extent));
    rest.extend(finding_lines(&compared.findings, extent));
    rest.extend(listed("only in the first:", &compared.only_first, extent));
    rest.extend(listed("only in the second:", &compared.only_second, extent));
    if compared.parameters.is_empty() && compared.joints.is_empty() {
        rest.push("the two have no parameter and no joint in common".to_owned());
    }
    let room = MOST_LINES.saturating_sub(AROUND + rest.len());
    let mut lines = vec![format!("first: {first}"), format!("second: {second}")];
    lines.extend(parameter_lines(&compared.parameters, room, extent));
    lines.extend(rest);
    lines.join("\n")
}

/// How many parameters differ, and whether all of them together do.
fn test_lines(compared: &Compared, extent: Extent) -> Vec<String> {
    let differing = compared.parameters.iter().filter(|p| p.differs).count();
    let tested = compared
        .parameters
        .iter()
        .filter(|p| p.p_value.is_some())
        .count();
    let mut lines = Vec::new();
    if tested > 0 {
        lines.push(format!(
            "{differing} of {tested} differ significantly (5 % over all of them, Holm's correction)"
        ));
        match compared.shared.is_empty() {
            true => lines.push(
                "standard deviations of differences are those of independent data".to_owned(),
            ),
            false => {
                lines.extend(listed(
                    "the two are not independent: both are made of",
                    &compared.shared,
                    extent,
                ));
                lines.push("standard deviations of differences assume that they are".to_owned());
            }
        }
    }
    lines.extend(compared.together.as_ref().map(|together| {
        format!(
            "all together: chi-squared {} of {} independent parameters, p = {}",
            significant(together.chi_squared),
            together.freedom,
            significant(together.p_value)
        )
    }));
    lines
}

fn finding_lines(findings: &[ComparedFinding], extent: Extent) -> Vec<String> {
    let probable = |p: Option<f64>| {
        p.map_or("not found".to_owned(), |p| {
            format!("{} probable", percent(p))
        })
    };
    let told = extent.first(findings, MOST_FINDINGS);
    let mut lines: Vec<String> = told
        .iter()
        .map(|finding| {
            format!(
                "finding: {} on {}: first {}, second {}",
                finding.effect,
                finding.joints.join(", "),
                probable(finding.first),
                probable(finding.second)
            )
        })
        .collect();
    lines.extend(further(findings.len() - told.len(), "finding"));
    lines
}

/// What is left out of a list.
fn further(number: usize, noun: &str) -> Option<String> {
    (number > 0).then(|| format!("and {} more", count(number, noun)))
}

/// Names after a head, as many as fit into a line; all of them on as many lines as they take.
fn listed(head: &str, names: &[String], extent: Extent) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    let mut line = head.to_owned();
    for (number, name) in names.iter().enumerate() {
        let name = match extent {
            Extent::Brief => cut(name),
            Extent::Everything => name.clone(),
        };
        let begins = number == 0;
        if !begins && line.chars().count() + name.chars().count() > LINE {
            if extent == Extent::Brief {
                lines.push(format!("{line} and {} more", names.len() - number));
                return lines;
            }
            lines.push(std::mem::replace(&mut line, GAP.to_owned()));
        }
        let comma = if number + 1 < names.len() { "," } else { "" };
        line.push_str(&format!(" {name}{comma}"));
    }
    if !names.is_empty() {
        lines.push(line);
    }
    lines
}

/// Parameters that differ, then the nearest of those that do not; what has no value in either is counted.
fn parameter_lines(parameters: &[ComparedParameter], room: usize, extent: Extent) -> Vec<String> {
    let is_empty = |p: &&ComparedParameter| p.first.value.or(p.second.value).is_none();
    let (empty, valued): (Vec<_>, Vec<_>) = parameters.iter().partition(is_empty);
    let (differing, alike): (Vec<_>, Vec<_>) = valued.into_iter().partition(|p| p.differs);
    let (equal, close): (Vec<_>, Vec<_>) =
        alike.into_iter().partition(|p| p.difference == Some(0.0));
    let far = extent.first(&differing, room);
    let near = extent.first(&close, NEAREST.min(room.saturating_sub(far.len())));
    let same = extent.first(&equal, 0);
    let mut rows = vec![HEADERS.map(str::to_owned)];
    rows.extend(far.iter().chain(near).chain(same).map(|p| row(p)));
    let mut lines = Vec::new();
    if rows.len() > 1 {
        lines.extend(align(&rows, 2));
    }
    let left_out = [
        (differing.len() - far.len(), "that differ"),
        (close.len() - near.len(), "that do not differ"),
        (equal.len() - same.len(), "equal"),
        (empty.len(), "undetermined in both"),
    ];
    let left_out = left_out.iter().filter(|(number, _)| *number > 0);
    let left_out: Vec<String> = left_out
        .map(|(number, words)| format!("{number} {words}"))
        .collect();
    if !left_out.is_empty() {
        let hint = match extent {
            Extent::Brief => " (--all shows every value)",
            Extent::Everything => "",
        };
        lines.push(format!("not shown: {}{hint}", left_out.join(", ")));
    }
    lines
}

const HEADERS: [&str; 9] = [
    "parameter",
    "unit",
    "first",
    "std. dev.",
    "second",
    "std. dev.",
    "difference",
    "in std. dev.",
    "",
];

fn row(p: &ComparedParameter) -> [String; 9] {
    [
        cut(&p.name),
        p.unit.clone(),
        optional(p.first.value),
        optional(p.first.std_dev),
        optional(p.second.value),
        optional(p.second.std_dev),
        optional(p.difference),
        optional(p.deviations),
        if p.differs { "differs" } else { "" }.to_owned(),
    ]
}

fn joint_lines(joints: &[ComparedJoint], extent: Extent) -> Vec<String> {
    if joints.is_empty() {
        return Vec::new();
    }
    let headers = [
        "joint",
        "unit",
        "RMSE train, first",
        "second",
        "held out, first",
        "second",
    ];
    let mut rows = vec![headers.map(str::to_owned)];
    let told = extent.first(joints, MOST_JOINTS);
    rows.extend(told.iter().map(|joint| {
        let unit = match &joint.unit {
            [a, b] if a == b => a.clone(),
            units => units.join(" and "),
        };
        let [train, held_out] = [
            joint.rmse_train.map(significant),
            joint.rmse_validation.map(optional),
        ];
        let [a, b] = train;
        let [c, d] = held_out;
        [joint.joint.clone(), unit, a, b, c, d]
    }));
    let mut lines = align(&rows, 2);
    lines.extend(further(joints.len() - told.len(), "joint"));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::compare::{Together, Valued};

    fn parameter(number: usize, deviations: f64, differs: bool) -> ComparedParameter {
        ComparedParameter {
            name: format!("joint{number}.coulomb_friction.Fc"),
            unit: "N·m".to_owned(),
            first: Valued {
                value: Some(1.0),
                std_dev: Some(1.0),
            },
            second: Valued {
                value: Some(1.0 + deviations),
                std_dev: Some(1.0),
            },
            difference: Some(deviations),
            deviations: Some(deviations),
            p_value: Some(0.5),
            differs,
        }
    }

    /// With as many differences, joints, findings and names as a robot may have.
    fn compared(differing: usize, alike: usize) -> Compared {
        let names = |which: &str| (0..200).map(|k| format!("{which}.{k}.mass")).collect();
        Compared {
            shared: names("recording"),
            parameters: (0..differing + alike)
                .map(|k| parameter(k, 100.0 / (k + 1) as f64, k < differing))
                .collect(),
            together: Some(Together {
                chi_squared: 4.0,
                freedom: 3,
                p_value: 0.3,
            }),
            joints: (0..30)
                .map(|k| ComparedJoint {
                    joint: format!("joint{k}"),
                    unit: ["A".to_owned(), "A".to_owned()],
                    rmse_train: [0.1, 0.2],
                    rmse_validation: [None, None],
                })
                .collect(),
            findings: (0..30)
                .map(|k| ComparedFinding {
                    effect: "backlash".to_owned(),
                    joints: vec![format!("joint{k}")],
                    first: Some(0.9),
                    second: None,
                })
                .collect(),
            only_first: std::iter::once("link1.mass + ".repeat(300))
                .chain(names("first"))
                .collect(),
            only_second: names("second"),
            level: 0.05,
        }
    }

    #[test]
    fn a_brief_comparison_fits_on_a_screen() {
        for (differing, alike) in [(0, 300), (5, 300), (300, 300)] {
            let text = text(&compared(differing, alike), ["a", "b"], Extent::Brief);
            assert!(text.lines().count() <= MOST_LINES, "{text}");
            assert!(text.lines().all(|l| l.chars().count() <= 140), "{text}");
            let shown = text.matches("coulomb_friction.Fc").count();
            assert!(shown >= differing.min(10), "{text}");
            assert!(shown <= differing + NEAREST, "{text}");
            assert_eq!(text.matches("  differs").count(), shown.min(differing));
            assert!(text.contains("that do not differ"), "{text}");
        }
    }

    #[test]
    fn everything_is_everything() {
        let text = text(&compared(5, 300), ["a", "b"], Extent::Everything);
        assert_eq!(text.matches("coulomb_friction.Fc").count(), 305);
        assert_eq!(text.matches("finding: ").count(), 30);
        assert!(text.contains("first.199.mass") && text.contains("second.199.mass"));
        assert!(!text.contains("not shown"), "{text}");
    }
}
