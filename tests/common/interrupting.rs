//! Interrupting the program as a user does who presses Ctrl-C.

use std::process::{Child, Command};
use std::thread::sleep;
use std::time::Duration;

const SIGINT: u32 = 2;

/// Whether a process catches interrupts by now, as the system sees it.
fn catches_interrupts(child: &Child) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{}/status", child.id()));
    let status = status.unwrap_or_default();
    let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
    let mask = caught.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask & (1 << (SIGINT - 1)) != 0)
}

/// Interrupts a run a while after it can be interrupted, and gives its exit code.
pub fn interrupt(mut child: Child, after: Duration) -> Option<i32> {
    while !catches_interrupts(&child) {
        assert!(child.try_wait().unwrap().is_none(), "ended before its time");
        sleep(Duration::from_micros(200));
    }
    sleep(after);
    send(&mut child);
    child.wait().unwrap().code()
}

/// Sends an interrupt to a process, which may have ended.
pub fn send(child: &mut Child) {
    let process = child.id().to_string();
    let sent = Command::new("kill").args(["-INT", &process]).status();
    // One that has ended can no longer be told.
    assert!(sent.unwrap().success() || child.try_wait().unwrap().is_some());
}
