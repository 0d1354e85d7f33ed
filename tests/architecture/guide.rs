//! The ways that the contributor's guide and the folders' first lines show: every file that they name is there.

use crate::source::sources;
use std::fs;
use std::path::{Path, PathBuf};

/// Rows of the tables of a text whose header begins so.
fn rows<'t>(text: &'t str, header: &str) -> Vec<&'t str> {
    let mut found = Vec::new();
    let mut inside = false;
    for line in text.lines() {
        let line = line.trim_start_matches("//!").trim();
        inside = line.starts_with(header) || inside && line.starts_with('|');
        if inside && !line.starts_with(header) && !line.starts_with("|---") {
            found.push(line);
        }
    }
    found
}

/// What stands between backticks.
fn quoted(line: &str) -> impl Iterator<Item = &str> {
    line.split('`').skip(1).step_by(2)
}

/// A file or folder of Rust by its name without its end.
fn is_module(folder: &Path, name: &str) -> bool {
    let path = folder.join(name.trim_end_matches('/'));
    path.is_dir() || path.with_extension("rs").is_file()
}

#[test]
fn files_of_the_guide_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let guide = fs::read_to_string(root.join("CONTRIBUTING.md")).unwrap();
    let rows = rows(&guide, "| question |");
    assert!(rows.len() >= 12, "{} questions", rows.len());
    for row in rows {
        let paths: Vec<&str> = quoted(row).filter(|path| path.contains('/')).collect();
        assert!((1..=3).contains(&paths.len()), "{row}");
        for path in paths {
            assert!(root.join("src").join(path).exists(), "{path}: {row}");
        }
    }
}

#[test]
fn files_on_the_way_through_a_folder_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut steps = 0;
    for source in sources("src") {
        let Some(folder) = source.path.parent().map(PathBuf::from) else {
            continue;
        };
        for row in rows(&source.text, "| step |") {
            steps += 1;
            for name in quoted(row) {
                let folder = root.join(&folder);
                assert!(is_module(&folder, name), "{folder:?}: {name} in {row}");
            }
        }
    }
    assert!(steps > 0, "no folder shows a way");
}
