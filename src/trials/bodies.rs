//! Distance of the bodies of a fitted model from the robot's: inertial parameters one by one depend on how they are grouped,
//! the torque that links and rotors ask for does not.

use crate::chain::dataset::Dataset;
use crate::chain::effect::knowledge::JointTerm;
use crate::chain::effect::term_name;
use crate::chain::evaluate::bodies;
use crate::chain::model::Model;
use crate::recording::split::Split;
use crate::robot::batch::torques;
use crate::trials::plan::Plan;
use nalgebra::DVector;

/// RMS over the held-out rows and the joints of `(τ̂ − τ)/σ`, with the torque τ of links and rotors along the motion and
/// the noise σ of a sample; `None` where the links are known.
pub fn error(plan: &Plan, model: &Model, values: &DVector<f64>, data: &Dataset) -> Option<f64> {
    if plan.known_links {
        return None;
    }
    let robot = &plan.robot;
    let true_bodies: Vec<f64> = robot.tree.parameters().into_iter().collect();
    let (mut sum, mut rows) = (0.0, 0.0);
    for recording in data.of(Split::Validation) {
        let motors = recording.segment().motors;
        let truth = torques(&robot.tree, &true_bodies, motors);
        let found = torques(&robot.tree, &bodies(model, values, false), motors);
        for j in 0..robot.tree.len() {
            let rotor = format!("{}.{}", robot.name(j), term_name(JointTerm::RotorInertia));
            let true_rotor = match plan.known_rotors {
                true => robot.rotor_inertia[j],
                false => concealed(plan, &rotor),
            };
            let surplus = model.find(&rotor).map_or(0.0, |p| values[p]) - true_rotor;
            let noise = robot.noise[j] * robot.torque_constant[j];
            for row in recording.counting() {
                let error = found[j][row] - truth[j][row] + surplus * motors.ddq[j][row];
                sum += (error / noise).powi(2);
                rows += 1.0;
            }
        }
    }
    (rows > 0.0).then(|| (sum / rows).sqrt())
}

/// The true value of a parameter that is concealed; zero of others.
fn concealed(plan: &Plan, name: &str) -> f64 {
    let all = plan.concealed.iter().flat_map(|c| &c.values);
    let own = all.filter(|(own, _)| own == name).map(|(_, value)| *value);
    own.sum()
}
