//! Software bill of materials of the program: every package that is built into it, with version, licence and checksum, in
//! CycloneDX 1.5.
//!
//! ```sh
//! cargo run --release --example sbom > sbom.cdx.json
//! ```
//!
//! Packages and licences are those of `cargo metadata` for this platform without development dependencies, checksums those of
//! `Cargo.lock`. The script that draws the charts of reports comes from another registry and is in the sources.

#![forbid(unsafe_code)]

use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::Command;

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let metadata = metadata(root)?;
    let checksums = checksums(&fs::read_to_string(root.join("Cargo.lock"))?)?;
    let graph = built_in(&metadata)?;
    let mut bill = bill(&metadata, &graph, &checksums)?;
    if let Some(components) = bill["components"].as_array_mut() {
        components.push(charts(&root.join("src/report/vendor/uplot"))?);
    }
    println!("{bill:#}");
    Ok(())
}

/// `cargo metadata` for the platform that this was built for.
fn metadata(root: &Path) -> Result<Value, Box<dyn Error>> {
    let compiler = Command::new("rustc").arg("-vV").output()?;
    let words = String::from_utf8(compiler.stdout)?;
    let host = words.lines().find_map(|line| line.strip_prefix("host: "));
    let host = host.ok_or("rustc does not say its platform")?;
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_string());
    let output = Command::new(cargo)
        .current_dir(root)
        .args([
            "metadata",
            "--format-version",
            "1",
            "--locked",
            "--filter-platform",
            host,
        ])
        .output()?;
    match output.status.success() {
        true => Ok(serde_json::from_slice(&output.stdout)?),
        false => Err(String::from_utf8_lossy(&output.stderr).into_owned().into()),
    }
}

/// Checksums by name and version.
fn checksums(lock: &str) -> Result<BTreeMap<(String, String), String>, Box<dyn Error>> {
    let lock: toml::Table = toml::from_str(lock)?;
    let packages = lock.get("package").and_then(|p| p.as_array());
    let text = |package: &toml::Value, key: &str| Some(package.get(key)?.as_str()?.to_string());
    let checksum = |package| {
        let named = (text(package, "name")?, text(package, "version")?);
        Some((named, text(package, "checksum")?))
    };
    Ok(packages
        .into_iter()
        .flatten()
        .filter_map(checksum)
        .collect())
}

/// What each package that is built into the program or builds it needs, by identifiers; development dependencies are left out.
fn built_in(metadata: &Value) -> Result<BTreeMap<&str, BTreeSet<&str>>, Box<dyn Error>> {
    let root = metadata["resolve"]["root"]
        .as_str()
        .ok_or("no root package")?;
    let nodes = metadata["resolve"]["nodes"].as_array().ok_or("no graph")?;
    let node = |id: &str| nodes.iter().find(|node| node["id"] == id);
    let mut graph = BTreeMap::new();
    let mut open = vec![root];
    while let Some(id) = open.pop() {
        if graph.contains_key(id) {
            continue;
        }
        let needed = node(id).and_then(|node| node["deps"].as_array());
        let of_program = |dependency: &&Value| {
            let kinds = dependency["dep_kinds"].as_array();
            kinds.is_some_and(|kinds| kinds.iter().any(|kind| kind["kind"] != "dev"))
        };
        let needed = needed.into_iter().flatten().filter(of_program);
        let needed: BTreeSet<&str> = needed.filter_map(|d| d["pkg"].as_str()).collect();
        open.extend(&needed);
        graph.insert(id, needed);
    }
    Ok(graph)
}

/// The script of charts, whose page of words begins with its name and version.
fn charts(folder: &Path) -> Result<Value, Box<dyn Error>> {
    let page = fs::read_to_string(folder.join("README.md"))?;
    let title = page
        .lines()
        .next()
        .and_then(|line| line.strip_prefix("# uPlot "));
    let version = title.ok_or("the page of uPlot does not begin with its version")?;
    let purl = format!("pkg:npm/uplot@{version}");
    Ok(json!({
        "type": "library",
        "bom-ref": purl,
        "name": "uplot",
        "version": version,
        "purl": purl,
        "description": "Charts of reports",
        "licenses": [{ "expression": "MIT" }],
    }))
}

fn bill(
    metadata: &Value,
    graph: &BTreeMap<&str, BTreeSet<&str>>,
    checksums: &BTreeMap<(String, String), String>,
) -> Result<Value, Box<dyn Error>> {
    let packages = metadata["packages"].as_array().ok_or("no packages")?;
    let root = &metadata["resolve"]["root"];
    let reference = |package: &Value| {
        format!(
            "pkg:cargo/{}@{}",
            text(&package["name"]),
            text(&package["version"])
        )
    };
    let by_id: BTreeMap<&str, String> = packages
        .iter()
        .filter_map(|package| Some((package["id"].as_str()?, reference(package))))
        .collect();
    let component = |package: &Value| {
        let named = (text(&package["name"]), text(&package["version"]));
        let mut component = json!({
            "type": if package["id"] == *root { "application" } else { "library" },
            "bom-ref": reference(package),
            "name": named.0,
            "version": named.1,
            "purl": reference(package),
            "description": package["description"],
            // An older way to write OR.
            "licenses": [{ "expression": text(&package["license"]).replace('/', " OR ").replace("  ", " ") }],
        });
        if let Some(checksum) = checksums.get(&named) {
            component["hashes"] = json!([{ "alg": "SHA-256", "content": checksum }]);
        }
        component
    };
    let mut components = Vec::new();
    let mut program = Value::Null;
    for package in packages {
        let id = package["id"].as_str().unwrap_or_default();
        match (package["id"] == *root, graph.contains_key(id)) {
            (true, _) => program = component(package),
            (false, true) => components.push(component(package)),
            (false, false) => {}
        }
    }
    let dependencies = graph.iter().filter_map(|(id, needed)| {
        let needed: Vec<&String> = needed.iter().filter_map(|id| by_id.get(id)).collect();
        Some(json!({ "ref": by_id.get(id)?, "dependsOn": needed }))
    });
    Ok(json!({
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": { "component": program },
        "components": components,
        "dependencies": dependencies.collect::<Vec<Value>>(),
    }))
}

fn text(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_string()
}
