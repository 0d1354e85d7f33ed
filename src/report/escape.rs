//! Text as HTML takes it.

/// Text as it may stand in HTML, in an element or in a quoted attribute.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            _ => out.push(c),
        }
    }
    out
}

/// An escaped identifier or expression that a narrow page may break after a sign within it, but
/// not within a number.
pub fn breakable(name: &str) -> String {
    let mut out = String::with_capacity(name.len());
    let mut rest = name.chars().peekable();
    while let Some(c) = rest.next() {
        out.push_str(&escape(c.encode_utf8(&mut [0; 4])));
        let in_number = rest.peek().is_some_and(char::is_ascii_digit);
        if matches!(c, '_' | '/' | '*') || (c == '.' && !in_number) {
            out.push_str("<wbr>");
        }
    }
    out
}
