//! Links of all pages: every relative one leads to a file that ships, and every anchor to a heading.

use crate::pages::{self, prose, root};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};
use std::process::Command;

/// Targets of the links and pictures of a line: what stands in `](...)`, code spans left out.
fn targets(line: &str) -> Vec<String> {
    let outside: String = line.split('`').step_by(2).collect::<Vec<_>>().join("`");
    outside
        .split("](")
        .skip(1)
        .filter_map(|rest| rest.split_once(')'))
        .map(|(target, _)| target.trim_matches(['<', '>']).to_owned())
        .collect()
}

/// Anchors of a page: its headings, and `id`s that are written as HTML.
fn anchors(text: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for (_, line) in prose(text) {
        if line.starts_with('#') {
            let slug = slug(line.trim_start_matches('#').trim());
            let count = counts.entry(slug.clone()).or_default();
            found.insert(match *count {
                0 => slug,
                n => format!("{slug}-{n}"),
            });
            *count += 1;
        }
        for rest in line.split("id=\"").skip(1) {
            found.extend(rest.split_once('"').map(|(id, _)| id.to_owned()));
        }
    }
    found
}

/// A heading's anchor: letters, digits, `-` and `_` in lower case, blanks as `-`.
fn slug(heading: &str) -> String {
    let kept = heading
        .chars()
        .filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c));
    kept.map(|c| if c == ' ' { '-' } else { c })
        .collect::<String>()
        .to_lowercase()
}

/// A path without `.` and `..`.
fn plain(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => {
                out.pop();
            }
            Component::CurDir => {}
            part => out.push(part),
        }
    }
    out
}

/// Files that ship: those that git knows or would add; all of them where there is no repository.
fn shipped() -> Option<BTreeSet<PathBuf>> {
    let mut git = Command::new("git");
    git.current_dir(root());
    let output = git.args(["ls-files", "-co", "--exclude-standard"]).output();
    let output = output.ok().filter(|o| o.status.success())?;
    let text = String::from_utf8(output.stdout).unwrap();
    Some(text.lines().map(PathBuf::from).collect())
}

#[test]
fn no_link_is_dead() {
    let pages = pages::all();
    let shipped = shipped();
    let mut dead = Vec::new();
    let mut seen = 0;
    for page in &pages {
        for (number, line) in prose(&page.text) {
            for target in targets(line) {
                if target.contains("://") || target.starts_with("mailto:") {
                    continue;
                }
                seen += 1;
                let (file, anchor) = target.split_once('#').unwrap_or((&target, ""));
                let path = match file {
                    "" => page.path.clone(),
                    file => plain(&page.path.parent().unwrap().join(file)),
                };
                let place = format!("{}:{number}: {target}", page.path.display());
                let full = root().join(&path);
                let ships = match &shipped {
                    Some(files) => files.contains(&path) || full.is_dir(),
                    None => full.exists(),
                };
                if !ships || !full.exists() {
                    dead.push(format!("{place}: no such file"));
                } else if !anchor.is_empty() {
                    let text = pages.iter().find(|p| p.path == path).map(|p| &p.text);
                    if !text.is_some_and(|text| anchors(text).contains(anchor)) {
                        dead.push(format!("{place}: no such heading"));
                    }
                }
            }
        }
    }
    assert!(dead.is_empty(), "{}", dead.join("\n"));
    assert!(seen > 150, "{seen} links");
}

/// The contents of the site have every page of it, and every page of results, once.
#[test]
fn contents_list_every_page_of_the_site() {
    let pages = pages::all();
    let contents = |p: &&pages::Page| p.path == Path::new("docs/src/SUMMARY.md");
    let summary = pages.iter().find(contents).unwrap();
    let listed: Vec<PathBuf> = prose(&summary.text)
        .flat_map(|(_, line)| targets(line))
        .map(|target| plain(&Path::new("docs/src").join(target)))
        .collect();
    for page in &pages {
        if page.path.starts_with("docs/src") && page.path != summary.path {
            let count = listed.iter().filter(|path| **path == page.path).count();
            assert_eq!(count, 1, "{} in SUMMARY.md", page.path.display());
        }
        if page.path.starts_with("results") {
            let chapter = Path::new("docs/src").join(&page.path);
            assert!(listed.contains(&chapter), "{}", chapter.display());
        }
    }
}

/// Slugs as the sites of repositories make them.
#[test]
fn matches_known_anchors() {
    assert_eq!(slug("A real arm"), "a-real-arm");
    assert_eq!(slug("The simulator's file"), "the-simulators-file");
    assert_eq!(slug("`[robot]`"), "robot");
    assert_eq!(slug("stribeck_friction"), "stribeck_friction");
    assert_eq!(
        targets("a [b](c.md#d) and `[x](y)` ![p](q.svg)"),
        ["c.md#d", "q.svg"]
    );
}
