//! Colours of the words that say how bad something is, on terminals that want them.

use std::ffi::OsStr;
use std::io::IsTerminal;

/// Words at the beginning of a line, and how terminals set them: bold red, bold yellow.
const WORDS: [(&str, &str); 2] = [("error:", "1;31"), ("warning:", "1;33")];

/// The text as it goes to a stream: coloured where that is a terminal and nobody has set `NO_COLOR` (no-color.org).
pub fn for_stream(text: &str, stream: &impl IsTerminal) -> String {
    let [refused, terminal] = ["NO_COLOR", "TERM"].map(std::env::var_os);
    match stream.is_terminal() && is_wanted(refused.as_deref(), terminal.as_deref()) {
        true => coloured(text),
        false => text.to_owned(),
    }
}

/// Whether a terminal of this kind is to have colours.
fn is_wanted(refused: Option<&OsStr>, terminal: Option<&OsStr>) -> bool {
    refused.is_none_or(OsStr::is_empty) && terminal.is_none_or(|kind| kind != "dumb")
}

fn coloured(text: &str) -> String {
    let of_line = |line: &str| {
        let found = WORDS.iter().find(|(word, _)| line.starts_with(word));
        found.map_or(line.to_owned(), |(word, colour)| {
            format!("\u{1b}[{colour}m{word}\u{1b}[0m{}", &line[word.len()..])
        })
    };
    text.split_inclusive('\n').map(of_line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_at_the_beginning_of_a_line_alone_are_coloured() {
        let text = "error: one\n  an error: two\nwarning: three\nerrors: four";
        let expected = "\u{1b}[1;31merror:\u{1b}[0m one\n  an error: two\n\u{1b}[1;33mwarning:\u{1b}[0m three\nerrors: four";
        assert_eq!(coloured(text), expected);
    }

    #[test]
    fn no_color_and_dumb_terminals_are_heeded() {
        let of = |text: &'static str| Some(OsStr::new(text));
        assert!(is_wanted(None, of("xterm")) && is_wanted(of(""), None));
        assert!(!is_wanted(of("1"), of("xterm")) && !is_wanted(None, of("dumb")));
    }
}
