//! What the program is built from: licences of all dependencies against the list of `deny.toml`, and the places where the
//! source is not held to memory safety by the compiler.

use serde_json::Value;
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// An SPDX expression, where `/` stands for OR as in older manifests.
struct Expression<'a> {
    words: Vec<&'a str>,
    at: usize,
    allowed: &'a [String],
}

impl<'a> Expression<'a> {
    /// Whether licences that are allowed satisfy it.
    fn is_satisfied(text: &str, allowed: &[String]) -> bool {
        let spaced = text
            .replace('/', " OR ")
            .replace('(', " ( ")
            .replace(')', " ) ");
        let words = spaced.split_whitespace().collect();
        let mut expression = Expression {
            words,
            at: 0,
            allowed,
        };
        let satisfied = expression.either();
        satisfied && expression.at == expression.words.len()
    }

    fn next(&mut self, word: &str) -> bool {
        let is_next = self.words.get(self.at) == Some(&word);
        self.at += usize::from(is_next);
        is_next
    }

    fn either(&mut self) -> bool {
        let mut satisfied = self.both();
        while self.next("OR") {
            satisfied |= self.both();
        }
        satisfied
    }

    fn both(&mut self) -> bool {
        let mut satisfied = self.one();
        while self.next("AND") {
            satisfied &= self.one();
        }
        satisfied
    }

    fn one(&mut self) -> bool {
        if self.next("(") {
            let satisfied = self.either();
            return self.next(")") && satisfied;
        }
        let mut name = self
            .words
            .get(self.at)
            .copied()
            .unwrap_or_default()
            .to_string();
        self.at += 1;
        if self.next("WITH") {
            name = format!(
                "{name} WITH {}",
                self.words.get(self.at).copied().unwrap_or_default()
            );
            self.at += 1;
        }
        self.allowed.contains(&name)
    }
}

#[test]
fn licences_are_expressions() {
    let allowed = [
        "MIT",
        "Apache-2.0",
        "Zlib",
        "Apache-2.0 WITH LLVM-exception",
    ]
    .map(String::from);
    for (text, satisfied) in [
        ("MIT", true),
        ("GPL-3.0", false),
        ("GPL-3.0 OR MIT", true),
        ("Unlicense/MIT", true),
        ("GPL-3.0 AND MIT", false),
        ("(MIT OR GPL-3.0) AND Zlib", true),
        ("(MIT OR Apache-2.0) AND Unicode-3.0", false),
        ("Apache-2.0 WITH LLVM-exception", true),
        ("GPL-2.0 WITH LLVM-exception", false),
        ("", false),
    ] {
        assert_eq!(
            Expression::is_satisfied(text, &allowed),
            satisfied,
            "{text}"
        );
    }
}

#[test]
fn licences_of_all_dependencies_are_allowed() {
    let deny: toml::Table =
        toml::from_str(&fs::read_to_string(root().join("deny.toml")).unwrap()).unwrap();
    let allowed = deny["licenses"]["allow"].as_array().unwrap();
    let allowed: Vec<String> = allowed
        .iter()
        .map(|l| l.as_str().unwrap().to_string())
        .collect();
    let compiler = Command::new("rustc").arg("-vV").output().unwrap();
    let words = String::from_utf8(compiler.stdout).unwrap();
    let host = words
        .lines()
        .find_map(|line| line.strip_prefix("host: "))
        .unwrap();
    let metadata = Command::new(env!("CARGO"))
        .current_dir(root())
        .args([
            "metadata",
            "--format-version",
            "1",
            "--locked",
            "--filter-platform",
            host,
        ])
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&metadata.stderr);
    assert!(metadata.status.success(), "{error}");
    let metadata: Value = serde_json::from_slice(&metadata.stdout).unwrap();
    let packages = metadata["packages"].as_array().unwrap();
    assert!(packages.len() > 100, "{} packages", packages.len());
    let mut wrong = Vec::new();
    for package in packages {
        let licence = package["license"].as_str().unwrap_or_default();
        if !Expression::is_satisfied(licence, &allowed) {
            wrong.push(format!(
                "{} {}: {licence:?}",
                package["name"], package["version"]
            ));
        }
        let source = package["source"].as_str().unwrap_or("registry+");
        assert!(
            source.starts_with("registry+"),
            "{}: {source}",
            package["name"]
        );
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Versions and features of what is compiled for a build, by `cargo tree` with some arguments.
fn compiled(arguments: &[&str]) -> BTreeSet<String> {
    let tree = Command::new(env!("CARGO"))
        .current_dir(root())
        .args([
            "tree", "--locked", "--prefix", "none", "--format", "{p} {f}",
        ])
        .args(arguments)
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&tree.stderr);
    assert!(tree.status.success(), "{error}");
    let lines = String::from_utf8(tree.stdout).unwrap();
    let lines = lines.lines().map(|line| line.replace(" (*)", ""));
    lines.filter(|line| !line.is_empty()).collect()
}

