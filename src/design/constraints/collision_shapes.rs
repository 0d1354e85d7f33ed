//! Collision shapes of a link as capsules: what a clearance is kept from.
//!
//! Every capsule encloses its shape: a cylinder keeps its radius and gets round ends, a box gets the
//! radius of its section's corners along its longest side.

use nalgebra::{Isometry3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use roxmltree::{Document, Node};

use crate::design::constraints::workspace::Capsule;
use crate::design::error::{DesignError, Unsuitable};
use crate::fault::Place;
use crate::problem_file::design::Shape;
use crate::setup::error::{Mismatch, SetupError};
use crate::setup::robot::Robot;

/// The capsules of a link or of the base, by its name in the URDF: those `given` for it, else those of its
/// collision geometry.
///
/// # Errors
/// A link that the robot does not have, or one without a shape that a capsule encloses.
pub fn of_link(
    robot: &Robot,
    name: &str,
    place: &Place,
    given: &[Shape],
) -> Result<Vec<Capsule>, DesignError> {
    let Some((link, frame)) = robot.tree.frame(name) else {
        let kind = Mismatch::UnknownFrame {
            found: name.to_string(),
            known: robot.frame_names(),
        };
        return Err(SetupError::mismatch(place, kind).into());
    };
    let own = given.iter().filter(|shape| shape.link.value == name);
    let stated: Vec<Capsule> = own.map(|shape| as_given(shape, link, &frame)).collect();
    if !stated.is_empty() {
        return Ok(stated);
    }
    // The file was read as a robot before: what cannot be read as one now has no shapes either.
    let text = std::fs::read_to_string(&robot.file).unwrap_or_default();
    let document = Document::parse(&text).ok();
    let shapes: Vec<Capsule> = document
        .iter()
        .flat_map(|d| d.descendants())
        .filter(|n| n.has_tag_name("link") && n.attribute("name") == Some(name))
        .flat_map(|n| n.children())
        .filter(|n| n.has_tag_name("collision"))
        .filter_map(|n| capsule(n, link, &frame))
        .collect();
    if shapes.is_empty() {
        let kind = Unsuitable::NoShape {
            link: name.to_string(),
        };
        return Err(DesignError::unsuitable(place, kind));
    }
    Ok(shapes)
}

fn as_given(shape: &Shape, link: Option<usize>, frame: &Isometry3<f64>) -> Capsule {
    let ends = &shape.ends.value;
    let end = |k: usize| frame * Point3::from(ends[k]);
    Capsule {
        link,
        ends: [end(0), end(ends.len() - 1)],
        radius: shape.radius.value,
    }
}

fn child<'a, 'd>(node: Node<'a, 'd>, name: &str) -> Option<Node<'a, 'd>> {
    node.children().find(|n| n.has_tag_name(name))
}

fn triple(text: &str) -> Option<Vector3<f64>> {
    let values: Option<Vec<f64>> = text.split_whitespace().map(|w| w.parse().ok()).collect();
    match values?[..] {
        [x, y, z] => Some(Vector3::new(x, y, z)),
        _ => None,
    }
}

fn origin(node: Node<'_, '_>) -> Option<Isometry3<f64>> {
    let Some(origin) = child(node, "origin") else {
        return Some(Isometry3::identity());
    };
    let read = |name| {
        origin
            .attribute(name)
            .map_or(Some(Vector3::zeros()), triple)
    };
    let (xyz, rpy) = (read("xyz")?, read("rpy")?);
    let turn = Rotation3::from_euler_angles(rpy.x, rpy.y, rpy.z);
    Some(Isometry3::from_parts(
        Translation3::from(xyz),
        UnitQuaternion::from_rotation_matrix(&turn),
    ))
}

/// The capsule of a `<collision>` element in the frame of the moving link.
fn capsule(node: Node<'_, '_>, link: Option<usize>, frame: &Isometry3<f64>) -> Option<Capsule> {
    let placement = frame * origin(node)?;
    let shape = child(node, "geometry")?.children().find(Node::is_element)?;
    let number = |name: &str| -> Option<f64> { shape.attribute(name)?.trim().parse().ok() };
    let (half, radius) = match shape.tag_name().name() {
        "sphere" => (Vector3::zeros(), number("radius")?),
        "cylinder" | "capsule" => (Vector3::z() * 0.5 * number("length")?, number("radius")?),
        "box" => {
            let size = triple(shape.attribute("size")?)?;
            let axis = size.imax();
            let mut section = size;
            section[axis] = 0.0;
            let mut half = Vector3::zeros();
            half[axis] = 0.5 * size[axis];
            (half, 0.5 * section.norm())
        }
        _ => return None,
    };
    Some(Capsule {
        link,
        ends: [half, -half].map(|end| placement * Point3::from(end)),
        radius,
    })
}
