//! Values that are given as known and that no physics has: an earlier fit may have left them, or a slip.

use crate::chain::model::Model;
use crate::check::report::finding;
use crate::fault::{Description, Place};
use crate::outcome::check::{Mistake, Severity};
use crate::problem_file::ProblemFile;

pub(super) fn check(problem: &ProblemFile, model: &Model) -> Vec<Mistake> {
    let mut findings = Vec::new();
    for (effect, first) in model.joints().iter().flat_map(|joint| &joint.effects) {
        for (info, parameter) in effect.parameters.iter().zip(&model.parameters()[*first..]) {
            let beyond = match parameter.is_free() {
                true => None,
                false => info.beyond_physics(parameter.value),
            };
            findings.extend(beyond.map(|words| {
                finding(
                    Severity::Warning,
                    Place::file(&problem.path).key(&parameter.name),
                    Description::new(
                        "value-beyond-physics",
                        format!("this known value is none that physics has: {words}"),
                        "fit it with estimator = \"feasible\", which keeps such limits, or correct the value",
                    ),
                )
            }));
        }
    }
    findings
}
