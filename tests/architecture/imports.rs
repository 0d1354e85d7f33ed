//! Which file uses which: every `use` tree and every path of a file, resolved to the file that defines what is named.
//!
//! A name that a module only re-exports leads to the file it comes from, so a re-export is no dependency of its readers
//! on the module. What stands under `#[cfg(test)]` is left out.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::path::Path;

use crate::circles::circles;
use crate::source::{Source, bare};

/// A path from the root of the crate: `["chain", "effect", "Table"]`.
type Absolute = Vec<String>;

/// One file as a module.
struct File {
    path: String,
    module: Absolute,
    children: BTreeSet<String>,
    functions: BTreeSet<String>,
    /// What `use` binds: a path of the crate, or none for what comes from outside.
    names: BTreeMap<String, Option<Absolute>>,
    uses: Vec<Named>,
}

/// A path that a file names.
#[derive(Clone)]
struct Named {
    line: usize,
    path: Vec<String>,
}

/// That a file uses what another one defines.
struct Arrow {
    from: usize,
    to: usize,
    line: usize,
    path: String,
}

/// An arrow between two members of the smallest folder that holds both of its files.
struct Between<'a> {
    folder: &'a Path,
    from: &'a OsStr,
    to: &'a OsStr,
    arrow: &'a Arrow,
}

impl<'a> Between<'a> {
    fn of(arrow: &'a Arrow, from: &'a Path, to: &'a Path) -> Self {
        let folder = from.ancestors().find(|folder| to.starts_with(folder));
        let folder = folder.expect("every path is in the empty one");
        let member = |path: &'a Path| path.strip_prefix(folder).ok()?.iter().next();
        Between {
            folder,
            from: member(from).expect("two files differ"),
            to: member(to).expect("two files differ"),
            arrow,
        }
    }
}

/// All files of a crate and the arrows between them.
pub struct Imports {
    files: Vec<File>,
    arrows: Vec<Arrow>,
}

impl Imports {
    /// Reads the files of a crate whose root is `src/lib.rs`.
    pub fn of(sources: &[Source]) -> Imports {
        let mut for_tests = BTreeSet::new();
        let mut files: Vec<File> = Vec::new();
        for source in sources {
            let Some(module) = module_of(&source.path) else {
                continue;
            };
            let mut reader = Reader::new(source, module);
            reader.read();
            for_tests.extend(reader.for_tests);
            files.push(reader.file);
        }
        files
            .retain(|file| !(1..=file.module.len()).any(|n| for_tests.contains(&file.module[..n])));
        for file in &mut files {
            file.bind();
        }
        let mut imports = Imports {
            files,
            arrows: Vec::new(),
        };
        imports.arrows = imports.resolved();
        imports
    }

    /// How many arrows there are.
    pub fn arrows(&self) -> usize {
        self.arrows.len()
    }

    /// Each circle of files, with the lines that make it.
    pub fn circles(&self) -> Vec<String> {
        let mut targets = vec![Vec::new(); self.files.len()];
        for arrow in &self.arrows {
            targets[arrow.from].push(arrow.to);
        }
        circles(&targets)
            .iter()
            .map(|members| self.described(members))
            .collect()
    }

    fn described(&self, members: &[usize]) -> String {
        let mut text = format!("a circle of {} files:", members.len());
        for arrow in &self.arrows {
            if members.contains(&arrow.from) && members.contains(&arrow.to) {
                text += &self.line(arrow);
            }
        }
        text
    }

    fn line(&self, arrow: &Arrow) -> String {
        let (from, to) = (&self.files[arrow.from].path, &self.files[arrow.to].path);
        format!("\n  {from}:{}: {} is of {to}", arrow.line, arrow.path)
    }

