//! Two results side by side on a terminal.

use crate::outcome::compare::{Compared, ComparedJoint, ComparedParameter};
use crate::report::number::{optional, percent, significant};
use crate::report::terminal::{align, cut};

/// What two results, by their names, say of the same.
pub fn text(compared: &Compared, names: [&str; 2]) -> String {
    let [first, second] = names;
    let mut lines = vec![format!("first: {first}"), format!("second: {second}")];
    lines.extend(parameter_lines(&compared.parameters));
    let differing = compared.parameters.iter().filter(|p| p.differs).count();
    let tested = compared
        .parameters
        .iter()
        .filter(|p| p.p_value.is_some())
        .count();
    if tested > 0 {
        lines.push(format!(
            "{differing} of {tested} differ significantly (5 % over all of them, Holm's correction)"
        ));
        lines.push(match compared.shared.is_empty() {
            true => "standard deviations of differences are those of independent data".to_owned(),
            false => format!(
                "the two are not independent: both are made of {}; standard deviations of differences assume that they are",
                compared.shared.join(", ")
            ),
        });
    }
    if let Some(together) = &compared.together {
        lines.push(format!(
            "all together: chi-squared {} of {} independent parameters, p = {}",
            significant(together.chi_squared),
            together.freedom,
            significant(together.p_value)
        ));
    }
    lines.extend(joint_lines(&compared.joints));
    for finding in &compared.findings {
        let probable = |p: Option<f64>| {
            p.map_or("not found".to_owned(), |p| {
                format!("{} probable", percent(p))
            })
        };
        lines.push(format!(
            "finding: {} on {}: first {}, second {}",
            finding.effect,
            finding.joints.join(", "),
            probable(finding.first),
            probable(finding.second)
        ));
    }
    for (which, names) in [
        ("first", &compared.only_first),
        ("second", &compared.only_second),
    ] {
        if !names.is_empty() {
            lines.push(format!("only in the {which}: {}", names.join(", ")));
        }
    }
    if compared.parameters.is_empty() && compared.joints.is_empty() {
        lines.push("the two have no parameter and no joint in common".to_owned());
    }
    lines.join("\n")
}

/// Parameters that differ; what is equal, or has no value in either, is counted.
fn parameter_lines(parameters: &[ComparedParameter]) -> Vec<String> {
    let headers = [
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
    let mut rows = vec![headers.map(str::to_owned)];
    let (mut same, mut empty) = (0, 0);
    for p in parameters {
        match (p.difference, p.first.value.or(p.second.value)) {
            (_, None) => empty += 1,
            (Some(0.0), _) => same += 1,
            _ => rows.push([
                cut(&p.name),
                p.unit.clone(),
                optional(p.first.value),
                optional(p.first.std_dev),
                optional(p.second.value),
                optional(p.second.std_dev),
                optional(p.difference),
                optional(p.deviations),
                if p.differs { "differs" } else { "" }.to_owned(),
            ]),
        }
    }
    let mut lines = Vec::new();
    if rows.len() > 1 {
        lines.extend(align(&rows, 2));
    }
    if same + empty > 0 {
        lines.push(format!(
            "not shown: {same} equal, {empty} undetermined in both"
        ));
    }
    lines
}

fn joint_lines(joints: &[ComparedJoint]) -> Vec<String> {
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
    rows.extend(joints.iter().map(|joint| {
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
    align(&rows, 2)
}
