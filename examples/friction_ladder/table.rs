//! The table of all runs.

use crate::law::LAWS;
use crate::trial::{Trial, Verdict};

/// Markdown, one row for every truth.
pub fn page(trials: &[Trial], seeds: u64) -> String {
    let mut page = format!(
        "# Does the right friction law win?\n\n\
         {seeds} seeds of each truth, judged on all joints together on another motion. Made by\n\
         `cargo run --release --example friction_ladder -- {seeds}`.\n\n\
         | truth | right law wins | cannot tell, right law among them | cannot tell, without it | wrong law wins | \
         nearest rival misses, in deviations of the error | 95 % intervals that hold the truth |\n\
         |---|---|---|---|---|---|---|\n"
    );
    for (k, law) in LAWS.iter().enumerate() {
        let own: Vec<&Trial> = trials.iter().filter(|t| t.truth == k).collect();
        let count = |verdict| own.iter().filter(|t| t.verdict == verdict).count();
        let mut nearest: Vec<f64> = own.iter().map(|t| t.nearest).collect();
        nearest.sort_by(f64::total_cmp);
        let held: usize = own.iter().map(|t| t.held).sum();
        let all: usize = own.iter().map(|t| t.parameters).sum();
        page.push_str(&format!(
            "| {} | {} | {} | {} | {} | {:.2} ({:.2} .. {:.2}) | {:.1} % of {all} |\n",
            law.name,
            count(Verdict::Right),
            count(Verdict::Open),
            count(Verdict::OpenWithoutRight),
            count(Verdict::Wrong),
            nearest[nearest.len() / 2],
            nearest[0],
            nearest[nearest.len() - 1],
            100.0 * held as f64 / all.max(1) as f64
        ));
    }
    page
}
