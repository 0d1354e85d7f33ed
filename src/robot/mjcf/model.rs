//! What the elements of a file are read with: the document, its classes, compiler settings and meshes.

use crate::robot::mjcf::compiler::Compiler;
use crate::robot::mjcf::document::Document;
use crate::robot::mjcf::mesh::Meshes;
use crate::robot::mjcf::settings::Classes;

/// Everything that elements are read with.
pub(super) struct Model<'a> {
    pub document: &'a Document,
    pub classes: &'a Classes,
    pub compiler: &'a Compiler,
    pub meshes: Meshes,
}