    /// Each circle of what lies in one folder: its files, and its folders with all that is in them.
    pub fn circles_of_folders(&self) -> Vec<String> {
        let mut between: BTreeMap<&Path, Vec<Between<'_>>> = BTreeMap::new();
        for arrow in &self.arrows {
            let (from, to) = (&self.files[arrow.from].path, &self.files[arrow.to].path);
            let step = Between::of(arrow, Path::new(from), Path::new(to));
            between.entry(step.folder).or_default().push(step);
        }
        between
            .values()
            .flat_map(|arrows| self.circles_among(arrows))
            .collect()
    }

    fn circles_among(&self, arrows: &[Between<'_>]) -> Vec<String> {
        let nodes: BTreeSet<&OsStr> = arrows.iter().flat_map(|a| [a.from, a.to]).collect();
        let nodes: Vec<&OsStr> = nodes.into_iter().collect();
        let number = |node: &OsStr| nodes.iter().position(|known| *known == node);
        let mut targets = vec![Vec::new(); nodes.len()];
        for arrow in arrows {
            if let Some((from, to)) = number(arrow.from).zip(number(arrow.to)) {
                targets[from].push(to);
            }
        }
        let described = |members: &Vec<usize>| {
            let among = |node: &OsStr| members.iter().any(|member| nodes[*member] == node);
            let names: Vec<_> = members
                .iter()
                .map(|member| nodes[*member].to_string_lossy())
                .collect();
            let mut text = format!(
                "a circle in {}: {}",
                arrows[0].folder.display(),
                names.join(", ")
            );
            for arrow in arrows {
                if among(arrow.from) && among(arrow.to) {
                    text += &self.line(arrow.arrow);
                }
            }
            text
        };
        circles(&targets).iter().map(described).collect()
    }

    fn resolved(&self) -> Vec<Arrow> {
        let mut arrows = Vec::new();
        for (from, file) in self.files.iter().enumerate() {
            for named in &file.uses {
                let Some(path) = file.absolute(&named.path) else {
                    continue;
                };
                if let Some(to) = self.definition(&path, 0)
                    && to != from
                {
                    let line = named.line;
                    let path = named.path.join("::");
                    arrows.push(Arrow {
                        from,
                        to,
                        line,
                        path,
                    });
                }
            }
        }
        arrows
    }

    fn file(&self, module: &[String]) -> Option<usize> {
        self.files.iter().position(|file| file.module == module)
    }

    /// The file that defines what a path of the crate names; none if it names a module, or something from outside.
    fn definition(&self, path: &[String], depth: usize) -> Option<usize> {
        // Only a circle of re-exports goes this deep, and the compiler refuses that.
        if depth > 20 {
            return None;
        }
        for (i, segment) in path.iter().enumerate() {
            let module = self.file(&path[..i])?;
            let file = &self.files[module];
            let is_last = i + 1 == path.len();
            let bound = file.names.get(segment);
            if file.children.contains(segment) && !(is_last && bound.is_some()) {
                if is_last && file.functions.contains(segment) {
                    return Some(module);
                }
                continue;
            }
            return match bound {
                // A name that leads to itself is that of a module.
                Some(Some(target)) if target[..] != path[..=i] => {
                    let path: Absolute = target.iter().chain(&path[i + 1..]).cloned().collect();
                    self.definition(&path, depth + 1)
                }
                Some(_) => None,
                None => Some(module),
            };
        }
        None
    }
}

/// The module of a file under `src`; none for the program, which is a crate of its own.
fn module_of(path: &Path) -> Option<Absolute> {
    let inside = path.strip_prefix("src").ok()?.with_extension("");
    let mut module: Absolute = inside
        .iter()
        .map(|part| part.to_string_lossy().into_owned())
        .collect();
    match module.last()?.as_str() {
        "main" => return None,
        "lib" | "mod" => {
            module.pop();
        }
        _ => {}
    }
    Some(module)
}

impl File {
    /// Makes the targets of names absolute.
    fn bind(&mut self) {
        let written = std::mem::take(&mut self.names);
        // Twice, because a name may be of a module that another `use` brings.
        for _ in 0..2 {
            for (name, path) in &written {
                let target = path.as_ref().and_then(|path| self.absolute(path));
                self.names.insert(name.clone(), target);
            }
        }
    }

