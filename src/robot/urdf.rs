//! Reads URDF: links, joints, limits and inertials; visuals, collisions and plugins are passed over.
//!
//! The parsing library gives every element its position, so that each fault names line and column.

use crate::fault::{Description as Words, Place};
use crate::robot::assemble::{RawJoint, RawLink, RawRobot, assemble};
use crate::robot::dependents::{self, RawDependent};
use crate::robot::description::{Description, Note, Weight};
use crate::robot::error::{LARGEST_NUMBER, RobotError, RobotErrorKind};
use crate::robot::file;
use crate::robot::inertia::{CentralInertia, Inertia};
use crate::robot::tree::{JointKind, Limits, Tree};
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use roxmltree::{Document, Node};
use std::path::Path;

/// Prefix of the elements of macros that a URDF is made with.
const MACRO: &str = "xacro";

/// Reads a URDF file into a tree; fixed joints are merged, their frames kept by name.
pub fn read(path: &Path) -> Result<Tree, RobotError> {
    Ok(describe(path)?.tree)
}

/// Reads the text of a URDF file; `path` is named in errors.
pub fn parse(text: &str, path: &Path) -> Result<Tree, RobotError> {
    Ok(describe_text(text, path)?.tree)
}

/// Reads a URDF file with what it says beside the tree: joints that mimic others, and joints with several degrees of
/// freedom, which the tree has as fixed.
pub fn describe(path: &Path) -> Result<Description, RobotError> {
    describe_text(&file::text(path)?, path)
}

/// Reads the text of a URDF file with what it says beside the tree; `path` is named in errors.
pub fn describe_text(text: &str, path: &Path) -> Result<Description, RobotError> {
    let document = Document::parse(text).map_err(|e| not_xml(text, path, &e))?;
    let reader = Reader { path };
    let root = document.root_element();
    if root.tag_name().name() != "robot" {
        return Err(reader.fault(
            root,
            RobotErrorKind::NotRobot {
                root: root.tag_name().name().to_string(),
            },
        ));
    }
    if let Some(node) = root.descendants().find(|node| is_macro(*node)) {
        let place = reader.locate(&document, node.range().start);
        return Err(RobotError::new(place, RobotErrorKind::Xacro));
    }
    let elements = |name: &'static str| root.children().filter(move |node| node.has_tag_name(name));
    let robot = RawRobot {
        path,
        name: root.attribute("name").unwrap_or("robot").to_string(),
        links: elements("link")
            .map(|node| reader.link(node))
            .collect::<Result<_, _>>()?,
        joints: elements("joint")
            .map(|node| reader.joint(node))
            .collect::<Result<_, _>>()?,
    };
    let tree = assemble(&robot, |at| reader.locate(&document, at))?;
    let mimics = elements("joint")
        .filter_map(|node| reader.mimic(node).transpose())
        .collect::<Result<Vec<_>, _>>()?;
    let fixed = robot.joints.iter().filter(|joint| joint.kind.is_none());
    let still: Vec<String> = fixed.map(|joint| joint.name.clone()).collect();
    let resolved = dependents::resolve(&tree, &still, &mimics)?;
    Ok(Description {
        dependents: resolved.dependents,
        held: resolved.held,
        notes: elements("joint")
            .filter_map(|node| reader.held_still(node))
            .collect(),
        ..Description::of_tree(tree, path.to_path_buf())
    })
}

fn not_xml(text: &str, path: &Path, error: &roxmltree::Error) -> RobotError {
    let (line, column) = match error {
        // The library places an early end at the beginning.
        roxmltree::Error::UnexpectedEndOfStream | roxmltree::Error::UnclosedRootNode => {
            end_of(text)
        }
        _ => (error.pos().row as usize, error.pos().col as usize),
    };
    let place = Place::file(path).line(line).column(column);
    let kind = match error {
        roxmltree::Error::UnknownNamespace(prefix, _) if prefix == MACRO => RobotErrorKind::Xacro,
        _ => RobotErrorKind::NotXml {
            reason: error.to_string(),
        },
    };
    RobotError::new(place, kind)
}

/// Whether an element is a macro, or has an attribute that is one. Expanded files may still declare the prefix.
fn is_macro(node: Node<'_, '_>) -> bool {
    let prefixed = node
        .tag_name()
        .namespace()
        .is_some_and(|uri| uri.contains(MACRO));
    prefixed
        || node
            .attributes()
            .any(|a| a.value().contains("${") || a.value().contains("$("))
}

/// Line and column behind the last character, from 1.
fn end_of(text: &str) -> (usize, usize) {
    let last = text.rsplit('\n').next().unwrap_or_default();
    (text.matches('\n').count() + 1, last.chars().count() + 1)
}

struct Reader<'a> {
    path: &'a Path,
}

