//! Bodies of uniform density from their shapes.
//!
//! ```text
//! sphere     V = 4/3 π r³      Ixx = 2/5 m r²
//! ellipsoid  V = 4/3 π a b c   Ixx = m (b² + c²)/5
//! box        V = 8 a b c       Ixx = m (b² + c²)/3
//! cylinder   V = 2 π r² h      Ixx = m (3 r² + 4 h²)/12,  Izz = m r²/2
//! capsule    a cylinder and two half spheres at ±h along z
//! ```
//!
//! with half sizes a, b, c, radius r and half length h.

use crate::robot::error::{RobotError, RobotErrorKind};
use crate::robot::inertia::{CentralInertia, Inertia};
use crate::robot::mjcf::document::Id;
use crate::robot::mjcf::model::Model;
use crate::robot::mjcf::pose::{least_turn, pose};
use crate::robot::mjcf::settings::Settings;
use crate::robot::mjcf_fault::MjcfFault;
use nalgebra::{Isometry3, Matrix3, Translation3, Unit, Vector3};
use std::f64::consts::PI;

/// kg/m³ of a geom that states neither mass nor density.
const WATER: f64 = 1000.0;

/// Geoms that weigh less have no part in the inertia, kg.
const LEAST_MASS: f64 = 1e-15;

const TYPES: &[&str] = &[
    "sphere",
    "plane",
    "hfield",
    "capsule",
    "ellipsoid",
    "cylinder",
    "box",
    "mesh",
    "sdf",
];

/// The body of a geom within the frame around it; `None` for one that weighs nothing or whose group has no part in
/// inertias.
pub fn body(model: &Model<'_>, id: Id, class: Option<&str>) -> Result<Option<Inertia>, RobotError> {
    let settings = model.classes.settings(model.document, id, class)?;
    let group = settings.number("group")?.unwrap_or(0.0);
    let [first, last] = model.compiler.groups;
    if group < first || group > last {
        return Ok(None);
    }
    let kind = settings.word("type", TYPES)?.unwrap_or("sphere");
    let mass = settings.number("mass")?;
    if mass.is_some_and(|found| found < 0.0) {
        let found = mass.unwrap_or_default();
        let place = model.document.place(id);
        return Err(RobotError::new(
            place,
            RobotErrorKind::NegativeMass { found },
        ));
    }
    let density = settings.not_negative("density")?.unwrap_or(WATER);
    let weightless = mass.map_or(density == 0.0, |mass| mass <= LEAST_MASS);
    if weightless || ["plane", "hfield"].contains(&kind) {
        return Ok(None);
    }
    let shell = settings.is_true("shellinertia")? == Some(true);
    let unsupported = |what: &str, instead| {
        let what = what.to_string();
        settings.fail(MjcfFault::Unsupported { what, instead })
    };
    const INERTIAL: &str = "give the body its <inertial>";
    let named = settings.text("mesh");
    let mut at = pose(&settings, model.compiler)?;
    let unit = match (kind, named) {
        ("mesh", Some(name)) => model.mesh_body(id, name)?,
        ("mesh", None) => return settings.fail(MjcfFault::MissingAttribute { attribute: "mesh" }),
        ("sdf", _) => return unsupported("the inertia of a signed distance function", INERTIAL),
        (_, Some(_)) => return unsupported("the inertia of a shape fitted to a mesh", INERTIAL),
        _ if shell => return unsupported("the inertia of a shell", INERTIAL),
        (shape, None) => {
            let extent = extent(&settings, shape)?;
            at = extent.between.unwrap_or(at);
            primitive(shape, extent.sizes)
        }
    };
    let factor = mass.map_or(density, |mass| mass / unit.mass());
    let body = Inertia(unit.0.map(|x| factor * x));
    Ok((body.mass() > LEAST_MASS)
        .then(|| body.seen_from(&at.rotation.to_rotation_matrix(), &at.translation.vector)))
}

/// Half sizes, radius and half length of a shape, and where it stands if that is given by two ends.
struct Extent {
    sizes: [f64; 3],
    between: Option<Isometry3<f64>>,
}

fn extent(settings: &Settings<'_>, shape: &'static str) -> Result<Extent, RobotError> {
    let expected = match shape {
        "sphere" => 1,
        "capsule" | "cylinder" => 2,
        _ => 3,
    };
    let given = settings.numbers("size", 1..=3)?.unwrap_or_default();
    let ends = match shape {
        "sphere" => None,
        _ => settings.numbers("fromto", 6..=6)?,
    };
    let mut sizes = [0.0; 3];
    for (slot, value) in sizes.iter_mut().zip(&given) {
        *slot = *value;
    }
    let mut between = None;
    let needed = if ends.is_some() { 1 } else { expected };
    if sizes[..needed].iter().any(|size| *size <= 0.0) {
        let positive = given.iter().take_while(|size| **size > 0.0).count();
        return settings.fail(MjcfFault::Size {
            shape,
            expected: needed,
            found: positive,
        });
    }
    if let Some(v) = ends {
        let (a, b) = (
            Vector3::new(v[0], v[1], v[2]),
            Vector3::new(v[3], v[4], v[5]),
        );
        let Some(axis) = Unit::try_new(b - a, 0.0) else {
            let attribute = "fromto".to_string();
            return settings.fail(MjcfFault::NoDirection { attribute });
        };
        let half = 0.5 * (b - a).norm();
        match expected {
            2 => sizes[1] = half,
            _ => sizes = [sizes[0], sizes[0], half],
        }
        let middle = Translation3::from(0.5 * (a + b));
        between = Some(Isometry3::from_parts(middle, least_turn(&axis)));
    }
    Ok(Extent { sizes, between })
}

/// The body of density 1 of a shape.
fn primitive(shape: &str, [a, b, c]: [f64; 3]) -> Inertia {
    let central = |mass: f64, [x, y, z]: [f64; 3]| CentralInertia {
        mass,
        centre: Vector3::zeros(),
        tensor: Matrix3::from_diagonal(&Vector3::new(x, y, z)),
    };
    let about = |mass: f64, share: f64, [a, b, c]: [f64; 3]| {
        let moment = |p: f64, q: f64| mass * (p * p + q * q) / share;
        central(mass, [moment(b, c), moment(a, c), moment(a, b)])
    };
    let body = match shape {
        "sphere" => about(4.0 / 3.0 * PI * a.powi(3), 5.0, [a, a, a]),
        "ellipsoid" => about(4.0 / 3.0 * PI * a * b * c, 5.0, [a, b, c]),
        "box" => about(8.0 * a * b * c, 3.0, [a, b, c]),
        _ => {
            let (r, h) = (a, b);
            let cylinder = 2.0 * PI * r * r * h;
            let across = cylinder * (3.0 * r * r + 4.0 * h * h) / 12.0;
            let along = 0.5 * cylinder * r * r;
            if shape == "cylinder" {
                central(cylinder, [across, across, along])
            } else {
                let ends = 4.0 / 3.0 * PI * r.powi(3);
                let own = 0.4 * ends * r * r;
                // Half spheres: their centres of mass lie 3 r / 8 beyond ±h.
                let across = across + own + ends * (h * h + 0.75 * r * h);
                central(cylinder + ends, [across, across, along + own])
            }
        }
    };
    Inertia::from_central(&body)
}
