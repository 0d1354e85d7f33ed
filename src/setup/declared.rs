//! Effects and parameter values of the drives that the robot file declares.
//!
//! Rotor inertias are known unless they are listed as an effect. Friction and springs are effects of the model whose
//! estimates start from what the file says; `drive.values` makes them known, and `drive.effects_of` takes their place.
//! A joint that follows another gives what it has to its leader: with `q = m·q_leader + o`
//!
//! ```text
//! Jm += m² Jm'    Fv += m² Fv'    Fc += |m| Fc'    k += m² k',  k q0 += m k' (q0' − o)
//! ```

use crate::chain::effect::knowledge::JointTerm;
use crate::chain::effect::{Effect, of_term};
use crate::chain::model::{Model, Signal};
use crate::outcome::parameter::Parameter;
use crate::problem_file::ProblemFile;
use crate::robot::description::{DeclaredDrive, DeclaredSpring};
use crate::setup::robot::Robot;

/// A parameter of an effect of a joint and the value that the robot file gives it.
#[derive(Debug, Clone, Copy)]
pub struct FileValue {
    joint: usize,
    effect: &'static Effect,
    parameter: &'static str,
    value: f64,
    /// Nothing asks for an estimate.
    known: bool,
}

/// A parameter of a model and the value that the robot file gives it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeclaredValue {
    /// Position among the parameters of the model.
    pub parameter: usize,
    /// In the parameter's SI unit.
    pub value: f64,
    /// Nothing asks for an estimate.
    pub known: bool,
}

/// The effects that the robot file's values of a joint belong to.
pub(super) fn effects(
    problem: &ProblemFile,
    robot: &Robot,
    signal: Signal,
    joint: usize,
) -> Vec<&'static Effect> {
    let mut effects: Vec<&'static Effect> = Vec::new();
    for entry in entries(problem, robot, signal, joint) {
        if effects.iter().all(|effect| effect.id != entry.effect.id) {
            effects.push(entry.effect);
        }
    }
    effects
}

/// What the robot file says of the drives of all joints.
pub(super) fn file_values(problem: &ProblemFile, robot: &Robot, signal: Signal) -> Vec<FileValue> {
    let joints = 0..robot.tree.len();
    joints
        .flat_map(|k| entries(problem, robot, signal, k))
        .collect()
}

/// The parameters of a model of which the robot file has values.
pub fn values(file_values: &[FileValue], model: &Model) -> Vec<DeclaredValue> {
    let of = |entry: &FileValue| {
        let described = &model.joints()[entry.joint];
        let mut parameters = described.parameters_of(entry.effect.id);
        let (_, parameter) = parameters.find(|(info, _)| info.name == entry.parameter)?;
        Some(DeclaredValue {
            parameter,
            value: entry.value,
            known: entry.known,
        })
    };
    file_values.iter().filter_map(of).collect()
}

/// Gives a model the values of the robot file. Those outside of the bounds of their parameters start at the bound.
pub(super) fn apply(file_values: &[FileValue], model: &mut Model) {
    for declared in values(file_values, model) {
        // What is shared is estimated: the file may have another value for every joint.
        let shared = model.sharing(model.estimated_as(declared.parameter)).len() > 1;
        let known = declared.known && !shared;
        let fixed = known && model.fix(declared.parameter, declared.value).is_ok();
        if !fixed {
            model.start(declared.parameter, declared.value);
        }
    }
}

/// Where estimates leave what the robot file says out of their intervals, in one sentence.
pub fn differences(
    file_values: &[FileValue],
    model: &Model,
    estimated: &[Parameter],
) -> Option<String> {
    let differs = |declared: DeclaredValue| {
        let name = &model.parameters()[declared.parameter].name;
        let found = estimated
            .iter()
            .find(|parameter| parameter.is_called(name))?;
        let ([lower, upper], value) = (found.ci95?, found.value?);
        (declared.value < lower || declared.value > upper).then(|| {
            format!(
                "{name} {:.4} {unit} in the file, {value:.4} in the recordings (95 % from {lower:.4} to {upper:.4})",
                declared.value,
                unit = found.unit
            )
        })
    };
    let all = values(file_values, model).into_iter();
    sentence(&all.filter_map(differs).collect::<Vec<String>>())
}