/// The program, its tests and the Python package ask for the same features of what they share: otherwise the library, and most of what it
/// is made of, is compiled anew for each of them.
#[test]
fn what_is_shared_is_compiled_once() {
    let program = compiled(&["--package", "exid", "--edges", "no-dev"]);
    assert!(program.len() > 100, "{} packages", program.len());
    let package = ["--package", "exid-python", "--edges", "no-dev"];
    for arguments in [&["--package", "exid"][..], &package] {
        let other = compiled(arguments);
        let of_its_own: Vec<&String> = program.difference(&other).collect();
        assert!(of_its_own.is_empty(), "{arguments:?}: {of_its_own:#?}");
    }
}

/// The library without features is made without what they need, and its first page lists them all.
#[test]
fn what_features_need_is_compiled_for_them_alone() {
    let manifest = fs::read_to_string(root().join("Cargo.toml")).unwrap();
    let manifest: toml::Table = toml::from_str(&manifest).unwrap();
    let page = fs::read_to_string(root().join("src/lib.rs")).unwrap();
    for feature in manifest["features"].as_table().unwrap().keys() {
        let row = format!("//! - `{feature}`: ");
        let is_told = page.contains(&row) || ["default", "shared"].contains(&feature.as_str());
        assert!(is_told, "{row}");
    }
    let bare = compiled(&[
        "--package",
        "exid",
        "--edges",
        "no-dev",
        "--no-default-features",
    ]);
    let shared = manifest["features"]["shared"].as_array().unwrap();
    let shared: Vec<String> = shared
        .iter()
        .filter_map(|name| Some(name.as_str()?.strip_prefix("dep:")?.to_string()))
        .collect();
    let dependencies = manifest["dependencies"].as_table().unwrap();
    let is_optional = |of: &toml::Value| of.get("optional").is_some();
    let optional: Vec<&String> = dependencies
        .iter()
        .filter_map(|(name, of)| is_optional(of).then_some(name))
        .collect();
    assert!(!optional.is_empty());
    for name in optional {
        let package = format!("{name} v");
        let is_there = bare.iter().any(|line| line.starts_with(&package));
        // Of what is shared, others ask for some.
        assert!(!is_there || shared.contains(name), "{name}");
    }
}

/// Files that may hold `unsafe`. In the library one module: vector instructions that are run where the processor has them. In the
/// bindings the memory of NumPy's arrays.
const UNSAFE: [&str; 3] = [
    "python/src/arrays.rs",
    "src/linalg/lanes/instructions.rs",
    "src/linalg/lanes/registers.rs",
];

#[test]
fn unsafe_stands_where_it_is_known_to() {
    let mut folders = ["src", "tests", "examples", "benches", "python/src"]
        .map(|name| root().join(name))
        .to_vec();
    let mut found: Vec<PathBuf> = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let text = fs::read_to_string(&path).unwrap();
                let opens = ["{", "fn ", "impl ", "extern "].map(|what| ["unsafe", what].join(" "));
                if opens.iter().any(|open| text.contains(open)) {
                    found.push(path);
                }
            }
        }
    }
    let mut found: Vec<String> = found
        .iter()
        .map(|path| path.strip_prefix(root()).unwrap().display().to_string())
        .collect();
    found.sort();
    assert_eq!(found, UNSAFE);
}

/// What other authors wrote and the repository holds: each folder says version and licence, and its files are those whose checksums it states.
#[test]
fn vendored_files_are_those_that_their_folder_states() {
    let vendor = root().join("src/report/vendor");
    for entry in fs::read_dir(&vendor).unwrap() {
        let folder = entry.unwrap().path();
        let page = fs::read_to_string(folder.join("README.md")).unwrap();
        assert!(
            page.contains("version ") && page.contains("licence"),
            "{page}"
        );
        assert!(folder.join("LICENSE").exists(), "{}", folder.display());
        let mut files = 0;
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap();
            if name != "README.md" {
                let digest = Sha256::digest(fs::read(&path).unwrap());
                let digest: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
                assert!(
                    page.contains(&format!("| `{name}` | `{digest}` |")),
                    "{name}: {digest}"
                );
                files += 1;
            }
        }
        assert!(files > 1, "{}", folder.display());
    }
}
