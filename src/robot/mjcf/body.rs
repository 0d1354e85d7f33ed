//! The walk through `<worldbody>`: a link per body, a joint per hinge or slide, frames dissolved.

use crate::fault::nearest;
use crate::robot::assemble::{RawJoint, RawLink};
use crate::robot::description::{DeclaredDrive, Note, Weight};
use crate::robot::error::RobotError;
use crate::robot::inertia::Inertia;
use crate::robot::mjcf::document::{Document, Id};
use crate::robot::mjcf::inertia::{self, Shape};
use crate::robot::mjcf::joint::{self, MjcfJoint, Motion};
use crate::robot::mjcf::messages::{fail, note};
use crate::robot::mjcf::model::Model;
use crate::robot::mjcf::pose::pose;
use crate::robot::mjcf::settings::Settings;
use crate::robot::mjcf_fault::MjcfFault;
use crate::robot::tree::{JointKind, Limits};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use std::collections::HashMap;

/// Name of the base link, which MuJoCo gives to the world.
const WORLD: &str = "world";

/// Links, joints and what is known of them.
#[derive(Default)]
pub struct Bodies {
    pub links: Vec<RawLink>,
    pub joints: Vec<RawJoint>,
    /// By the name of the joint.
    pub drives: HashMap<String, DeclaredDrive>,
    /// Positions of joints in the configuration that the file draws, rad (m), by name.
    pub references: HashMap<String, f64>,
    /// Names of joints with several degrees of freedom, which stand still.
    pub still: Vec<String>,
    pub notes: Vec<Note>,
}

/// A body that is to be visited, the link that it hangs on and its frame there.
struct Visit<'a> {
    id: Id,
    parent: String,
    class: Option<&'a str>,
    frame: Isometry3<f64>,
}

/// An element of a body, frames around it dissolved.
struct Content<'a> {
    id: Id,
    class: Option<&'a str>,
    frame: Isometry3<f64>,
}

impl Bodies {
    /// Visits all bodies in the order of the file.
    pub fn walk(model: &Model<'_>) -> Result<Self, RobotError> {
        let document = model.document;
        let mut bodies = Self::default();
        let mut worlds = document.within(document.root(), "worldbody").peekable();
        if worlds.peek().is_none() {
            return fail(document.place(document.root()), MjcfFault::NoWorldbody);
        }
        bodies.links.push(RawLink {
            name: WORLD.to_string(),
            at: document.root(),
            inertia: Inertia::default(),
        });
        let mut visits = Vec::new();
        for world in worlds {
            let class = document.attribute(world, "childclass");
            let contents = contents(model, world, class)?;
            if let Some(joint) = contents.iter().find(|c| is_joint(document, c.id)) {
                let fault = MjcfFault::Unsupported {
                    what: "a joint of the world".to_string(),
                    instead: "put it into a body",
                };
                return fail(document.place(joint.id), fault);
            }
            visits.extend(inner(document, &contents, WORLD));
        }
        visits.reverse();
        // An explicit stack: bodies may be nested deeper than the call stack is long.
        while let Some(visit) = visits.pop() {
            let mut within = bodies.visit(model, visit)?;
            within.reverse();
            visits.extend(within);
        }
        bodies.scale(model.compiler.total_mass);
        Ok(bodies)
    }

