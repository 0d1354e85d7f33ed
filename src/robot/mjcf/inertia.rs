//! The inertia of a body: as `<inertial>` states it or from its geoms, kept above the compiler's bounds.

use crate::robot::error::{RobotError, RobotErrorKind};
use crate::robot::inertia::{CentralInertia, Inertia};
use crate::robot::mjcf::compiler::{Compiler, FromGeoms};
use crate::robot::mjcf::document::Id;
use crate::robot::mjcf::model::Model;
use crate::robot::mjcf::pose::orientation;
use crate::robot::mjcf::settings::Settings;
use crate::robot::mjcf_fault::MjcfFault;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// A geom of a body: its element, its frame within the body, its class.
pub struct Shape<'a> {
    pub id: Id,
    pub frame: nalgebra::Isometry3<f64>,
    pub class: Option<&'a str>,
}

/// The body about the origin of its frame.
pub fn of(
    model: &Model<'_>,
    stated: Option<Id>,
    shapes: &[Shape<'_>],
) -> Result<Inertia, RobotError> {
    let explicit = stated.map(|id| inertial(model, id)).transpose()?;
    let from_shapes = match model.compiler.from_geoms {
        FromGeoms::Never => false,
        FromGeoms::Always => true,
        FromGeoms::Missing => explicit.is_none(),
    };
    let mut sum: Option<Inertia> = None;
    for shape in shapes.iter().filter(|_| from_shapes) {
        if let Some(own) = super::geom::body(model, shape.id, shape.class)? {
            let frame = &shape.frame;
            let seen = own.seen_from(
                &frame.rotation.to_rotation_matrix(),
                &frame.translation.vector,
            );
            sum = Some(sum.map_or(seen, |sum| sum.plus(&seen)));
        }
    }
    let body = sum.or(explicit).unwrap_or_default();
    Ok(bounded(&body, model.compiler))
}

/// `<inertial>`: mass, centre, and the tensor about it.
fn inertial(model: &Model<'_>, id: Id) -> Result<Inertia, RobotError> {
    let settings = Settings::alone(model.document, id);
    settings.only(&[
        "pos",
        "quat",
        "axisangle",
        "euler",
        "xyaxes",
        "zaxis",
        "mass",
        "diaginertia",
        "fullinertia",
    ])?;
    let Some(centre) = settings.vector("pos")? else {
        return settings.fail(MjcfFault::MissingAttribute { attribute: "pos" });
    };
    let Some(mass) = settings.number("mass")? else {
        return settings.fail(MjcfFault::MissingAttribute { attribute: "mass" });
    };
    if mass < 0.0 {
        let kind = RobotErrorKind::NegativeMass { found: mass };
        return Err(RobotError::new(model.document.place(id), kind));
    }
    let turn = orientation(&settings, model.compiler)?;
    let diagonal = settings.vector("diaginertia")?;
    let full = settings.numbers("fullinertia", 6..=6)?;
    let tensor = match (diagonal, full) {
        (Some(_), Some(_)) => return settings.fail(MjcfFault::InertiaTwice),
        (None, None) => return settings.fail(MjcfFault::NoInertia),
        (Some(moments), None) => {
            settings.refuse_negative("diaginertia", Some(moments.min()))?;
            let r = turn.unwrap_or_default().to_rotation_matrix();
            r.matrix() * Matrix3::from_diagonal(&moments) * r.matrix().transpose()
        }
        (None, Some(_)) if turn.is_some() => return settings.fail(MjcfFault::TurnedFullInertia),
        (None, Some(v)) => {
            let tensor = Matrix3::new(v[0], v[3], v[4], v[3], v[1], v[5], v[4], v[5], v[2]);
            let least = SymmetricEigen::new(tensor).eigenvalues.min();
            if least <= 0.0 && model.compiler.least_moment == 0.0 {
                return settings.fail(MjcfFault::NotPositiveInertia { least });
            }
            tensor
        }
    };
    Ok(Inertia::from_central(&CentralInertia {
        mass,
        centre,
        tensor,
    }))
}

/// Mass and principal moments not below the bounds, and moments that no body has replaced by their mean where asked.
fn bounded(body: &Inertia, compiler: &Compiler) -> Inertia {
    let floor = compiler.least_mass > 0.0 || compiler.least_moment > 0.0;
    if !floor && !compiler.balance {
        return *body;
    }
    let central = body.central().unwrap_or(CentralInertia {
        mass: 0.0,
        centre: Vector3::zeros(),
        tensor: body.tensor(),
    });
    let eigen = SymmetricEigen::new(central.tensor);
    let mut moments = eigen.eigenvalues.map(|m| m.max(compiler.least_moment));
    if compiler.balance && 2.0 * moments.max() > moments.sum() {
        moments = Vector3::repeat(moments.sum() / 3.0);
    }
    let axes = eigen.eigenvectors;
    Inertia::from_central(&CentralInertia {
        mass: central.mass.max(compiler.least_mass),
        centre: central.centre,
        tensor: axes * Matrix3::from_diagonal(&moments) * axes.transpose(),
    })
}
