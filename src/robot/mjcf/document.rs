//! An MJCF file with all that it includes: elements with their attributes, children and places.

use crate::fault::{Fault, Place};
use crate::robot::error::{RobotError, RobotErrorKind};
use crate::robot::file;
use crate::robot::mjcf::messages::fail;
use crate::robot::mjcf_fault::MjcfFault;
use roxmltree::Node;
use std::path::{Path, PathBuf};

/// Position of an element in the document.
pub type Id = usize;

/// Most elements of a model: the largest in public use have a hundredth of it.
const MOST_ELEMENTS: usize = 2_000_000;

/// Most files of a model.
const MOST_FILES: usize = 500;

#[derive(Debug)]
struct Element {
    name: String,
    attributes: Vec<(String, String)>,
    children: Vec<Id>,
    file: usize,
    line: usize,
    column: usize,
}

/// The elements of all files, the root first; `<include>` is replaced by what the file named there holds.
#[derive(Debug)]
pub struct Document {
    elements: Vec<Element>,
    files: Vec<PathBuf>,
}

/// Offsets at which lines begin, bytes.
struct Lines(Vec<usize>);

impl Lines {
    fn of(text: &str) -> Self {
        let ends = text.match_indices('\n').map(|(at, _)| at + 1);
        Self(std::iter::once(0).chain(ends).collect())
    }

    /// Line and column of an offset, from 1; columns in bytes.
    fn at(&self, offset: usize) -> (usize, usize) {
        let line = self.0.partition_point(|start| *start <= offset);
        (line, offset - self.0[line - 1] + 1)
    }
}

/// A node whose copy belongs to `parent`.
struct Pending<'a, 'd> {
    node: Node<'a, 'd>,
    parent: Option<Id>,
}

impl Document {
    /// Reads a file and those that it includes.
    pub fn read(path: &Path) -> Result<Self, RobotError> {
        let mut document = Self {
            elements: Vec::new(),
            files: Vec::new(),
        };
        let text = file::text(path)?;
        document.append(&text, path, None)?;
        let root = &document.elements[0];
        if root.name != "mujoco" {
            let fault = MjcfFault::NotMujoco {
                root: root.name.clone(),
            };
            return fail(document.place(0), fault);
        }
        Ok(document)
    }

    /// Adds the elements of a text: the root itself, or what it holds where it is included into `parent`.
    fn append(&mut self, text: &str, path: &Path, parent: Option<Id>) -> Result<(), RobotError> {
        let parsed = roxmltree::Document::parse(text).map_err(|e| {
            let place = Place::file(path)
                .line(e.pos().row as usize)
                .column(e.pos().col as usize);
            let reason = e.to_string();
            RobotError::new(place, RobotErrorKind::NotXml { reason })
        })?;
        let (lines, file) = (Lines::of(text), self.files.len());
        self.files.push(path.to_path_buf());
        let root = parsed.root_element();
        let mut pending = match parent {
            None => vec![Pending { node: root, parent }],
            Some(_) => inner(root, parent),
        };
        // An explicit stack: elements may be nested deeper than the call stack is long.
        while let Some(Pending { node, parent }) = pending.pop() {
            let (line, column) = lines.at(node.range().start);
            let place = || Place::file(path).line(line).column(column);
            if self.elements.len() >= MOST_ELEMENTS {
                let limit = MOST_ELEMENTS;
                return fail(place(), MjcfFault::TooManyElements { limit });
            }
            if node.has_tag_name("include") {
                let Some(named) = node.attribute("file") else {
                    return fail(place(), MjcfFault::MissingAttribute { attribute: "file" });
                };
                self.include(named, &place(), parent)?;
                continue;
            }
            let id = self.elements.len();
            let attributes = node.attributes();
            self.elements.push(Element {
                name: node.tag_name().name().to_string(),
                attributes: attributes
                    .map(|a| (a.name().to_string(), a.value().to_string()))
                    .collect(),
                children: Vec::new(),
                file,
                line,
                column,
            });
            if let Some(parent) = parent {
                self.elements[parent].children.push(id);
            }
            pending.extend(inner(node, Some(id)));
        }
        Ok(())
    }

    fn include(
        &mut self,
        named: &str,
        place: &Place,
        parent: Option<Id>,
    ) -> Result<(), RobotError> {
        let file = named.to_string();
        // Paths are relative to the main file.
        let folder = self.files[0].parent().unwrap_or(Path::new(""));
        let path = folder.join(named);
        if self.files.contains(&path) || self.files.len() >= MOST_FILES {
            return fail(place.clone(), MjcfFault::IncludedTwice { file });
        }
        let text = match file::text(&path) {
            Ok(text) => text,
            Err(error) => {
                let reason = error.describe().message;
                return fail(place.clone(), MjcfFault::NotIncluded { file, reason });
            }
        };
        self.append(&text, &path, parent)
    }

    pub fn root(&self) -> Id {
        0
    }

    /// Every file that was read, the main one first.
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    pub fn name(&self, id: Id) -> &str {
        &self.elements[id].name
    }

    pub fn children(&self, id: Id) -> &[Id] {
        &self.elements[id].children
    }

    /// The children of one name.
    pub fn within<'a>(&'a self, id: Id, name: &'a str) -> impl Iterator<Item = Id> + 'a {
        let children = self.children(id).iter().copied();
        children.filter(move |child| self.name(*child) == name)
    }

    pub fn attribute(&self, id: Id, name: &str) -> Option<&str> {
        let found = self.elements[id].attributes.iter().find(|(n, _)| n == name);
        found.map(|(_, value)| value.as_str())
    }

    /// Names of the attributes of an element.
    pub fn attributes(&self, id: Id) -> impl Iterator<Item = &str> {
        self.elements[id].attributes.iter().map(|(n, _)| n.as_str())
    }

    /// File, line and column of an element, with its name where it has one.
    pub fn place(&self, id: Id) -> Place {
        let element = &self.elements[id];
        let place = Place::file(&self.files[element.file])
            .line(element.line)
            .column(element.column);
        place.key(match self.attribute(id, "name") {
            Some(name) => format!("{} {name}", element.name),
            None => element.name.clone(),
        })
    }
}

/// The elements within a node, the first last.
fn inner<'a, 'd>(node: Node<'a, 'd>, parent: Option<Id>) -> Vec<Pending<'a, 'd>> {
    let elements = node.children().filter(Node::is_element);
    let mut list: Vec<_> = elements.map(|node| Pending { node, parent }).collect();
    list.reverse();
    list
}
