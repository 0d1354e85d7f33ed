//! The program `exid`: see the library for what it does.

use std::process::ExitCode;

fn main() -> ExitCode {
    exid::cli::run(std::env::args_os())
}
