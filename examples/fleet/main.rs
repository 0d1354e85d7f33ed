//! Does a fleet's report name the robots that have changed? A simulated fleet of three types, one robot in twenty with one
//! planted change at a random night, worked through as `exid fleet` does and reported after every night.
//!
//! | change | size |
//! |---|---|
//! | friction up | Coulomb friction of one joint by 20 to 60 % |
//! | efficiency down | of one gear by 0.03 to 0.08 |
//! | load left on | 0.2 to 0.8 kg on the tool |
//! | encoder offset | 0.01 to 0.03 rad of one joint that bears gravity |
//! | delay | of one joint by 2 to 6 ms |
//!
//! Robots of a type differ in friction, efficiency, offsets, delay and tool, and each of them from night to night.
//!
//!     cargo run --release --example fleet -- FOLDER [ROBOTS [NIGHTS [SEED]]]
//!
//! writes the fleet to FOLDER (robot files, problems, recordings of 20 s at 100 Hz, `manifest.csv`, `truth.csv`; 100 robots
//! 20 nights and seed 1), works through it, and prints the figures. A folder with the same fleet is taken as it is; items
//! that are done are not done again. `engines.py` beside this file works through the same folder with kills and on Dask.

mod figures;
mod plant;
mod robots;

use crate::figures::Reported;
use crate::plant::{Draw, Fleet};
use exid::fleet::task::{self, Settings};
use exid::verb::inputs;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Anything that goes wrong ends the program.
pub type Outcome<T> = Result<T, Box<dyn Error + Send + Sync>>;

/// Rate of false discoveries.
const RATE: f64 = 0.05;

fn main() -> Outcome<()> {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(arguments.next().ok_or("give a folder")?);
    let robots = arguments.next().map_or(Ok(100), |n| n.parse())?;
    let nights = arguments.next().map_or(Ok(20), |n| n.parse())?;
    let seed = arguments.next().map_or(Ok(1), |n| n.parse())?;
    let fleet = Fleet::draw(Draw {
        robots,
        nights,
        seed,
    });
    let started = Instant::now();
    if !fleet.is_in(&folder)? {
        fleet.write(&folder)?;
        println!("written in {:.1} s", started.elapsed().as_secs_f64());
    }
    let started = Instant::now();
    let whole = report(&folder, "manifest.csv")?;
    let seconds = started.elapsed().as_secs_f64();
    let worked = whole.counts.now;
    println!(
        "{} items, {worked} worked on in {seconds:.1} s: {:.1} a second and core",
        whole.counts.items,
        worked as f64 / seconds / settings().threads as f64
    );
    let mut reports = Vec::new();
    for night in 1..=nights {
        let manifest = fleet.manifest_until(&folder, night)?;
        let ran = report(&folder, &manifest)?;
        let fleet = ran.results.ok_or("interrupted")?.fleet;
        reports.push(Reported { night, fleet });
    }
    figures::print(&fleet, &reports);
    figures::first_nights(&fleet, &folder, &settings())?;
    Ok(())
}

fn settings() -> Settings {
    Settings {
        shard: None,
        set: Vec::new(),
        threads: std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
        timeout: Duration::from_secs(60),
        retries: 1,
        again: false,
        rate: RATE,
        max_rows: None,
        inputs: inputs::of_recordings,
    }
}

fn report(folder: &Path, manifest: &str) -> Outcome<task::FinishedFleet> {
    let items = folder.join("items");
    Ok(task::run(
        &folder.join(manifest),
        &items,
        &settings(),
        Arc::default(),
        |_| (),
    )?)
}