    /// A path as this file writes it, from the root of the crate; none for what comes from outside or is of this file.
    fn absolute(&self, path: &[String]) -> Option<Absolute> {
        let (first, rest) = path.split_first()?;
        let mut base: Absolute = match first.as_str() {
            "crate" => Vec::new(),
            "self" => self.module.clone(),
            "super" => self.module.split_last()?.1.to_vec(),
            child if self.children.contains(child) => {
                let mut base = self.module.clone();
                base.push(child.to_owned());
                base
            }
            name => self.names.get(name)?.clone()?,
        };
        for segment in rest {
            if segment == "super" {
                base.pop();
            } else {
                base.push(segment.clone());
            }
        }
        Some(base)
    }
}

/// A word or a mark of the source, with its line.
struct Token {
    line: usize,
    text: String,
}

/// Words, `::` and single marks of a text without comments and texts.
fn tokens(text: &str) -> Vec<Token> {
    let mut tokens = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let mut rest = line.trim_start();
        while let Some(first) = rest.chars().next() {
            let is_word = |c: char| c.is_alphanumeric() || c == '_';
            let length = match first {
                c if is_word(c) => rest.find(|c| !is_word(c)).unwrap_or(rest.len()),
                ':' if rest.starts_with("::") => 2,
                other => other.len_utf8(),
            };
            let (text, after) = rest.split_at(length);
            tokens.push(Token {
                line: number + 1,
                text: text.to_owned(),
            });
            rest = after.trim_start();
        }
    }
    tokens
}

/// One pass over the tokens of a file.
struct Reader {
    file: File,
    for_tests: BTreeSet<Absolute>,
    tokens: Vec<Token>,
    at: usize,
    depth: usize,
    /// The depths of the modules inside the file that are open.
    inner: Vec<usize>,
}

impl Reader {
    fn new(source: &Source, module: Absolute) -> Reader {
        Reader {
            file: File {
                path: source.path.display().to_string(),
                module,
                children: BTreeSet::new(),
                functions: BTreeSet::new(),
                names: BTreeMap::new(),
                uses: Vec::new(),
            },
            for_tests: BTreeSet::new(),
            tokens: tokens(&bare(&source.text)),
            at: 0,
            depth: 0,
            inner: Vec::new(),
        }
    }

    /// The token `offset` places on; empty after the end.
    fn ahead(&self, offset: usize) -> &str {
        let token = self.tokens.get(self.at + offset);
        token.map_or("", |token| &token.text)
    }

    fn is_word(&self, offset: usize) -> bool {
        let text = self.ahead(offset);
        text.starts_with(|c: char| c.is_alphabetic() || c == '_')
    }

    fn read(&mut self) {
        while self.at < self.tokens.len() {
            match self.ahead(0) {
                "#" if self.stands(&["#", "[", "cfg", "(", "test", ")", "]"]) => self.leave_out(),
                "use" if self.is_word(1) => self.read_use(),
                "mod" if self.ahead(2) == ";" => {
                    self.file.children.insert(self.ahead(1).to_owned());
                    self.at += 3;
                }
                "mod" if self.ahead(2) == "{" => {
                    self.inner.push(self.depth);
                    self.at += 2;
                }
                "fn" if self.depth == 0 => {
                    self.file.functions.insert(self.ahead(1).to_owned());
                    self.at += 2;
                }
                // What is behind a dot or a qualified type is not a path.
                "." | "::" => self.at += 2,
                "{" => {
                    self.depth += 1;
                    self.at += 1;
                }
                "}" => {
                    self.depth -= 1;
                    self.inner.pop_if(|depth| *depth == self.depth);
                    self.at += 1;
                }
                _ if self.is_word(0) => self.read_path(),
                _ => self.at += 1,
            }
        }
    }