/// Values of a robot file that are said to differ one by one: more fill a screen.
const MOST_SAID: usize = 4;

fn sentence(differences: &[String]) -> Option<String> {
    let said = &differences[..differences.len().min(MOST_SAID)];
    let further = match differences.len() - said.len() {
        0 => String::new(),
        count => format!("; and {count} further values"),
    };
    (!said.is_empty()).then(|| {
        format!(
            "The robot file and the recordings differ: {}{further}.",
            said.join("; ")
        )
    })
}

/// The values of a joint that moves by itself; none where the signal does not feel the joints' drives.
fn entries(problem: &ProblemFile, robot: &Robot, signal: Signal, joint: usize) -> Vec<FileValue> {
    if robot.locked[joint].is_some() || signal == Signal::BaseWrench {
        return Vec::new();
    }
    let drive = with_followers(robot, joint);
    let rotor = drive.rotor_inertia;
    let rotor = rotor.filter(|_| problem.drive.rotor_inertia.is_none());
    let name = &robot.tree.joints()[joint].name;
    let listed = |id: &str| {
        let of = problem.drive.effects_of.iter();
        let own = of.filter(|entry| entry.name == *name);
        let all = own.flat_map(|entry| entry.value.iter());
        all.chain(&problem.drive.effects).any(|e| e.value == id)
    };
    let entry = |term, index: usize, value: Option<f64>| {
        let effect = of_term(term);
        value.map(|value| FileValue {
            joint,
            effect,
            parameter: effect.parameters[index].name,
            value,
            known: term == JointTerm::RotorInertia && !listed(effect.id),
        })
    };
    let (stiffness, rest) = (
        drive.spring.map(|s| s.stiffness),
        drive.spring.map(|s| s.rest),
    );
    let entries = [
        entry(JointTerm::RotorInertia, 0, rotor),
        entry(JointTerm::ViscousFriction, 0, drive.viscous_friction),
        entry(JointTerm::DryFriction, 0, drive.coulomb_friction),
        entry(JointTerm::Spring, 0, stiffness),
        entry(JointTerm::Spring, 1, rest),
    ];
    entries.into_iter().flatten().collect()
}

/// The drive of a joint with those of the joints that follow it.
fn with_followers(robot: &Robot, joint: usize) -> DeclaredDrive {
    let drives = &robot.description.drives;
    let mut sum = drives.get(joint).copied().unwrap_or_default();
    for dependent in robot.dependents.iter().filter(|d| d.leader == joint) {
        let Some(own) = drives.get(dependent.joint) else {
            continue;
        };
        let (m, o) = (dependent.multiplier, dependent.offset);
        let plus = |a: Option<f64>, b: Option<f64>, weight: f64| match b {
            Some(b) => Some(a.unwrap_or(0.0) + weight * b),
            None => a,
        };
        sum.rotor_inertia = plus(sum.rotor_inertia, own.rotor_inertia, m * m);
        sum.viscous_friction = plus(sum.viscous_friction, own.viscous_friction, m * m);
        sum.coulomb_friction = plus(sum.coulomb_friction, own.coulomb_friction, m.abs());
        if let Some(spring) = own.spring {
            let before = sum
                .spring
                .map_or([0.0; 2], |s| [s.stiffness, s.stiffness * s.rest]);
            let stiffness = before[0] + m * m * spring.stiffness;
            let moment = before[1] + m * spring.stiffness * (spring.rest - o);
            sum.spring = Some(DeclaredSpring {
                stiffness,
                rest: moment / stiffness,
            });
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::sentence;

    #[test]
    fn a_few_differences_are_said_and_the_others_counted() {
        let of = |count: usize| {
            let names: Vec<String> = (1..=count).map(|k| format!("d{k}")).collect();
            sentence(&names)
        };
        let begins = "The robot file and the recordings differ: ";
        assert_eq!(of(0), None);
        assert_eq!(of(4), Some(format!("{begins}d1; d2; d3; d4.")));
        let many = format!("{begins}d1; d2; d3; d4; and 20 further values.");
        assert_eq!(of(24), Some(many));
    }
}
