//! How long a run of many alike parts still takes, for progress.

use std::time::Duration;

/// The time that is left when so many of all parts took so long, in words after a comma; nothing before the first part is done.
pub fn left(elapsed: Duration, done: usize, all: usize) -> String {
    if done == 0 || done >= all {
        return String::new();
    }
    let seconds = elapsed.as_secs_f64() * (all - done) as f64 / done as f64;
    let words = match seconds {
        s if s < 99.5 => format!("{s:.0} s"),
        s if s < 99.5 * 60.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.0} h", s / 3600.0),
    };
    format!(", about {words} left")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_takes_as_long_as_what_is_done() {
        let of = |seconds, done| left(Duration::from_secs(seconds), done, 12);
        assert_eq!(of(10, 4), ", about 20 s left");
        assert_eq!(of(600, 6), ", about 10 min left");
        assert_eq!(of(36_000, 2), ", about 50 h left");
        assert_eq!(of(5, 0), "");
        assert_eq!(of(5, 12), "");
    }
}
