//! Names as languages take them.

/// The name with everything that no identifier may hold replaced.
pub(super) fn identifier(name: &str) -> String {
    let clean = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let text: String = name.chars().map(clean).collect();
    if text.is_empty() || text.starts_with(|c: char| c.is_ascii_digit()) {
        format!("robot_{text}")
    } else {
        text
    }
}

/// A name as it may stand in a comment of any language, which it can neither end nor open, on one line.
pub fn in_comment(name: &str) -> String {
    let plain = |c: char| match c {
        '"' => '\'',
        '\\' => '/',
        c if is_invisible(c) => ' ',
        c => c,
    };
    let line: String = name.chars().map(plain).collect();
    line.replace("*/", "* /")
        .replace("/*", "/ *")
        .replace("??", "? ?")
}

/// Ends of lines, and marks that turn the direction of a text around.
pub(super) fn is_invisible(c: char) -> bool {
    let turns = matches!(c, '\u{200e}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}');
    c.is_control() || turns
}

/// A name as a text of the language.
pub(super) fn quoted(name: &str) -> String {
    let of = |c: char| match c {
        '"' => "\\\"".to_string(),
        '\\' => "\\\\".to_string(),
        c if is_invisible(c) => " ".to_string(),
        c => c.to_string(),
    };
    let inner: String = name.chars().map(of).collect();
    format!("\"{inner}\"")
}