    /// Adds a body; gives the bodies within it.
    fn visit<'a>(
        &mut self,
        model: &Model<'a>,
        visit: Visit<'a>,
    ) -> Result<Vec<Visit<'a>>, RobotError> {
        let (document, id) = (model.document, visit.id);
        let settings = Settings::alone(document, id);
        settings.only(KNOWN)?;
        let class = document.attribute(id, "childclass").or(visit.class);
        class.map_or(Ok(()), |class| model.classes.known(document, id, class))?;
        let name = match document.attribute(id, "name") {
            Some(name) => name.to_string(),
            None => format!("body{}", self.links.len()),
        };
        let place = visit.frame * pose(&settings, model.compiler)?;
        let contents = contents(model, id, class)?;
        let body = self.inertia(model, &contents)?;
        self.gravity_compensation(&settings)?;
        let mut joints = Vec::new();
        for content in contents.iter().filter(|c| is_joint(document, c.id)) {
            let read = joint::read(model, content.id, content.class, &content.frame)?;
            joints.push(read);
        }
        let stands = At {
            parent: visit.parent,
            place,
        };
        let hanging = Hanging {
            id,
            name: &name,
            inertia: body,
            joints,
        };
        self.hang(model, hanging, stands)?;
        Ok(inner(document, &contents, &name))
    }

    fn inertia(&self, model: &Model<'_>, contents: &[Content<'_>]) -> Result<Inertia, RobotError> {
        let named = |name: &'static str| {
            let of_name = contents.iter();
            of_name.filter(move |c| model.document.name(c.id) == name)
        };
        let mut stated = named("inertial").map(|c| c.id);
        let first = stated.next();
        if let Some(second) = stated.next() {
            return fail(model.document.place(second), MjcfFault::InertialTwice);
        }
        let shapes: Vec<Shape<'_>> = named("geom")
            .map(|c| Shape {
                id: c.id,
                frame: c.frame,
                class: c.class,
            })
            .collect();
        inertia::of(model, first, &shapes)
    }

    fn gravity_compensation(&mut self, body: &Settings<'_>) -> Result<(), RobotError> {
        if body.number("gravcomp")?.is_some_and(|share| share != 0.0) {
            let message = "gravcomp is not in the model: the motors carry the weight".to_string();
            let remedy = "leave it out where the recorded torques hold the robot against gravity";
            let place = body.document().place(body.id());
            self.notes
                .push(note(place, Weight::LeftOut, message, remedy));
        }
        Ok(())
    }

    /// Adds the links and joints of a body that stands at a place in its parent.
    fn hang(
        &mut self,
        model: &Model<'_>,
        hanging: Hanging<'_>,
        mut at: At,
    ) -> Result<(), RobotError> {
        let Hanging {
            id,
            name,
            inertia,
            joints,
        } = hanging;
        let free = joints
            .iter()
            .find(|joint| matches!(joint.motion, Motion::Several { what: "free" }));
        if let Some(free) = free {
            let place = || model.document.place(free.id);
            if joints.len() > 1 {
                return fail(place(), MjcfFault::FreeAmongOthers);
            }
            if at.parent != WORLD {
                return fail(place(), MjcfFault::FreeNotInWorld);
            }
        }
        let count = joints.len();
        for (k, joint) in joints.into_iter().enumerate() {
            let joint_name = joint.name.clone().unwrap_or_else(|| match k {
                0 => format!("{name}_joint"),
                _ => format!("{name}_joint{}", k + 1),
            });
            self.notes.extend(joint.notes.iter().cloned());
            let (kind, axis, anchor) = match joint.motion {
                Motion::Along { kind, axis, anchor } => (kind, axis, anchor),
                Motion::Several { what } => {
                    self.hold(model.document, &joint, &joint_name, what);
                    continue;
                }
            };
            // A link has its frame at the anchor of its joint.
            let away = match kind {
                JointKind::Revolute => anchor,
                JointKind::Prismatic => Vector3::zeros(),
            };
            let drawn = match kind {
                JointKind::Revolute => {
                    let turn = UnitQuaternion::new(axis.normalize() * -joint.reference);
                    Isometry3::from_parts(Translation3::from(away), turn)
                }
                JointKind::Prismatic => {
                    Isometry3::from(Translation3::from(axis.normalize() * -joint.reference))
                }
            };
            let is_last = k + 1 == count && away == Vector3::zeros();
            let link = match is_last {
                true => name.to_string(),
                false => format!("{name}_{joint_name}"),
            };
            self.joints.push(RawJoint {
                name: joint_name.clone(),
                at: joint.id,
                kind: Some(kind),
                parent: at.parent,
                child: link.clone(),
                axis,
                origin: at.place * drawn,
                limits: joint.limits,
            });
            if !is_last {
                self.links.push(RawLink {
                    name: link.clone(),
                    at: joint.id,
                    inertia: Inertia::default(),
                });
            }
            self.references.insert(joint_name.clone(), joint.reference);
            self.drives.insert(joint_name, joint.drive);
            at = At {
                parent: link,
                place: Isometry3::from(Translation3::from(-away)),
            };
        }
        if at.parent != name {
            self.joints.push(RawJoint {
                name: format!("{name}_fixed"),
                at: id,
                kind: None,
                parent: at.parent,
                child: name.to_string(),
                axis: Vector3::z(),
                origin: at.place,
                limits: Limits::default(),
            });
        }
        self.links.push(RawLink {
            name: name.to_string(),
            at: id,
            inertia,
        });
        Ok(())
    }

    /// A joint with several degrees of freedom stands as the file draws it.
    fn hold(&mut self, document: &Document, joint: &MjcfJoint, name: &str, what: &str) {
        self.still.push(name.to_string());
        let message = format!("the joint is {what}; it is taken as fixed where the file draws it");
        let remedy = "record with it at rest there, or write it as hinges";
        let place = document.place(joint.id);
        self.notes
            .push(note(place, Weight::Remark, message, remedy));
    }

    /// All bodies scaled to a total mass.
    fn scale(&mut self, total: Option<f64>) {
        let mass: f64 = self.links.iter().map(|link| link.inertia.mass()).sum();
        let Some(total) = total.filter(|_| mass > 0.0) else {
            return;
        };
        for link in &mut self.links {
            link.inertia = Inertia(link.inertia.0.map(|x| x * total / mass));
        }
    }
}

