//! What can be wrong with an MJCF file beyond what can be wrong with any robot file.

use crate::fault::Description;

/// A fault of an MJCF file.
#[derive(Debug, Clone, PartialEq)]
pub enum MjcfFault {
    NotMujoco {
        root: String,
    },
    NoWorldbody,
    TooManyElements {
        limit: usize,
    },
    IncludedTwice {
        file: String,
    },
    NotIncluded {
        file: String,
        reason: String,
    },
    UnknownClass {
        found: String,
        nearest: Option<String>,
    },
    ClassTwice {
        name: String,
    },
    ClassWithoutName,
    UnknownElement {
        within: String,
        nearest: Option<String>,
    },
    UnknownAttribute {
        found: String,
        nearest: Option<String>,
    },
    MissingAttribute {
        attribute: &'static str,
    },
    /// An element that the tree has no place for, and what to do instead.
    Unsupported {
        what: String,
        instead: &'static str,
    },
    NotAWord {
        attribute: String,
        found: String,
        allowed: &'static [&'static str],
    },
    WrongCount {
        attribute: String,
        found: usize,
        expected: String,
    },
    Negative {
        attribute: String,
        found: f64,
    },
    /// Two orientations of one element.
    Orientations {
        attributes: [&'static str; 2],
    },
    NoDirection {
        attribute: String,
    },
    Eulerseq {
        found: String,
    },
    GlobalCoordinates,
    NoInertia,
    InertiaTwice,
    TurnedFullInertia,
    NotPositiveInertia {
        least: f64,
    },
    InertialTwice,
    FreeAmongOthers,
    FreeNotInWorld,
    UnknownMesh {
        found: String,
        nearest: Option<String>,
    },
    MeshTwice {
        name: String,
    },
    MeshFile {
        file: String,
        reason: String,
    },
    MeshNotClosed {
        mesh: String,
    },
    MeshNotConvex {
        mesh: String,
    },
    NoVolume {
        mesh: String,
    },
    Size {
        shape: &'static str,
        expected: usize,
        found: usize,
    },
    UnknownJoint {
        found: String,
        nearest: Option<String>,
    },
}

fn suggestion(nearest: &Option<String>, otherwise: &str) -> String {
    match nearest {
        Some(name) => format!("did you mean `{name}`?"),
        None => otherwise.to_string(),
    }
}

impl MjcfFault {
    /// The fault in words.
    pub(crate) fn describe(&self) -> Description {
        match self {
            Self::NotMujoco { root } if root == "robot" => Description::new(
                "mjcf-not-mujoco",
                "the root element is <robot>, not <mujoco>: the file is URDF",
                "name it as robot.urdf instead of robot.mjcf",
            ),
            Self::NotMujoco { root } => Description::new(
                "mjcf-not-mujoco",
                format!("the root element is <{root}>, not <mujoco>"),
                "give an MJCF file",
            ),
            Self::NoWorldbody => Description::new(
                "mjcf-no-worldbody",
                "the model has no <worldbody>",
                "put the bodies of the robot into <worldbody>",
            ),
            Self::TooManyElements { limit } => Description::new(
                "mjcf-too-many-elements",
                format!("the model has more than {limit} elements"),
                "leave out what is not the robot",
            ),
            Self::IncludedTwice { file } => Description::new(
                "mjcf-included-twice",
                format!("{file} is included for the second time"),
                "include every file once",
            ),
            Self::NotIncluded { file, reason } => Description::new(
                "mjcf-not-included",
                format!("{file} cannot be included: {reason}"),
                "correct the path, which is relative to the main file, or the file",
            ),
            Self::Unsupported { what, instead } => {
                Description::new("mjcf-unsupported", format!("{what} is not read"), *instead)
            }
            fault => fault.of_attribute(),
        }
    }

    fn of_attribute(&self) -> Description {
        match self {
            Self::UnknownClass { found, nearest } => Description::new(
                "mjcf-unknown-class",
                format!("there is no default class `{found}`"),
                suggestion(nearest, "define it in <default>, or correct the name"),
            ),
            Self::ClassTwice { name } => Description::new(
                "mjcf-class-twice",
                format!("the default class `{name}` is defined already"),
                "give every class its own name",
            ),
            Self::ClassWithoutName => Description::new(
                "mjcf-class-without-name",
                "a default class within another has no name",
                "add class=\"...\"",
            ),
            Self::UnknownElement { within, nearest } => Description::new(
                "mjcf-unknown-element",
                format!("<{within}> has no such element"),
                suggestion(nearest, "remove it, or correct its name"),
            ),
            Self::UnknownAttribute { found, nearest } => Description::new(
                "mjcf-unknown-attribute",
                format!("the element has no attribute `{found}`"),
                suggestion(nearest, "remove it, or correct its name"),
            ),
            Self::MissingAttribute { attribute } => Description::new(
                "mjcf-missing-attribute",
                format!("the attribute `{attribute}` is missing"),
                format!("add {attribute}=\"...\""),
            ),
            Self::NotAWord {
                attribute,
                found,
                allowed,
            } => Description::new(
                "mjcf-not-a-word",
                format!("{attribute} is `{found}`"),
                format!("write one of {}", allowed.join(", ")),
            ),
            Self::WrongCount {
                attribute,
                found,
                expected,
            } => Description::new(
                "mjcf-wrong-count",
                format!("{attribute} has {found} numbers"),
                format!("write {expected} numbers separated by spaces"),
            ),
            Self::Negative { attribute, found } => Description::new(
                "mjcf-negative",
                format!("{attribute} is {found}"),
                "give a number that is not negative",
            ),
            fault => fault.of_geometry(),
        }
    }

