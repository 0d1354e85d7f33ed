//! Motor constants from motions at constant speed: both stages, speed by speed.

use crate::outcome::motors::{MotorJoint, Motors};
use crate::report::html::escape;
use crate::report::number::{optional, significant};
use crate::report::plots::boxes::{Boxes, boxes};
use crate::report::plots::figure;
use crate::report::section::{Section, Source};
use crate::report::table::{Cell, Table};

pub(super) fn section(source: &Source) -> Option<Section> {
    let motors = source.fit()?.motors.as_ref()?;
    let plots: String = motors.joints.iter().filter_map(plot).collect();
    let advice: String = motors
        .joints
        .iter()
        .filter_map(|joint| {
            let advice = joint.advice.as_ref()?;
            let (joint, advice) = (escape(&joint.joint), escape(advice));
            Some(format!("<li><b>{joint}</b>: {advice}.</li>\n"))
        })
        .collect();
    let body = format!(
        "<p class=\"hint\">First stage, at each speed: torque constant and friction torque, by least squares \
         and by the simplex of Nelder and Mead. Boxes: torque constants of single motions, quartiles and \
         ends; the line is their mean.</p>\n{}{}<ul>\n{advice}</ul>\n<div class=\"plots small\">\n{plots}</div>\n",
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

fn plot(joint: &MotorJoint) -> Option<String> {
    let groups: Vec<(f64, &[f64])> = joint
        .speeds
        .iter()
        .filter(|at| !at.of_parts.is_empty())
        .map(|at| (at.speed, at.of_parts.as_slice()))
        .collect();
    let count: usize = groups.iter().map(|group| group.1.len()).sum();
    let sum: f64 = groups.iter().flat_map(|group| group.1).sum();
    let drawn = Boxes {
        reference: (count > 0).then(|| sum / count as f64),
        groups,
    };
    let caption = format!("<b>{}</b>: k_ct over the speed", escape(&joint.joint));
    let label = format!("Torque constants of {} over its speed", joint.joint);
    (count > 0).then(|| figure(&caption, &boxes(&drawn, "speed [rad/s or m/s]", &label)))
}