/// A body with its joints, in the order in which they move it.
struct Hanging<'a> {
    id: Id,
    name: &'a str,
    inertia: Inertia,
    joints: Vec<MjcfJoint>,
}

/// A link and a place in its frame.
struct At {
    parent: String,
    place: Isometry3<f64>,
}

fn is_joint(document: &Document, id: Id) -> bool {
    matches!(document.name(id), "joint" | "freejoint")
}

/// The bodies among the contents of the link `parent`.
fn inner<'a>(document: &Document, contents: &[Content<'a>], parent: &str) -> Vec<Visit<'a>> {
    let bodies = contents.iter().filter(|c| document.name(c.id) == "body");
    let visit = |c: &Content<'a>| Visit {
        id: c.id,
        parent: parent.to_string(),
        class: c.class,
        frame: c.frame,
    };
    bodies.map(visit).collect()
}

/// Elements of a body in the order of the file, those within frames included.
fn contents<'a>(
    model: &Model<'a>,
    id: Id,
    class: Option<&'a str>,
) -> Result<Vec<Content<'a>>, RobotError> {
    let document = model.document;
    let all = |id: Id, class: Option<&'a str>, frame: Isometry3<f64>| {
        let children = document.children(id).iter().rev();
        children.map(move |&id| Content { id, class, frame })
    };
    let mut pending: Vec<Content<'a>> = all(id, class, Isometry3::identity()).collect();
    let mut contents = Vec::new();
    while let Some(content) = pending.pop() {
        match document.name(content.id) {
            "frame" => {
                let settings = Settings::alone(document, content.id);
                let frame = content.frame * pose(&settings, model.compiler)?;
                let own = document.attribute(content.id, "childclass");
                own.map_or(Ok(()), |class| {
                    model.classes.known(document, content.id, class)
                })?;
                pending.extend(all(content.id, own.or(content.class), frame));
            }
            name if READ.contains(&name) => contents.push(content),
            name if PASSED_OVER.contains(&name) => {}
            name => return fail(document.place(content.id), unknown(document.name(id), name)),
        }
    }
    Ok(contents)
}

/// An element that no body has, or that stands for bodies which are made elsewhere.
fn unknown(within: &str, name: &str) -> MjcfFault {
    const EXPANDED: &str = "let MuJoCo write the whole model: \
                            mujoco.MjSpec.from_file(\"model.xml\"), compile it, and save to_xml()";
    let instead = match name {
        "replicate" | "attach" => Some(EXPANDED),
        "composite" | "flexcomp" => Some("leave deformable bodies out"),
        "plugin" => Some("write what the plugin does as joints and bodies, or leave it out"),
        _ => None,
    };
    match instead {
        Some(instead) => MjcfFault::Unsupported {
            what: format!("<{name}>"),
            instead,
        },
        None => MjcfFault::UnknownElement {
            within: within.to_string(),
            nearest: nearest(name, READ.iter().chain(PASSED_OVER).copied()),
        },
    }
}

const READ: &[&str] = &["body", "inertial", "joint", "freejoint", "geom"];

const PASSED_OVER: &[&str] = &["site", "camera", "light"];

const KNOWN: &[&str] = &[
    "axisangle",
    "childclass",
    "euler",
    "fuse",
    "gravcomp",
    "mocap",
    "name",
    "pos",
    "quat",
    "simple",
    "sleep",
    "user",
    "xyaxes",
    "zaxis",
];
