//! Tables 2 and 3 of Swevers, Verdonck, Naumer, Pieters and Biber (2002), in kind: the load of an industrial arm
//! from fourteen simulated experiments, estimated in three ways.
//!
//! | approach | model |
//! |---|---|
//! | 1 | linear: all links and rotor inertias unknown, efficiency 1; the load solved from the base parameters |
//! | 2 | maximum likelihood, links and rotors known, efficiency 1 |
//! | 3 | maximum likelihood, links and rotors known, efficiencies estimated |
//!
//! The robot, its load, its drives and the noise are those of `problems/kr150_payload`; beside them acts what no
//! model declares, gear ripple of the size that Table 3 leaves. A second picture shows how wrong the load gets on the
//! shipped recording where the model lacks a part of the drive.
//!
//!     cargo run --release --example kr150_tables
//!
//! writes `README.md`, `tables.json`, `tables.svg` and `lacking.svg` to `results/kr150_payload/`.

mod approach;
mod experiment;
mod lacking;
mod picture;
mod render;

use rayon::prelude::*;
use serde_json::json;
use std::error::Error;
use std::fs;
use std::path::Path;

/// Anything that goes wrong ends the program.
pub type Outcome<T> = Result<T, Box<dyn Error + Send + Sync>>;

/// Number of experiments of the paper.
const EXPERIMENTS: u64 = 14;

fn main() -> Outcome<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let problem = root.join("problems/kr150_payload/problem.toml");
    let folder = std::env::temp_dir().join(format!("exid-kr150-{}", std::process::id()));
    fs::create_dir_all(&folder)?;
    let experiments: Vec<experiment::Result> = (0..EXPERIMENTS)
        .into_par_iter()
        .map(|number| experiment::run(&problem, &folder, number))
        .collect::<Outcome<_>>()?;
    let lacking = lacking::fits(&problem)?;
    fs::remove_dir_all(&folder)?;
    let results = root.join("results/kr150_payload");
    fs::create_dir_all(&results)?;
    let page = render::page(&experiments, &lacking);
    print!("{page}");
    fs::write(results.join("README.md"), page)?;
    let record = json!({ "experiments": experiments, "lacking": lacking });
    fs::write(
        results.join("tables.json"),
        serde_json::to_string_pretty(&record)?,
    )?;
    picture::tables(&results.join("tables.svg"), &experiments)?;
    picture::lacking(&results.join("lacking.svg"), &lacking)?;
    Ok(())
}