impl Reader<'_> {
    fn locate(&self, document: &Document<'_>, offset: usize) -> Place {
        let at = document.text_pos_at(offset);
        Place::file(self.path)
            .line(at.row as usize)
            .column(at.col as usize)
    }

    fn place(&self, node: Node<'_, '_>) -> Place {
        let place = self.locate(node.document(), node.range().start);
        let mut named = node.ancestors().filter(|n| n.is_element());
        match named.find_map(|n| n.attribute("name").filter(|_| !n.has_tag_name("robot"))) {
            Some(name) => place.key(name),
            None => place,
        }
    }

    fn fault(&self, node: Node<'_, '_>, kind: RobotErrorKind) -> RobotError {
        RobotError::new(self.place(node), kind)
    }

    fn attribute<'a>(
        &self,
        node: Node<'a, '_>,
        attribute: &'static str,
    ) -> Result<&'a str, RobotError> {
        node.attribute(attribute).ok_or_else(|| {
            self.fault(
                node,
                RobotErrorKind::MissingAttribute {
                    element: node.tag_name().name().to_string(),
                    attribute,
                },
            )
        })
    }

    fn child<'a, 'd>(
        &self,
        node: Node<'a, 'd>,
        child: &'static str,
    ) -> Result<Node<'a, 'd>, RobotError> {
        find(node, child).ok_or_else(|| {
            self.fault(
                node,
                RobotErrorKind::MissingElement {
                    element: node.tag_name().name().to_string(),
                    child,
                },
            )
        })
    }

    fn number(&self, node: Node<'_, '_>, text: &str) -> Result<f64, RobotError> {
        let value: f64 = text.trim().parse().map_err(|_| {
            self.fault(
                node,
                RobotErrorKind::NotNumber {
                    found: text.to_string(),
                },
            )
        })?;
        if value.is_finite() {
            Ok(value)
        } else {
            Err(self.fault(
                node,
                RobotErrorKind::NotFinite {
                    found: text.to_string(),
                },
            ))
        }
    }

    fn bounded(&self, node: Node<'_, '_>, text: &str) -> Result<f64, RobotError> {
        let value = self.number(node, text)?;
        if value.abs() <= LARGEST_NUMBER {
            return Ok(value);
        }
        let found = text.to_string();
        let limit = LARGEST_NUMBER;
        Err(self.fault(node, RobotErrorKind::TooLargeNumber { found, limit }))
    }

    fn optional(
        &self,
        node: Option<Node<'_, '_>>,
        attribute: &str,
    ) -> Result<Option<f64>, RobotError> {
        let found = node.and_then(|n| n.attribute(attribute).map(|text| (n, text)));
        found.map(|(n, text)| self.number(n, text)).transpose()
    }

    fn triple(&self, node: Node<'_, '_>, text: &str) -> Result<Vector3<f64>, RobotError> {
        let values = text
            .split_whitespace()
            .map(|word| self.bounded(node, word))
            .collect::<Result<Vec<f64>, _>>()?;
        match values[..] {
            [x, y, z] => Ok(Vector3::new(x, y, z)),
            _ => Err(self.fault(
                node,
                RobotErrorKind::WrongCount {
                    found: values.len(),
                    expected: 3,
                },
            )),
        }
    }

    fn origin(&self, parent: Node<'_, '_>) -> Result<Isometry3<f64>, RobotError> {
        let Some(node) = find(parent, "origin") else {
            return Ok(Isometry3::identity());
        };
        let read = |attribute| match node.attribute(attribute) {
            Some(text) => self.triple(node, text),
            None => Ok(Vector3::zeros()),
        };
        let (xyz, rpy) = (read("xyz")?, read("rpy")?);
        let turn = Rotation3::from_euler_angles(rpy.x, rpy.y, rpy.z);
        Ok(Isometry3::from_parts(
            Translation3::from(xyz),
            UnitQuaternion::from_rotation_matrix(&turn),
        ))
    }

    fn link(&self, node: Node<'_, '_>) -> Result<RawLink, RobotError> {
        let name = self.attribute(node, "name")?.to_string();
        let mut inertials = node.children().filter(|n| n.has_tag_name("inertial"));
        let inertia = match inertials.next() {
            Some(first) => self.inertial(first)?,
            None => Inertia::default(),
        };
        if let Some(second) = inertials.next() {
            return Err(self.fault(second, RobotErrorKind::DuplicateInertial));
        }
        Ok(RawLink {
            name,
            at: node.range().start,
            inertia,
        })
    }

    fn inertial(&self, node: Node<'_, '_>) -> Result<Inertia, RobotError> {
        let mass_node = self.child(node, "mass")?;
        let mass = self.bounded(mass_node, self.attribute(mass_node, "value")?)?;
        if mass < 0.0 {
            return Err(self.fault(mass_node, RobotErrorKind::NegativeMass { found: mass }));
        }
        let tensor_node = self.child(node, "inertia")?;
        let entry = |name| {
            self.attribute(tensor_node, name)
                .and_then(|text| self.bounded(tensor_node, text))
        };
        let (xx, xy, xz) = (entry("ixx")?, entry("ixy")?, entry("ixz")?);
        let (yy, yz, zz) = (entry("iyy")?, entry("iyz")?, entry("izz")?);
        let tensor = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let frame = self.origin(node)?;
        let central = Inertia::from_central(&CentralInertia {
            mass,
            centre: Vector3::zeros(),
            tensor,
        });
        Ok(central.seen_from(
            &frame.rotation.to_rotation_matrix(),
            &frame.translation.vector,
        ))
    }

    fn joint(&self, node: Node<'_, '_>) -> Result<RawJoint, RobotError> {
        let kind = match self.attribute(node, "type")? {
            "revolute" | "continuous" => Some(JointKind::Revolute),
            "prismatic" => Some(JointKind::Prismatic),
            "fixed" | "floating" | "planar" => None,
            found => return Err(self.unknown_type(node, found)),
        };
        let axis = match find(node, "axis") {
            Some(axis) => self.triple(axis, self.attribute(axis, "xyz")?)?,
            None => Vector3::x(),
        };
        if kind.is_some() && axis.amax() == 0.0 {
            return Err(self.fault(node, RobotErrorKind::ZeroAxis));
        }
        let (parent, child) = (self.child(node, "parent")?, self.child(node, "child")?);
        Ok(RawJoint {
            name: self.attribute(node, "name")?.to_string(),
            at: node.range().start,
            kind,
            parent: self.attribute(parent, "link")?.to_string(),
            child: self.attribute(child, "link")?.to_string(),
            axis,
            origin: self.origin(node)?,
            limits: self.limits(node)?,
        })
    }

    /// `<mimic joint="..." multiplier="1" offset="0"/>` of a joint that can move.
    fn mimic(&self, node: Node<'_, '_>) -> Result<Option<RawDependent>, RobotError> {
        let moves = ["revolute", "continuous", "prismatic"].map(Some);
        let Some(mimic) = find(node, "mimic").filter(|_| moves.contains(&node.attribute("type")))
        else {
            return Ok(None);
        };
        let number = |attribute, otherwise| {
            mimic
                .attribute(attribute)
                .map_or(Ok(otherwise), |text| self.bounded(mimic, text))
        };
        Ok(Some(RawDependent {
            joint: self.attribute(node, "name")?.to_string(),
            leader: self.attribute(mimic, "joint")?.to_string(),
            multiplier: number("multiplier", 1.0)?,
            offset: number("offset", 0.0)?,
            place: self.place(mimic),
        }))
    }

    /// What is said of a joint with several degrees of freedom, which the tree has as fixed.
    fn held_still(&self, node: Node<'_, '_>) -> Option<Note> {
        let kind = node.attribute("type")?;
        ["floating", "planar"].contains(&kind).then(|| Note {
            place: self.place(node),
            words: Words::new(
                "joint-held-still",
                format!("the joint is {kind}; it is taken as fixed at its origin"),
                "record with it at rest there, or split it into revolute and prismatic joints",
            ),
            weight: Weight::Remark,
        })
    }

    fn unknown_type(&self, node: Node<'_, '_>, found: &str) -> RobotError {
        let known = [
            "revolute",
            "continuous",
            "prismatic",
            "fixed",
            "floating",
            "planar",
        ];
        self.fault(
            node,
            RobotErrorKind::UnknownJointType {
                found: found.to_string(),
                nearest: crate::fault::nearest(found, known.into_iter()),
            },
        )
    }

    fn limits(&self, node: Node<'_, '_>) -> Result<Limits, RobotError> {
        let limit = find(node, "limit");
        // A continuous joint has no position limits, whatever its file says of them.
        let bounded = node.attribute("type") != Some("continuous");
        let position = limit.filter(|_| bounded);
        let limits = Limits {
            lower: self.optional(position, "lower")?,
            upper: self.optional(position, "upper")?,
            velocity: self.optional(limit, "velocity")?,
            effort: self.optional(limit, "effort")?,
        };
        match (limits.lower, limits.upper) {
            (Some(lower), Some(upper)) if lower > upper => {
                Err(self.fault(node, RobotErrorKind::LimitsReversed { lower, upper }))
            }
            _ => Ok(limits),
        }
    }
}

fn find<'a, 'd>(node: Node<'a, 'd>, name: &str) -> Option<Node<'a, 'd>> {
    node.children().find(|child| child.has_tag_name(name))
}

/// The element of a body, with numbers that read back to the same bits.
pub fn inertial(body: &Inertia) -> String {
    let central = body.central().unwrap_or(CentralInertia {
        mass: 0.0,
        centre: Vector3::zeros(),
        tensor: body.tensor(),
    });
    let (mass, centre) = (central.mass, &central.centre);
    let entry = |r: usize, c: usize| central.tensor[(r, c)];
    format!(
        "<inertial>\n      <origin xyz=\"{}\" rpy=\"0 0 0\"/>\n      <mass value=\"{mass:?}\"/>\n      \
         <inertia ixx=\"{:?}\" ixy=\"{:?}\" ixz=\"{:?}\" iyy=\"{:?}\" iyz=\"{:?}\" izz=\"{:?}\"/>\n    \
         </inertial>",
        [centre.x, centre.y, centre.z]
            .map(|x| format!("{x:?}"))
            .join(" "),
        entry(0, 0),
        entry(0, 1),
        entry(0, 2),
        entry(1, 1),
        entry(1, 2),
        entry(2, 2)
    )
}
