//! Ctrl-C as a flag that long work looks at.

use crate::cli::messages::complain;
use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

/// The flag that the first interrupt sets; the second ends the process at once.
pub fn flag() -> Arc<AtomicBool> {
    static FLAG: OnceLock<Arc<AtomicBool>> = OnceLock::new();
    Arc::clone(FLAG.get_or_init(handled))
}

fn handled() -> Arc<AtomicBool> {
    let flag = Arc::new(AtomicBool::new(false));
    let seen = Arc::clone(&flag);
    // Without a handler, as where one exists already, an interrupt ends the process as usual.
    let _ = ctrlc::set_handler(move || {
        if seen.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(crate::cli::error::CliError::INTERRUPTED));
        }
        if std::io::stderr().is_terminal() {
            // In the place of the line of progress.
            eprint!("\r\u{1b}[2K");
        }
        complain("interrupted: ending with what is found so far; a second interrupt ends at once");
    });
    flag
}
