//! Names of parameters as users write them: short names of friction, and bodies by mass, centre of mass
//! and inertia about it, which become raw parameters.

use crate::chain::effect::knowledge::JointTerm;
use crate::chain::effect::term_name;
use crate::chain::model::Model;
use crate::chain::parameter::Role;
use crate::fault;
use crate::robot::inertia::{CentralInertia, Inertia, PER_LINK};
use nalgebra::{Matrix3, Vector3};

/// Short names, after the joint, and what they stand for.
const SHORT: &[(&str, JointTerm)] = &[
    ("Fc", JointTerm::DryFriction),
    ("frictionloss", JointTerm::DryFriction),
    ("Fv", JointTerm::ViscousFriction),
    ("damping", JointTerm::ViscousFriction),
    ("Jm", JointTerm::RotorInertia),
    ("armature", JointTerm::RotorInertia),
];

/// A quantity of a body by its reported name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BodyQuantity {
    /// kg.
    Mass,
    /// A component of the centre of mass in the link's frame, 0 to 2, m.
    Centre(usize),
    /// About the centre of mass, axes of the link's frame.
    Inertia(usize, usize),
}

/// Reads `mass`, `com_x`, `inertia_xy`, ...
pub fn body_quantity(name: &str) -> Option<BodyQuantity> {
    let axis = |c: char| "xyz".find(c);
    if name == "mass" {
        return Some(BodyQuantity::Mass);
    }
    if let Some(letter) = name.strip_prefix("com_") {
        let mut letters = letter.chars();
        let found = axis(letters.next()?)?;
        return letters
            .next()
            .is_none()
            .then_some(BodyQuantity::Centre(found));
    }
    let mut letters = name.strip_prefix("inertia_")?.chars();
    let (a, b) = (axis(letters.next()?)?, axis(letters.next()?)?);
    (letters.next().is_none() && a <= b).then_some(BodyQuantity::Inertia(a, b))
}

/// What a name refers to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reference {
    /// A parameter of the model by position.
    Parameter(usize),
    /// A quantity of the body whose raw parameters start here.
    Body(usize, BodyQuantity),
}

/// Finds what a name refers to, in full or short.
pub fn resolve(model: &Model, name: &str) -> Option<Reference> {
    if let Some(parameter) = model.position(name) {
        return Some(Reference::Parameter(parameter));
    }
    let (owner, rest) = name.split_once('.').filter(|(_, rest)| !rest.is_empty())?;
    // Names of links may hold dots themselves: the quantity is behind the last one.
    let (body, quantity) = name.rsplit_once('.')?;
    if let (Some(first), Some(quantity)) = (body_start(model, body), body_quantity(quantity)) {
        return Some(Reference::Body(first, quantity));
    }
    let term = SHORT.iter().find(|(short, _)| *short == rest)?.1;
    model
        .find(&format!("{owner}.{}", term_name(term)))
        .ok()
        .map(Reference::Parameter)
}

/// The most similar name a user can write.
pub fn nearest(model: &Model, name: &str) -> Option<String> {
    let effects = model
        .parameters()
        .iter()
        .filter(|p| !matches!(p.role, Role::Inertial { .. } | Role::Payload { .. }))
        .map(|p| p.name.clone());
    let bodies = model.tree().joints().iter().map(|j| j.link.clone());
    let payload = model.payload().map(|_| "payload".to_string());
    let quantities = bodies.chain(payload).flat_map(|body| {
        [
            "mass",
            "com_x",
            "com_y",
            "com_z",
            "inertia_xx",
            "inertia_yy",
            "inertia_zz",
        ]
        .map(|quantity| format!("{body}.{quantity}"))
    });
    let known: Vec<String> = effects.chain(quantities).collect();
    fault::nearest(name, known.iter().map(String::as_str))
}

fn body_start(model: &Model, body: &str) -> Option<usize> {
    if body == "payload" {
        return model.payload().map(|(_, first)| first);
    }
    let link = model.tree().joints().iter().position(|j| j.link == body)?;
    Some(PER_LINK * link)
}

/// A body with some quantities replaced; the others stay as they are about the centre of mass.
pub fn with_quantities(body: &Inertia, given: &[(BodyQuantity, f64)]) -> Inertia {
    let mut central = body.central().unwrap_or(CentralInertia {
        mass: 0.0,
        centre: Vector3::zeros(),
        tensor: Matrix3::zeros(),
    });
    for &(quantity, value) in given {
        match quantity {
            BodyQuantity::Mass => central.mass = value,
            BodyQuantity::Centre(axis) => central.centre[axis] = value,
            BodyQuantity::Inertia(a, b) => {
                central.tensor[(a, b)] = value;
                central.tensor[(b, a)] = value;
            }
        }
    }
    Inertia::from_central(&central)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_of_bodies_are_read_as_they_are_reported() {
        assert_eq!(body_quantity("mass"), Some(BodyQuantity::Mass));
        assert_eq!(body_quantity("com_y"), Some(BodyQuantity::Centre(1)));
        assert_eq!(
            body_quantity("inertia_xz"),
            Some(BodyQuantity::Inertia(0, 2))
        );
        for wrong in ["inertia_zx", "com_w", "com_xx", "inertia_x", "weight"] {
            assert_eq!(body_quantity(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn a_replaced_quantity_leaves_the_others() {
        let body = Inertia::from_central(&CentralInertia {
            mass: 2.0,
            centre: Vector3::new(0.1, 0.2, 0.3),
            tensor: Matrix3::from_diagonal(&Vector3::new(0.1, 0.2, 0.25)),
        });
        let heavier = with_quantities(&body, &[(BodyQuantity::Mass, 3.0)])
            .central()
            .unwrap();
        assert!((heavier.mass - 3.0).abs() < 1e-15);
        assert!((heavier.centre - Vector3::new(0.1, 0.2, 0.3)).norm() < 1e-15);
        assert!((heavier.tensor[(1, 1)] - 0.2).abs() < 1e-15);
    }
}
