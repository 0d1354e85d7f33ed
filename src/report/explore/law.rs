//! The friction that a joint's fitted laws give over speed, in the unit of its signal.
//!
//! f(v) = Σ laws of the motor that depend on speed and direction alone; over the torque constant, where the signal is a current.

use crate::chain::effect::{
    self, Contribution, Dependence, Effect, GAIN, Law, Memory, Samples, Surroundings, TRANSITION,
    sign,
};
use crate::outcome::machine::MachineJoint;

/// f at each velocity; `None` where no such law is in the model, or the signal is no linear function of the torque.
pub(super) fn over_speed(joint: &MachineJoint, velocity: &[f64]) -> Option<Vec<f64>> {
    if joint.effects.iter().any(|e| e.id == effect::CURRENT_LAW.id) {
        return None;
    }
    let width = joint
        .value(TRANSITION.effect.id, TRANSITION.name())
        .unwrap_or(0.0);
    let sign: Vec<f64> = velocity.iter().map(|v| sign::sign(*v, width)).collect();
    let mut torque = vec![0.0; velocity.len()];
    let mut any = false;
    for own in &joint.effects {
        let Some(effect) = effect::find(&own.id).filter(|e| is_of_speed(e)) else {
            continue;
        };
        let Law::Motor(law) = effect.law else {
            continue;
        };
        let borrowed = effect
            .needs
            .borrows
            .iter()
            .map(|(of, name)| joint.value(of, name));
        let borrowed: Vec<f64> = borrowed.collect::<Option<_>>()?;
        let parameters: Vec<f64> = own
            .parameters
            .iter()
            .map(|p| p.value)
            .chain(borrowed)
            .collect();
        let still = vec![0.0; velocity.len()];
        let mut by_parameter = vec![still.clone(); parameters.len()];
        let mut by_sign = still.clone();
        let (mut by_position, mut by_velocity) = (still.clone(), still.clone());
        let samples = Samples {
            position: &still,
            velocity,
            acceleration: &still,
            sign: &sign,
            time: &[],
            cyclic: false,
            surroundings: Surroundings::default(),
        };
        law.add(
            samples,
            &parameters,
            &mut Contribution {
                torque: &mut torque,
                by_parameter: &mut by_parameter,
                by_sign: &mut by_sign,
                by_position: &mut by_position,
                by_velocity: &mut by_velocity,
            },
        );
        any = true;
    }
    let gain = joint.value(GAIN.id, GAIN.parameters[0].name).unwrap_or(1.0);
    let constant = gain * joint.torque_constant.unwrap_or(1.0);
    any.then(|| torque.into_iter().map(|f| f / constant).collect())
}

/// Whether the law is a function of the speed alone.
fn is_of_speed(effect: &Effect) -> bool {
    let of_speed = |on: &Dependence| matches!(on, Dependence::Direction | Dependence::Speed);
    effect.needs.memory == Memory::None
        && matches!(effect.law, Law::Motor(_))
        && !effect.depends_on.is_empty()
        && effect.depends_on.iter().all(of_speed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::machine::{MachineEffect, MachineValue};

    fn with(id: &str, values: &[(&str, f64)]) -> MachineEffect {
        let value = |&(name, value): &(&str, f64)| MachineValue {
            name: name.to_string(),
            value,
        };
        MachineEffect {
            id: id.to_string(),
            parameters: values.iter().map(value).collect(),
        }
    }

    #[test]
    fn matches_coulomb_and_viscous_friction_by_hand() {
        let joint = MachineJoint {
            torque_constant: Some(10.0),
            effects: vec![
                with("coulomb_friction", &[("Fc", 5.0), ("w", 0.5)]),
                with("viscous_friction", &[("Fv", 3.0)]),
                with("rotor_inertia", &[("Jm", 7.0)]),
            ],
            ..MachineJoint::default()
        };
        // (5·2/(2 + 0.5) + 3·2)/10 and its mirror image.
        let found = over_speed(&joint, &[2.0, -2.0, 0.0]).unwrap();
        assert!(
            (found[0] - 1.0).abs() < 1e-15 && (found[1] + 1.0).abs() < 1e-15 && found[2] == 0.0
        );
        assert_eq!(over_speed(&MachineJoint::default(), &[1.0]), None);
    }
}
