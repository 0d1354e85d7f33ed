//! Messages on the standard error stream.

use crate::cli::colour;
use std::io::Write;

pub(super) fn complain(text: &str) {
    let mut stream = std::io::stderr();
    let _ = writeln!(stream, "{}", colour::for_stream(text, &stream));
}