    fn stands(&self, texts: &[&str]) -> bool {
        let mut places = texts.iter().enumerate();
        places.all(|(offset, text)| self.ahead(offset) == *text)
    }

    /// Passes an item for tests, from its attribute to its `;` or its closing brace.
    fn leave_out(&mut self) {
        self.at += 7;
        let mut depth = 0;
        loop {
            match self.ahead(0) {
                "mod" if depth == 0 && self.ahead(2) == ";" => {
                    let mut module = self.file.module.clone();
                    module.push(self.ahead(1).to_owned());
                    self.for_tests.insert(module);
                }
                "{" | "(" | "[" => depth += 1,
                "}" | ")" | "]" => depth -= 1,
                "" => return,
                _ => {}
            }
            let ends = depth == 0 && [";", "}"].contains(&self.ahead(0));
            self.at += 1;
            if ends {
                return;
            }
        }
    }

    fn read_path(&mut self) {
        let line = self.tokens[self.at].line;
        let mut path = vec![self.ahead(0).to_owned()];
        self.at += 1;
        while self.ahead(0) == "::" && self.is_word(1) {
            path.push(self.ahead(1).to_owned());
            self.at += 2;
        }
        if path.len() > 1 {
            self.name(Named { line, path });
        }
    }

    /// Keeps a path that is named, as one of the file where a module inside it names it.
    fn name(&mut self, mut named: Named) {
        let up = named
            .path
            .iter()
            .take_while(|part| *part == "super")
            .count();
        let inside = up.min(self.inner.len());
        named.path.drain(..inside);
        // What is left of `super::name` is of this file.
        if inside == 0 || up > inside {
            self.file.uses.push(named);
        }
    }

    fn read_use(&mut self) {
        self.at += 1;
        self.read_tree(&[]);
    }

    /// A tree of `use` behind the segments `before`: names bound, and paths used.
    fn read_tree(&mut self, before: &[String]) {
        let line = self.tokens[self.at].line;
        let mut path = before.to_vec();
        loop {
            match self.ahead(0) {
                "::" => self.at += 1,
                "{" => {
                    self.at += 1;
                    while self.ahead(0) != "}" {
                        self.read_tree(&path);
                        if self.ahead(0) == "," {
                            self.at += 1;
                        }
                    }
                    self.at += 1;
                    return;
                }
                "*" => {
                    self.at += 1;
                    // Which names it brings stays open, so all of them are taken to be of that file.
                    path.push("*".to_owned());
                    self.name(Named { line, path });
                    return;
                }
                "as" => {
                    let name = self.ahead(1).to_owned();
                    self.at += 2;
                    return self.bind(name, Named { line, path });
                }
                _ if self.is_word(0) => {
                    path.push(self.ahead(0).to_owned());
                    self.at += 1;
                }
                _ => {
                    if path.last().is_some_and(|last| last == "self") && path.len() > 1 {
                        path.pop();
                    }
                    let name = path.last().cloned().unwrap_or_default();
                    return self.bind(name, Named { line, path });
                }
            }
        }
    }

    fn bind(&mut self, name: String, named: Named) {
        if self.inner.is_empty() {
            self.file.names.insert(name, Some(named.path.clone()));
        }
        self.name(named);
    }
}

fn made_up(files: &[(&str, &str)]) -> Imports {
    let sources: Vec<Source> = files
        .iter()
        .map(|(path, text)| Source {
            path: path.into(),
            text: (*text).to_owned(),
        })
        .collect();
    Imports::of(&sources)
}

