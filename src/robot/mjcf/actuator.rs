//! `<actuator>`: gear, gains, reflected inertia, damping and limits of the motors of joints.
//!
//! A force f of the actuator is a torque `gear · f` at the joint; its armature and damping are seen there times `gear²`.

use crate::fault::nearest;
use crate::robot::description::DeclaredServo;
use crate::robot::error::RobotError;
use crate::robot::mjcf::body::Bodies;
use crate::robot::mjcf::model::Model;
use crate::robot::mjcf::settings::Settings;
use crate::robot::mjcf_fault::MjcfFault;

/// Elements that set defaults of every actuator.
const ACTUATORS: &[&str] = &[
    "general",
    "motor",
    "position",
    "velocity",
    "intvelocity",
    "damper",
    "cylinder",
    "muscle",
    "pid",
    "dcmotor",
    "plugin",
];

/// Gives the drives and limits of joints what their actuators have. Those of tendons, sites and bodies are passed over.
pub fn apply(model: &Model<'_>, bodies: &mut Bodies) -> Result<(), RobotError> {
    let document = model.document;
    for section in document.within(document.root(), "actuator") {
        for &id in document.children(section) {
            let fits = |name: &str| ACTUATORS.contains(&name);
            let settings = model.classes.settings_where(document, id, None, &fits)?;
            let Some(name) = settings.text("joint").or(settings.text("jointinparent")) else {
                continue;
            };
            if bodies.still.iter().any(|still| still == name) {
                continue;
            }
            let at = bodies
                .joints
                .iter()
                .position(|joint| joint.name == name && joint.kind.is_some());
            let Some(at) = at else {
                let names = bodies.drives.keys().map(String::as_str);
                return settings.fail(MjcfFault::UnknownJoint {
                    found: name.to_string(),
                    nearest: nearest(name, names),
                });
            };
            let servo = servo(&settings, document.name(id))?;
            let limit = force(model, &settings)?.map(|force| force * servo.gear.abs());
            let effort = &mut bodies.joints[at].limits.effort;
            *effort = match (*effort, limit) {
                (Some(a), Some(b)) => Some(a.min(b)),
                (a, b) => a.or(b),
            };
            let drive = bodies.drives.entry(name.to_string()).or_default();
            drive.servo.get_or_insert(servo);
            for (attribute, slot) in [
                ("armature", &mut drive.rotor_inertia),
                ("damping", &mut drive.viscous_friction),
            ] {
                let own = settings
                    .numbers(attribute, 1..=3)?
                    .map_or(0.0, |values| values[0]);
                settings.refuse_negative(attribute, Some(own))?;
                if own > 0.0 {
                    *slot = Some(slot.unwrap_or(0.0) + own * servo.gear * servo.gear);
                }
            }
        }
    }
    Ok(())
}

/// Gear and gains.
fn servo(settings: &Settings<'_>, kind: &str) -> Result<DeclaredServo, RobotError> {
    let gear = settings.numbers("gear", 1..=6)?.map_or(1.0, |gear| gear[0]);
    let number = |name, otherwise: f64| Ok(settings.number(name)?.unwrap_or(otherwise));
    let (kp, kv) = match kind {
        "position" | "pid" => (number("kp", 1.0)?, number("kv", 0.0)?),
        "velocity" => (0.0, number("kv", 1.0)?),
        "intvelocity" => (number("kp", 1.0)?, number("kv", 0.0)?),
        "general" if settings.text("biastype") == Some("affine") => {
            let bias = settings.numbers("biasprm", 1..=10)?.unwrap_or_default();
            let entry = |k: usize| bias.get(k).map_or(0.0, |value| -value);
            (entry(1), entry(2))
        }
        _ => (0.0, 0.0),
    };
    Ok(DeclaredServo { gear, kp, kv })
}

/// Largest force of the actuator.
fn force(model: &Model<'_>, settings: &Settings<'_>) -> Result<Option<f64>, RobotError> {
    let mut ranges = vec![("forcerange", "forcelimited")];
    if model.document.name(settings.id()) == "motor" {
        ranges.push(("ctrlrange", "ctrllimited"));
    }
    let mut least: Option<f64> = None;
    for (name, flag) in ranges {
        let range = settings.range(name)?;
        let holds = match settings.word(flag, &["false", "true", "auto"])? {
            Some("true") => true,
            Some("false") => false,
            _ => model.compiler.autolimits,
        };
        if let Some([lower, upper]) = range.filter(|_| holds) {
            let most = lower.abs().max(upper.abs());
            least = Some(least.map_or(most, |least| least.min(most)));
        }
    }
    Ok(least)
}
