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

/// Escaped sentences: what stands between backticks is code, which a narrow page may break as [`breakable`] says.
pub fn prose(text: &str) -> String {
    let parts: Vec<&str> = text.split('`').collect();
    if parts.len().is_multiple_of(2) {
        return escape(text);
    }
    let mut out = String::with_capacity(text.len());
    for (number, part) in parts.into_iter().enumerate() {
        match number % 2 {
            0 => out.push_str(&escape(part)),
            _ => out.push_str(&format!("<code>{}</code>", breakable(part))),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn code_in_sentences_stands_in_an_element_of_its_own() {
        assert_eq!(
            prose("set `a.b<c` & go"),
            "set <code>a.<wbr>b&lt;c</code> &amp; go"
        );
        assert_eq!(prose("a lone ` stays"), "a lone ` stays");
    }
}
