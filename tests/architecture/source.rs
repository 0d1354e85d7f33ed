//! The files of the source, and their text without comments and texts.

use std::fs;
use std::path::{Path, PathBuf};

/// A source file: its path from the root of the repository, and its text.
pub struct Source {
    pub path: PathBuf,
    pub text: String,
}

impl Source {
    /// The module right under the crate that the file belongs to.
    pub fn module(&self) -> Option<String> {
        let first = self.path.strip_prefix("src").ok()?.iter().next()?;
        let module = Path::new(first).file_stem()?.to_str()?;
        (!["lib", "main"].contains(&module)).then(|| module.to_owned())
    }
}

/// All Rust files under a folder of the repository, in the order of their paths.
pub fn sources(folder: &str) -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut folders = vec![root.join(folder)];
    let mut sources = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                sources.push(Source {
                    text: fs::read_to_string(&path).unwrap(),
                    path: path.strip_prefix(root).unwrap().to_path_buf(),
                });
            }
        }
    }
    sources.sort_by(|a, b| a.path.cmp(&b.path));
    sources
}

/// The text with comments, texts and characters blanked, lines kept.
pub fn bare(text: &str) -> String {
    blanked(text, |_| true)
}

/// The text with comments blanked, lines kept.
pub fn uncommented(text: &str) -> String {
    blanked(text, |first| first == '/')
}

/// The text with those comments, texts and characters blanked that begin with a character which is to go.
fn blanked(text: &str, goes: fn(char) -> bool) -> String {
    let chars: Vec<char> = text.chars().collect();
    let mut out = String::with_capacity(text.len());
    let mut i = 0;
    while i < chars.len() {
        let end = blank_end(&chars, i).max(i + 1);
        let blank = blank_end(&chars, i) > i && goes(chars[i]);
        let kept = |c: &char| if blank && *c != '\n' { ' ' } else { *c };
        out.extend(chars[i..end].iter().map(kept));
        i = end;
    }
    out
}

/// The end of the comment, text or character that begins at `start`; `start` if there is none.
fn blank_end(chars: &[char], start: usize) -> usize {
    let at = |offset: usize| chars.get(start + offset).copied().unwrap_or(' ');
    let find = |from: usize, is_end: &dyn Fn(usize) -> bool| {
        (from..chars.len())
            .find(|i| is_end(*i))
            .unwrap_or(chars.len())
    };
    let word_before = start > 0 && (chars[start - 1].is_alphanumeric() || chars[start - 1] == '_');
    match (at(0), at(1)) {
        ('/', '/') => find(start, &|i| chars[i] == '\n'),
        ('/', '*') => find(start + 2, &|i| chars[i - 1] == '*' && chars[i] == '/') + 1,
        ('r', '"' | '#') if !word_before => {
            let hashes = chars[start + 1..].iter().take_while(|c| **c == '#').count();
            if at(1 + hashes) != '"' {
                return start;
            }
            let closes =
                |i: usize| chars[i] == '"' && (1..=hashes).all(|k| chars.get(i + k) == Some(&'#'));
            find(start + 2 + hashes, &closes) + hashes + 1
        }
        ('"', _) => quoted_end(chars, start),
        ('\'', '\\') => find(start + 3, &|i| chars[i] == '\'') + 1,
        ('\'', _) if at(2) == '\'' => start + 3,
        _ => start,
    }
    .min(chars.len())
}

fn quoted_end(chars: &[char], start: usize) -> usize {
    let mut i = start + 1;
    while i < chars.len() && chars[i] != '"' {
        i += if chars[i] == '\\' { 2 } else { 1 };
    }
    i + 1
}

/// Names that follow `word` in the text, with the line of each.
pub fn names_after<'a>(text: &'a str, word: &str) -> Vec<(usize, usize, &'a str)> {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    text.match_indices(word)
        .filter(|(offset, _)| !text[..*offset].ends_with(is_name))
        .map(|(offset, _)| {
            let rest = &text[offset + word.len()..];
            let end = rest.find(|c| !is_name(c)).unwrap_or(rest.len());
            let line = text[..offset].matches('\n').count() + 1;
            (offset, line, &rest[..end])
        })
        .collect()
}

#[test]
fn recognises_texts_and_comments() {
    let text = "fn a(x: [u8; 2]) {\n  let s = \"fn x\"; // fn y\n  let c = '}';\n}\n\
                fn b<'a>(x: &'a str);\nfn c() -> u8 {\n  r#\"fn z\"# /* fn w */\n}\n";
    let bare = bare(text);
    let functions: Vec<_> = names_after(&bare, "fn ")
        .into_iter()
        .map(|(_, line, name)| (line, name))
        .collect();
    assert_eq!(functions, [(1, "a"), (5, "b"), (6, "c")]);
}