#[test]
fn sees_a_circle_through_relative_paths_and_modules() {
    let imports = made_up(&[
        ("src/lib.rs", "pub mod arm;"),
        (
            "src/arm/mod.rs",
            "mod link;\npub fn mass() -> f64 { link::mass() }",
        ),
        (
            "src/arm/link.rs",
            "use super::mass as whole;\npub fn mass() -> f64 { whole() }",
        ),
    ]);
    let circles = imports.circles();
    assert_eq!(circles.len(), 1, "{circles:?}");
    let lines = [
        "src/arm/mod.rs:2: link::mass is of src/arm/link.rs",
        "src/arm/link.rs:1: super::mass is of src/arm/mod.rs",
    ];
    for line in lines {
        assert!(circles[0].contains(line), "{}", circles[0]);
    }
}

#[test]
fn sees_a_circle_through_a_module_that_was_imported() {
    let imports = made_up(&[
        ("src/lib.rs", "mod a; mod b; mod c;"),
        (
            "src/a.rs",
            "use crate::{b, c::{self, Third}};\nfn f(t: Third) { b::g(t) }",
        ),
        ("src/b.rs", "pub fn g<T>(t: T) { crate::c::h() }"),
        (
            "src/c.rs",
            "pub struct Third;\npub fn h() { let x: super::a::First; }",
        ),
    ]);
    let circles = imports.circles();
    assert_eq!(circles.len(), 1, "{circles:?}");
    assert!(
        circles[0].starts_with("a circle of 3 files"),
        "{}",
        circles[0]
    );
    assert!(circles[0].contains("src/a.rs:2: b::g is of src/b.rs"));
}

#[test]
fn a_re_export_leads_to_where_the_name_comes_from() {
    let imports = made_up(&[
        ("src/lib.rs", "pub mod arm;"),
        (
            "src/arm/mod.rs",
            "mod body;\nmod link;\npub use body::Body;\npub use link::Link;",
        ),
        ("src/arm/body.rs", "pub struct Body;"),
        (
            "src/arm/link.rs",
            "use super::Body;\npub struct Link(Body);",
        ),
    ]);
    assert_eq!(imports.circles(), Vec::<String>::new());
    // Two re-exports, and the link's use of the body.
    assert_eq!(imports.arrows(), 3);
}

#[test]
fn sees_a_circle_of_folders_that_is_none_of_files() {
    let imports = made_up(&[
        ("src/lib.rs", "mod arm;"),
        ("src/arm/mod.rs", "mod left;\nmod right;\nmod whole;"),
        ("src/arm/whole.rs", "use crate::arm::left::a::A;"),
        ("src/arm/left/mod.rs", "pub mod a;\npub mod d;"),
        (
            "src/arm/left/a.rs",
            "use crate::arm::right::b::B;\npub struct A(B);",
        ),
        ("src/arm/left/d.rs", "pub struct D;"),
        ("src/arm/right/mod.rs", "pub mod b;"),
        (
            "src/arm/right/b.rs",
            "use crate::arm::left::d::D;\npub struct B(D);",
        ),
    ]);
    assert_eq!(imports.circles(), Vec::<String>::new());
    let circles = imports.circles_of_folders();
    assert_eq!(circles.len(), 1, "{circles:?}");
    let lines = [
        "a circle in src/arm: left, right\n",
        "src/arm/left/a.rs:1: crate::arm::right::b::B is of src/arm/right/b.rs",
        "src/arm/right/b.rs:1: crate::arm::left::d::D is of src/arm/left/d.rs",
    ];
    for line in lines {
        assert!(circles[0].contains(line), "{}", circles[0]);
    }
}

#[test]
fn tests_texts_and_comments_make_no_circle() {
    let imports = made_up(&[
        ("src/lib.rs", "mod a; mod b; #[cfg(test)] mod trial;"),
        (
            "src/a.rs",
            "// crate::b::g\n#[cfg(test)]\nmod tests { use crate::b::g; }\npub fn f() { \"crate::b::g\"; }",
        ),
        ("src/b.rs", "pub fn g() { crate::a::f() }"),
        ("src/trial.rs", "use crate::a::f; pub fn t() {}"),
    ]);
    assert_eq!(imports.circles(), Vec::<String>::new());
    assert_eq!(imports.arrows(), 1);
}
