//! `exid fleet`: every item of a manifest fitted or diagnosed once, the table, and which robots have changed.

use crate::cli::args::FleetRun;
use crate::cli::error::CliError;
use crate::cli::progress::Progress;
use crate::cli::{interrupt, output};
use crate::fleet::error::FleetError;
use crate::fleet::task::{self, Counts, Results, Settings, TABLE_FILE};
use crate::outcome::estimate::Estimate;
use crate::outcome::folder::ResultFolder;
use crate::outcome::input::Input;
use crate::outcome::provenance::VERSION;
use crate::outcome::run::Run as Record;
use crate::outcome::{FLEET_REPORT_FILE, Outcome, Part, RESULT_FILE};
use crate::report;
use crate::verb::inputs;
use std::io::Write;
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread::available_parallelism;
use std::time::{Duration, Instant};

pub fn run(query: &FleetRun) -> Result<u8, CliError> {
    let started = Instant::now();
    output::set_threads(query.threads)?;
    let name = query
        .manifest
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    let target = query
        .out
        .clone()
        .unwrap_or_else(|| Path::new("results").join(&name).join("fleet"));
    if query.shard.is_none() {
        output::writable(target.clone())?;
    }
    let items = query.items.clone().unwrap_or_else(|| beside(&target));
    let settings = settings(query);
    let interrupt = interrupt::flag();
    let progress = Progress::new(query.printing);
    let ran = task::run(
        &query.manifest,
        &items,
        &settings,
        Arc::clone(&interrupt),
        |counts| {
            progress.say(format!(
                "{} items, {} of them worked on now",
                counts.items, counts.now
            ));
        },
    )?;
    progress.say("writing the table");
    let Some(results) = ran.results else {
        progress.done();
        say(query, &counted(ran.counts, &items))?;
        return Ok(match interrupt.load(Ordering::Relaxed) {
            true => CliError::INTERRUPTED,
            false => 0,
        });
    };
    let outcome = outcome(query, name, &results, started)?;
    write(query, &target, &outcome, &results, || progress.done())?;
    say(query, &counted(ran.counts, &items))?;
    Ok(0)
}

/// The folder of items where none is given.
fn beside(target: &Path) -> PathBuf {
    let mut folder = target.to_path_buf();
    folder.as_mut_os_string().push(".items");
    folder
}

fn settings(query: &FleetRun) -> Settings {
    let all = || available_parallelism().map_or(1, NonZero::get);
    Settings {
        shard: query.shard,
        set: query.set.clone(),
        threads: query.threads.map_or_else(all, usize::from),
        timeout: Duration::from_secs_f64(query.timeout),
        retries: query.retries,
        again: query.again,
        rate: query.rate,
        max_rows: query
            .max_rows
            .map(|rows| usize::try_from(rows).unwrap_or(usize::MAX)),
        inputs: inputs::of_recordings,
    }
}

fn counted(counts: Counts, items: &Path) -> String {
    let Counts {
        items: all,
        now,
        unready,
        set_aside,
    } = counts;
    format!(
        "{all} items: {now} worked on, {} done before, {set_aside} set aside; results are kept in {}",
        all - now - unready,
        items.display()
    )
}

fn say(query: &FleetRun, text: &str) -> Result<(), CliError> {
    match query.printing.quiet || query.printing.json {
        true => Ok(()),
        false => output::print(text),
    }
}

fn outcome(
    query: &FleetRun,
    name: String,
    results: &Results,
    started: Instant,
) -> Result<Outcome, CliError> {
    let mut fleet = results.fleet.clone();
    fleet.files = [TABLE_FILE, FLEET_REPORT_FILE].map(str::to_string).to_vec();
    Ok(Outcome {
        name,
        run: Record {
            version: VERSION.to_string(),
            seed: 0,
            problem: serde_json::json!({
                "manifest": query.manifest, "rate": query.rate, "set": query.set,
                "timeout": query.timeout, "retries": query.retries,
            }),
            inputs: vec![Input::of(&query.manifest)?],
            wall_s: started.elapsed().as_secs_f64(),
            provenance: output::provenance(),
        },
        mistakes: Vec::new(),
        estimate: Estimate::default(),
        part: Part::Fleet(Box::new(fleet)),
    })
}

/// Writes the folder and prints what the run asks for.
fn write(
    query: &FleetRun,
    target: &Path,
    outcome: &Outcome,
    results: &Results,
    written: impl FnOnce(),
) -> Result<(), CliError> {
    let folder = ResultFolder::prepare(target)?;
    let json = outcome.to_json()?;
    folder.write(RESULT_FILE, |out| out.write_all(json.as_bytes()))?;
    let mut failed: Option<FleetError> = None;
    folder
        .write(TABLE_FILE, |out| {
            results.write_table(out).map_err(|error| {
                let text = error.to_string();
                failed = Some(error);
                std::io::Error::other(text)
            })
        })
        .map_err(|error| failed.take().map_or(CliError::from(error), CliError::from))?;
    let html = report::render(folder.path())?;
    folder.write(FLEET_REPORT_FILE, |out| out.write_all(html.as_bytes()))?;
    folder.commit()?;
    written();
    if query.printing.json {
        output::print(&json)
    } else if !query.printing.quiet {
        let report = target.join(FLEET_REPORT_FILE);
        output::print(&report::text::summary(outcome, Some(&report)))
    } else {
        Ok(())
    }
}
