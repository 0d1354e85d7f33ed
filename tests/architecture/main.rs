//! The shape of the source: paths between modules point down the table of layers in `src/lib.rs`, and every file opens
//! with what it is.

mod circles;
mod effects;
mod guide;
mod imports;
mod source;

use std::path::Path;

use imports::Imports;
use source::{bare, names_after, sources};

/// Rows `//! | layer | modules |` of the library's documentation, the highest layer first.
fn layers() -> Vec<(String, Vec<String>)> {
    let lib = include_str!("../../src/lib.rs");
    lib.lines()
        .filter_map(|line| line.strip_prefix("//! | "))
        .filter(|row| !row.starts_with("layer"))
        .map(|row| {
            let mut cells = row.trim_end_matches([' ', '|']).split(" | ");
            let layer = cells.next().unwrap().to_owned();
            let modules = cells.next().unwrap().split(", ");
            let name = |module: &str| module.trim_matches('`').to_owned();
            (layer, modules.map(name).collect())
        })
        .collect()
}

#[test]
fn every_module_has_one_layer() {
    let modules: Vec<String> = layers().into_iter().flat_map(|(_, row)| row).collect();
    let lib = bare(include_str!("../../src/lib.rs"));
    let declared = names_after(&lib, "mod ");
    assert!(!declared.is_empty());
    for (_, line, module) in &declared {
        let rows = modules.iter().filter(|known| known == module).count();
        assert_eq!(rows, 1, "src/lib.rs:{line}: {module} in the table");
    }
    assert_eq!(modules.len(), declared.len(), "modules that do not exist");
}

#[test]
fn paths_between_modules_point_down() {
    let layers = layers();
    let height = |module: &str| {
        let row = layers
            .iter()
            .position(|(_, row)| row.iter().any(|m| m == module));
        row.map(|row| layers.len() - row)
    };
    let mut faults = Vec::new();
    let mut edges = 0;
    for source in sources("src") {
        let Some(module) = source.module() else {
            continue;
        };
        let text = bare(&source.text);
        for (_, line, target) in names_after(&text, "crate::") {
            if target == module {
                continue;
            }
            edges += 1;
            if height(target).is_none() || height(target) >= height(&module) {
                let path = source.path.display();
                faults.push(format!("{path}:{line}: {module} uses crate::{target}"));
            }
        }
    }
    assert!(edges > 0, "no path between modules was found");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn files_open_with_what_they_are() {
    for source in sources("src") {
        // The binary's only text is its function.
        let opens = source.text.starts_with("//! ") || source.path == Path::new("src/main.rs");
        assert!(opens, "{}: no opening line `//! `", source.path.display());
    }
}

/// `clamp` panics where an end is not a number or above the other; `stats::range::within` has an answer.
/// Ends that are numbers, constants or products of them stay what they are.
#[test]
fn ends_of_ranges_that_panic_are_written_out() {
    let is_fixed = |end: &str| {
        let factors = || end.split('*').map(str::trim);
        let is_constant = |name: &str| {
            let mut letters = name.chars();
            letters.all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_')
        };
        factors().all(|factor| factor.parse::<f64>().is_ok() || is_constant(factor))
    };
    for source in sources("src") {
        if source
            .path
            .iter()
            .any(|part| part == "tests" || part == "tests.rs")
        {
            continue;
        }
        let text = bare(&source.text);
        for (at, name) in text.match_indices(".clamp(") {
            let call = &text[at + name.len()..];
            let ends = call.split(')').next().unwrap_or(call);
            let are_fixed = ends.split(',').all(is_fixed);
            assert!(are_fixed, "{}: clamp({ends})", source.path.display());
        }
    }
}

#[test]
fn no_circle_of_files() {
    let imports = Imports::of(&sources("src"));
    assert!(imports.arrows() > 0, "no path between files was found");
    let circles = imports.circles();
    assert!(circles.is_empty(), "{}", circles.join("\n"));
}

#[test]
fn no_circle_of_folders() {
    let circles = Imports::of(&sources("src")).circles_of_folders();
    assert!(circles.is_empty(), "{}", circles.join("\n"));
}
