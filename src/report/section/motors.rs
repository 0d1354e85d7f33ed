//! Motor constants from motions at constant speed: both stages, speed by speed.

use crate::chain::effect::knowledge::JointTerm;
use crate::chain::effect::term_name;
use crate::outcome::motors::{MotorJoint, Motors};
use crate::outcome::parameter::Parameter;
use crate::report::escape::{escape, prose};
use crate::report::number::{optional, significant};
use crate::report::plots::boxes::{Boxes, boxes};
use crate::report::plots::figure;
use crate::report::plots::law::law;
use crate::report::section::{Section, Source};
use crate::report::series::Point;
use crate::report::table::{Cell, Table};

pub(super) fn section(source: &Source) -> Option<Section> {
    let motors = source.fit()?.motors.as_ref()?;
    let parameters = &source.outcome.estimate.parameters;
    let each = || motors.joints.iter();
    let constants = each().filter_map(|joint| constants(joint, parameters));
    let friction = each().filter_map(|joint| friction(joint, parameters));
    let plots: String = constants.chain(friction).collect();
    let advice: String = motors
        .joints
        .iter()
        .filter_map(|joint| {
            let advice = joint.advice.as_ref()?;
            let (joint, advice) = (escape(&joint.joint), prose(advice));
            Some(format!("<li><b>{joint}</b>: {advice}.</li>\n"))
        })
        .collect();
    let body = format!(
        "<p class=\"hint\">First stage, at each speed: torque constant and friction torque, by least squares \
         and by the simplex of Nelder and Mead. Boxes: torque constants of single motions, quartiles and \
         ends; the line is the constant of the joint, in which precise motions weigh more. Dots: friction at each speed; lines: Coulomb and viscous friction of \
         the second stage.</p>\n{}{}<ul>\n{advice}</ul>\n<div class=\"plots small\">\n{plots}</div>\n",
        stages(motors).html(),
        comparison(motors)
    );
    Some(Section::new("motors", "Motors at constant speed", body))
}

fn stages(motors: &Motors) -> Table {
    let mut table = Table::new(&[
        "Joint",
        "Speed",
        "Samples",
        "k_ct",
        "std. dev.",
        "k_ct, simplex",
        "Friction",
        "Friction, simplex",
    ]);
    for joint in &motors.joints {
        table.begin_group();
        for at in &joint.speeds {
            table.row(vec![
                Cell::name(&joint.joint),
                Cell::Number(significant(at.speed)),
                Cell::Number(at.samples.to_string()),
                Cell::Number(optional(at.torque_constant)),
                Cell::Number(optional(at.torque_constant_std_dev)),
                Cell::Number(optional(at.torque_constant_simplex)),
                Cell::Number(optional(at.friction)),
                Cell::Number(optional(at.friction_simplex)),
            ]);
        }
    }
    table
}

/// Joints of one motor type, compared.
fn comparison(motors: &Motors) -> String {
    let mut table = Table::new(&["Same motor", "Mean k_ct", "χ²", "p of equal constants"]);
    for group in &motors.same_type {
        table.row(vec![
            Cell::text(group.joints.join(", ")),
            Cell::Number(significant(group.mean)),
            Cell::Number(significant(group.chi_squared)),
            Cell::Number(significant(group.p_value)),
        ]);
    }
    match table.is_empty() {
        true => String::new(),
        false => table.html(),
    }
}

/// Torque constants of single motions at every speed, and the constant of the joint.
fn constants(joint: &MotorJoint, parameters: &[Parameter]) -> Option<String> {
    let groups: Vec<(f64, &[f64])> = joint
        .speeds
        .iter()
        .filter(|at| !at.of_parts.is_empty())
        .map(|at| (at.speed, at.of_parts.as_slice()))
        .collect();
    let drawn = Boxes {
        reference: value(parameters, &joint.joint, "torque_constant.k_ct"),
        groups,
    };
    let caption = format!("<b>{}</b>: k_ct over the speed", escape(&joint.joint));
    let label = format!("Torque constants of {} over its speed", joint.joint);
    let svg = boxes(&drawn, "speed [rad/s or m/s]", &label);
    (!drawn.groups.is_empty()).then(|| figure(&caption, &svg))
}

fn value(parameters: &[Parameter], joint: &str, name: &str) -> Option<f64> {
    let name = format!("{joint}.{name}");
    parameters.iter().find(|p| p.name == name)?.value
}

/// Friction at every speed, and the law that the second stage fits to it.
fn friction(joint: &MotorJoint, parameters: &[Parameter]) -> Option<String> {
    let of = |name: &str| value(parameters, &joint.joint, name);
    let (coulomb, viscous) = (
        of(&term_name(JointTerm::DryFriction))?,
        of(&term_name(JointTerm::ViscousFriction))?,
    );
    let offset = of(&term_name(JointTerm::Offset)).unwrap_or(0.0);
    let at = joint.speeds.iter();
    let dots: Vec<Point> = at.filter_map(|at| Some((at.speed, at.friction?))).collect();
    let branch = |sign: f64| -> Vec<Point> {
        let fastest = dots.iter().map(|p| sign * p.0).fold(0.0, f64::max);
        let torque = |speed: f64| offset + sign * coulomb + viscous * speed;
        [0.0, sign * fastest].map(|v| (v, torque(v))).to_vec()
    };
    let caption = format!("<b>{}</b>: friction over the speed", escape(&joint.joint));
    let label = format!("Friction of {} over its speed", joint.joint);
    let lines = [branch(-1.0), branch(1.0)];
    let drawn = law(&dots, &lines, "speed [rad/s or m/s]", &label);
    (!dots.is_empty()).then(|| figure(&caption, &drawn))
}
