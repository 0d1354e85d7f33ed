//! The program `exid`: see the library for what it does.

use mimalloc::MiMalloc;
use std::process::ExitCode;

/// Searches take and give back arrays of a hundred kilobytes all the time, which the allocator of the system returns to
/// the kernel and takes from it page by page.
#[global_allocator]
static ALLOCATOR: MiMalloc = MiMalloc;

fn main() -> ExitCode {
    exid::cli::run(std::env::args_os())
}