    fn of_geometry(&self) -> Description {
        match self {
            Self::Orientations {
                attributes: [first, second],
            } => Description::new(
                "mjcf-two-orientations",
                format!("the orientation is given by {first} and by {second}"),
                "keep one of them",
            ),
            Self::NoDirection { attribute } => Description::new(
                "mjcf-no-direction",
                format!("{attribute} has no length"),
                "give a direction",
            ),
            Self::Eulerseq { found } => Description::new(
                "mjcf-eulerseq",
                format!("eulerseq is `{found}`"),
                "write three of x, y, z (axes that turn along) or X, Y, Z (axes that stand), for example xyz",
            ),
            Self::GlobalCoordinates => Description::new(
                "mjcf-global-coordinates",
                "coordinate is `global`, which MuJoCo does not know any more",
                "convert the file with an older MuJoCo, which saves local coordinates",
            ),
            Self::FreeAmongOthers => Description::new(
                "mjcf-free-among-others",
                "a body with a free joint has other joints",
                "keep the free joint, or the others",
            ),
            Self::FreeNotInWorld => Description::new(
                "mjcf-free-not-in-world",
                "a free joint belongs to a body that hangs on another body",
                "put the body right under <worldbody>, or remove the free joint",
            ),
            Self::UnknownJoint { found, nearest } => Description::new(
                "mjcf-unknown-joint",
                format!("there is no joint `{found}`"),
                suggestion(nearest, "name a joint of the model"),
            ),
            fault => fault.of_inertia(),
        }
    }

    fn of_inertia(&self) -> Description {
        match self {
            Self::NoInertia => Description::new(
                "mjcf-no-inertia",
                "<inertial> has no moments of inertia",
                "add diaginertia=\"...\" or fullinertia=\"...\"",
            ),
            Self::InertiaTwice => Description::new(
                "mjcf-inertia-twice",
                "<inertial> has diaginertia and fullinertia",
                "keep one of them",
            ),
            Self::TurnedFullInertia => Description::new(
                "mjcf-turned-full-inertia",
                "<inertial> has fullinertia and an orientation",
                "remove the orientation: fullinertia is in the axes of the body",
            ),
            Self::NotPositiveInertia { least } => Description::new(
                "mjcf-not-positive-inertia",
                format!("the least principal moment of fullinertia is {least:.3e} kg·m²"),
                "correct the tensor, which no body has",
            ),
            Self::InertialTwice => Description::new(
                "mjcf-inertial-twice",
                "the body has two <inertial> elements",
                "keep one of them",
            ),
            Self::UnknownMesh { found, nearest } => Description::new(
                "mjcf-unknown-mesh",
                format!("there is no mesh `{found}`"),
                suggestion(
                    nearest,
                    "define it in <asset>, or give the body its <inertial>",
                ),
            ),
            Self::MeshTwice { name } => Description::new(
                "mjcf-mesh-twice",
                format!("there is a mesh `{name}` already"),
                "give every mesh its own name",
            ),
            Self::MeshFile { file, reason } => Description::new(
                "mjcf-mesh-file",
                format!(
                    "the mesh {file}, which the inertia of a body is made of, cannot be read: {reason}"
                ),
                "correct the file or its path, or give the body its <inertial>",
            ),
            Self::MeshNotClosed { mesh } => Description::new(
                "mjcf-mesh-not-closed",
                format!("the mesh `{mesh}` has no inside: its faces do not all look outwards"),
                "repair the mesh, or give the body its <inertial>",
            ),
            Self::MeshNotConvex { mesh } => Description::new(
                "mjcf-mesh-not-convex",
                format!(
                    "the mesh `{mesh}` is not convex, or too large to tell, and its inertia is to be that of its hull"
                ),
                "use inertia=\"exact\", or give the body its <inertial>",
            ),
            Self::NoVolume { mesh } => Description::new(
                "mjcf-no-volume",
                format!("the mesh `{mesh}` encloses no volume"),
                "repair the mesh, use inertia=\"shell\", or give the body its <inertial>",
            ),
            Self::Size {
                shape,
                expected,
                found,
            } => Description::new(
                "mjcf-size",
                format!("the {shape} has {found} positive sizes"),
                format!("give the first {expected} of size=\"...\", all positive"),
            ),
            other => Description::new("mjcf", format!("{other:?}"), "correct the file"),
        }
    }
}
