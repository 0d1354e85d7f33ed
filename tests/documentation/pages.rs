//! The pages of the repository, and whether they are written anew or compared.

use std::fs;
use std::path::{Path, PathBuf};

/// A page in Markdown.
pub struct Page {
    /// Relative to the repository.
    pub path: PathBuf,
    pub text: String,
}

/// The repository.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Whether pages are written anew, as `docs/remake` asks for.
pub fn remakes() -> bool {
    std::env::var_os("EXID_REMAKE").is_some()
}

/// All pages: those at the root, the site's, those of results and of the fuzzed readers.
pub fn all() -> Vec<Page> {
    let mut paths = Vec::new();
    for folder in ["", "docs", "fuzz", "packaging"] {
        collect(&root().join(folder), false, &mut paths);
    }
    collect(&root().join("docs/src"), true, &mut paths);
    for entry in fs::read_dir(root().join("results")).unwrap() {
        collect(&entry.unwrap().path(), false, &mut paths);
    }
    paths.sort();
    paths
        .into_iter()
        .map(|path| Page {
            text: fs::read_to_string(&path).unwrap(),
            path: path.strip_prefix(root()).unwrap().to_path_buf(),
        })
        .collect()
}

fn collect(folder: &Path, deep: bool, found: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(folder) else {
        return;
    };
    for entry in entries {
        let path = entry.unwrap().path();
        if path.is_dir() && deep {
            collect(&path, deep, found);
        } else if path.extension().is_some_and(|e| e == "md") {
            found.push(path);
        }
    }
}

/// Lines of a text outside of fenced blocks, with their numbers from 1.
pub fn prose(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut inside = false;
    text.lines().enumerate().filter_map(move |(k, line)| {
        let fence = line.trim_start().starts_with("```");
        inside ^= fence;
        (!fence && !inside).then_some((k + 1, line))
    })
}

/// Writes a generated file, or holds the one that is there to it.
pub fn settle(path: &str, text: &str) {
    let file = root().join(path);
    if remakes() {
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(file, text).unwrap();
        return;
    }
    let there = fs::read_to_string(&file).unwrap_or_default();
    let line = there.lines().zip(text.lines()).position(|(a, b)| a != b);
    assert!(
        there == text,
        "{path} is not what the program gives now (first at line {}); run docs/remake",
        line.map_or(there.lines().count().min(text.lines().count()), |k| k) + 1
    );
}
