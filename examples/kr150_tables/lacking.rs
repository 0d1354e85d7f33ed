//! The shipped recording, fitted by models that lack a part of the drive.

use crate::Outcome;
use crate::approach::{self, Load};
use crate::experiment::open;
use exid::estimate::task;
use exid::problem::solution::Control;
use exid::problem_file::drive::CurrentLaw;
use exid::problem_file::{Located, PerJoint, ProblemFile};
use serde::Serialize;
use std::path::Path;

/// What a model lacks, and the load that it gives.
#[derive(Debug, Serialize)]
pub struct Lacking {
    pub model: &'static str,
    pub load: Load,
    pub truth: Load,
}

/// The whole model first.
pub fn fits(path: &Path) -> Outcome<Vec<Lacking>> {
    let truth = truth(&open(path, &[], &[])?)?;
    let without_efficiency = "drive.effects=[\"coulomb_friction\", \"viscous_friction\"]";
    let without_coupling = "drive.coupling=[[1,0,0,0,0,0],[0,1,0,0,0,0],[0,0,1,0,0,0],[0,0,0,1,0,0],[0,0,0,0,1,0],[0,0,0,0,0,1]]";
    let cases: [(&str, &[&str], bool); 5] = [
        ("all of the drive", &[], true),
        ("without wrist coupling", &[without_coupling], true),
        ("without efficiency", &[without_efficiency], true),
        ("without polynomial", &[], false),
        (
            "without all three",
            &[without_efficiency, without_coupling],
            false,
        ),
    ];
    let fit = |(model, overrides, polynomial): (&'static str, &[&str], bool)| {
        let overrides: Vec<String> = overrides.iter().map(|o| (*o).to_string()).collect();
        let mut problem = open(path, &overrides, &[])?;
        if !polynomial {
            linear_current(&mut problem);
        }
        let fitted = task::run(&problem, &Control::default(), |_| {})?.fitted;
        Ok(Lacking {
            model,
            load: approach::load_of(&fitted.estimate.parameters)?,
            truth,
        })
    };
    cases.into_iter().map(fit).collect()
}

/// The constants of small currents for all currents.
fn linear_current(problem: &mut ProblemFile) {
    if let Some(CurrentLaw::Polynomial(polynomial)) = &problem.drive.current_law {
        let slopes = polynomial.value.iter().map(|c| c[1]).collect();
        problem.drive.current_law = Some(CurrentLaw::Constant(Located {
            value: PerJoint::Each(slopes),
            place: polynomial.place.clone(),
        }));
    }
}

fn truth(problem: &ProblemFile) -> Outcome<Load> {
    let given = |name: &str| -> Outcome<f64> {
        let wanted = format!("payload.{name}");
        let mut values = problem.simulate.values.iter();
        let found = values.find(|entry| entry.name == wanted);
        Ok(found.ok_or(format!("no {wanted}"))?.value.value)
    };
    let mut load = [0.0; approach::NAMES.len()];
    for (value, name) in load.iter_mut().zip(approach::NAMES) {
        *value = given(name)?;
    }
    Ok(load)
}
