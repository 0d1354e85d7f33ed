//! Progress on standard error, when it is a terminal.

use crate::cli::args::Printing;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::time::Duration;

/// A line that tells what is going on; silent where nobody watches.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    pub fn new(printing: Printing) -> Self {
        if printing.quiet || printing.json || !std::io::stderr().is_terminal() {
            return Self {
                bar: ProgressBar::hidden(),
            };
        }
        let bar = ProgressBar::new_spinner();
        if let Ok(style) = ProgressStyle::with_template("{spinner} {elapsed:>4}  {msg}") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(120));
        Self { bar }
    }

    pub fn say(&self, text: impl Into<String>) {
        self.bar.set_message(text.into());
    }

    pub fn done(&self) {
        self.bar.finish_and_clear();
    }
}
