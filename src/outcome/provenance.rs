//! Who made a result, when, and on what: the one part of it that differs between runs that are the same.

use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

/// Where a result comes from. Beside the wall time it alone differs between runs of the same problem and seed.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Provenance {
    /// Arguments of the command line, without the program's name.
    pub command: Vec<String>,
    /// Folder in which the command was given, from which relative paths start.
    pub directory: String,
    /// End of the run in UTC, `2026-01-31T12:00:00Z`.
    pub date: String,
    /// Threads that the run could use.
    pub threads: usize,
    /// Commit of the sources that the program was built from; its version where that is not known.
    pub revision: String,
    /// Features that it was built with.
    pub features: Vec<String>,
    /// Architecture, system and processor of the computer.
    pub processor: String,
}

impl Provenance {
    /// Of this process, which was given a command.
    pub fn of_this_process(command: Vec<String>) -> Self {
        let directory = std::env::current_dir().unwrap_or_default();
        let revision = match env!("EXID_REVISION") {
            "" => format!("version {}", VERSION),
            commit => commit.to_owned(),
        };
        let features = env!("EXID_FEATURES").split(',').filter(|f| !f.is_empty());
        Self {
            command,
            directory: directory.display().to_string(),
            date: date(SystemTime::now()),
            threads: rayon::current_num_threads(),
            revision,
            features: features.map(str::to_owned).collect(),
            processor: processor(),
        }
    }
}

/// Architecture and system, and the processor's name where the system tells it.
fn processor() -> String {
    let system = format!("{} {}", std::env::consts::ARCH, std::env::consts::OS);
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find_map(|line| {
        let (key, value) = line.split_once(':')?;
        (key.trim() == "model name").then(|| value.trim().to_owned())
    });
    name.map_or(system.clone(), |name| format!("{system}, {name}"))
}

/// An instant in UTC as ISO 8601 writes it, to the second; years from 1970 on.
pub fn date(instant: SystemTime) -> String {
    let since = instant.duration_since(UNIX_EPOCH).unwrap_or_default();
    let (mut days, second) = (since.as_secs() / 86_400, since.as_secs() % 86_400);
    let is_leap = |year: u64| {
        year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400))
    };
    let mut year = 1970;
    while days >= 365 + u64::from(is_leap(year)) {
        days -= 365 + u64::from(is_leap(year));
        year += 1;
    }
    let february = 28 + u64::from(is_leap(year));
    let mut month = 1;
    for length in [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31] {
        if days < length {
            break;
        }
        days -= length;
        month += 1;
    }
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    format!(
        "{year:04}-{month:02}-{:02}T{hour:02}:{minute:02}:{second:02}Z",
        days + 1
    )
}

/// Version of this program, as written into every result.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    /// Values of `date -u -d @SECONDS +%FT%TZ` (GNU coreutils).
    #[test]
    fn matches_another_program_s_calendar() {
        for (seconds, expected) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_399, "2000-02-28T23:59:59Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (1_709_251_199, "2024-02-29T23:59:59Z"),
            (1_735_689_599, "2024-12-31T23:59:59Z"),
            (4_107_542_400, "2100-03-01T00:00:00Z"),
        ] {
            assert_eq!(date(UNIX_EPOCH + Duration::from_secs(seconds)), expected);
        }
    }
}
