//! `<joint>`: how it moves, its limits, and what its drive is known to have.

use crate::robot::description::Note;
use crate::robot::description::{DeclaredDrive, DeclaredSpring, Weight};
use crate::robot::error::{RobotError, RobotErrorKind};
use crate::robot::mjcf::document::Id;
use crate::robot::mjcf::messages::note;
use crate::robot::mjcf::model::Model;
use crate::robot::mjcf::settings::Settings;
use crate::robot::mjcf_fault::MjcfFault;
use crate::robot::tree::{JointKind, Limits};
use nalgebra::{Isometry3, Vector3};

/// A joint of a body.
pub struct MjcfJoint {
    pub id: Id,
    pub name: Option<String>,
    pub motion: Motion,
    /// Where the joint stands in the configuration that the file draws, rad (m).
    pub reference: f64,
    pub limits: Limits,
    pub drive: DeclaredDrive,
    pub notes: Vec<Note>,
}

/// How a joint moves, in the frame of its body.
pub enum Motion {
    /// Along or about an axis through the anchor.
    Along {
        kind: JointKind,
        axis: Vector3<f64>,
        anchor: Vector3<f64>,
    },
    /// About all axes, or with no axis held.
    Several { what: &'static str },
}

/// Reads a joint that stands in the frame `frame` of its body.
pub fn read(
    model: &Model<'_>,
    id: Id,
    class: Option<&str>,
    frame: &Isometry3<f64>,
) -> Result<MjcfJoint, RobotError> {
    let name = model.document.attribute(id, "name").map(str::to_string);
    let several = |what| MjcfJoint {
        id,
        name: name.clone(),
        motion: Motion::Several { what },
        reference: 0.0,
        limits: Limits::default(),
        drive: DeclaredDrive::default(),
        notes: Vec::new(),
    };
    if model.document.name(id) == "freejoint" {
        Settings::alone(model.document, id).only(&["name", "group", "align"])?;
        return Ok(several("free"));
    }
    let settings = model.classes.settings(model.document, id, class)?;
    settings.only(KNOWN)?;
    let kind = match settings.word("type", &["hinge", "slide", "ball", "free"])? {
        Some("ball") => return Ok(several("ball")),
        Some("free") => return Ok(several("free")),
        Some("slide") => JointKind::Prismatic,
        _ => JointKind::Revolute,
    };
    let axis = settings.vector("axis")?.unwrap_or(Vector3::z());
    if axis.amax() == 0.0 {
        let place = model.document.place(id);
        return Err(RobotError::new(place, RobotErrorKind::ZeroAxis));
    }
    let anchor = settings.vector("pos")?.unwrap_or_default();
    let angle = match kind {
        JointKind::Revolute => model.compiler.angle,
        JointKind::Prismatic => 1.0,
    };
    let mut joint = MjcfJoint {
        motion: Motion::Along {
            kind,
            axis: frame.rotation * axis,
            anchor: (frame * nalgebra::Point3::from(anchor)).coords,
        },
        reference: angle * settings.number("ref")?.unwrap_or(0.0),
        limits: limits(model, &settings, angle)?,
        ..several("")
    };
    drive(&settings, angle, &mut joint)?;
    Ok(joint)
}

/// Whether a range holds: as stated, else where there is one and the compiler takes that for a statement.
fn is_limited(
    model: &Model<'_>,
    settings: &Settings<'_>,
    name: &str,
    range: Option<[f64; 2]>,
) -> Result<bool, RobotError> {
    let stated = settings.word(name, &["false", "true", "auto"])?;
    Ok(match stated {
        Some("true") => true,
        Some("false") => false,
        _ => model.compiler.autolimits && range.is_some(),
    })
}

fn limits(model: &Model<'_>, settings: &Settings<'_>, angle: f64) -> Result<Limits, RobotError> {
    let range = settings.range("range")?;
    let range = match is_limited(model, settings, "limited", range)? {
        true => range.filter(|[lower, upper]| lower < upper),
        false => None,
    };
    let force = settings.range("actuatorfrcrange")?;
    let force = match is_limited(model, settings, "actuatorfrclimited", force)? {
        true => force,
        false => None,
    };
    Ok(Limits {
        lower: range.map(|[lower, _]| angle * lower),
        upper: range.map(|[_, upper]| angle * upper),
        velocity: None,
        effort: force.map(|[lower, upper]| lower.abs().max(upper.abs())),
    })
}

/// Rotor, friction and spring of the joint. Of polynomials of speed or position the linear term is kept.
fn drive(settings: &Settings<'_>, angle: f64, joint: &mut MjcfJoint) -> Result<(), RobotError> {
    let mut polynomial = |name: &'static str| -> Result<Option<f64>, RobotError> {
        let Some(values) = settings.numbers(name, 1..=3)? else {
            return Ok(None);
        };
        if values[1..].iter().any(|value| *value != 0.0) {
            let message = format!("the terms of {name} beyond the linear one are not in the model");
            let remedy = match name {
                "damping" => "add viscous_nonlinearity to drive.effects",
                _ => "keep the motion where the spring is linear",
            };
            let place = settings.document().place(settings.id());
            joint
                .notes
                .push(note(place, Weight::LeftOut, message, remedy));
        }
        settings.refuse_negative(name, Some(values[0]))
    };
    let (damping, stiffness) = (polynomial("damping")?, polynomial("stiffness")?);
    let timed = settings.numbers("springdamper", 2..=2)?;
    if timed.is_some_and(|values| values.iter().all(|value| *value > 0.0)) {
        return settings.fail(MjcfFault::Unsupported {
            what: "springdamper, from which MuJoCo makes stiffness and damping,".to_string(),
            instead: "write stiffness and damping as MuJoCo prints them (jnt_stiffness, dof_damping)",
        });
    }
    let rest = angle * settings.number("springref")?.unwrap_or(0.0);
    let positive = |value: Option<f64>| value.filter(|value| *value > 0.0);
    joint.drive = DeclaredDrive {
        rotor_inertia: positive(settings.not_negative("armature")?),
        viscous_friction: positive(damping),
        coulomb_friction: positive(settings.not_negative("frictionloss")?),
        spring: positive(stiffness).map(|stiffness| DeclaredSpring { stiffness, rest }),
        servo: None,
    };
    Ok(())
}

const KNOWN: &[&str] = &[
    "actuatorfrclimited",
    "actuatorfrcrange",
    "actuatorgravcomp",
    "armature",
    "axis",
    "class",
    "damping",
    "frictionloss",
    "group",
    "limited",
    "margin",
    "name",
    "pos",
    "range",
    "ref",
    "solimpfriction",
    "solimplimit",
    "solreffriction",
    "solreflimit",
    "springdamper",
    "springref",
    "springyield",
    "stiffness",
    "type",
    "user",
];
