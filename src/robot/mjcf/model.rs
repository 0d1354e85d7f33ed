//! What the elements of a file are read with: the document, its classes, compiler settings and meshes.

use crate::robot::error::RobotError;
use crate::robot::mjcf::compiler::Compiler;
use crate::robot::mjcf::document::{Document, Id};
use crate::robot::mjcf::messages::fail;
use crate::robot::mjcf::settings::Classes;
use crate::robot::mjcf_fault::MjcfFault;
use std::collections::HashMap;
use std::path::Path;

/// Everything that elements are read with.
pub(super) struct Model<'a> {
    pub document: &'a Document,
    pub classes: &'a Classes,
    pub compiler: &'a Compiler,
    pub meshes: Meshes,
}

/// The meshes of a model by name.
#[derive(Debug)]
pub(super) struct Meshes {
    pub assets: HashMap<String, Id>,
}

impl Meshes {
    /// Finds the meshes; their files are read where an inertia needs them.
    pub fn of(document: &Document, classes: &Classes) -> Result<Self, RobotError> {
        let mut assets = HashMap::new();
        for section in document.within(document.root(), "asset") {
            for id in document.within(section, "mesh") {
                classes.settings(document, id, None)?;
                let file = document.attribute(id, "file");
                let stem = file.and_then(|f| Path::new(f).file_stem()?.to_str());
                let Some(name) = document.attribute(id, "name").or(stem) else {
                    let fault = MjcfFault::MissingAttribute { attribute: "name" };
                    return fail(document.place(id), fault);
                };
                if assets.insert(name.to_string(), id).is_some() {
                    let name = name.to_string();
                    return fail(document.place(id), MjcfFault::MeshTwice { name });
                }
            }
        }
        Ok(Self { assets })
    }
}
