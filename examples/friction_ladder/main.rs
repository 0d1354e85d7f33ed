//! Does the right friction law win? A simulated seven-joint arm with each of four laws in turn as the truth, fitted by
//! all of them and judged on another motion.
//!
//! | truth | law |
//! |---|---|
//! | Coulomb-viscous | Fc·sign(v) + Fv·v |
//! | Stribeck | and Fs·exp(−(v/vs)²)·sign(v) |
//! | LuGre | bristles of stiffness sigma0 in the place of Coulomb friction, beside Fv·v |
//! | sigmoid | psi1/(1 + exp(−psi2·(v + psi3))) less its value at rest, and Fv·v |
//!
//! Coulomb-viscous friction is Stribeck friction with Fs = 0: there the right answer is that the recordings cannot
//! tell, or that the simpler law predicts better by what the other one spends on parameters. The arm, the noise and the
//! settings of the fit are those of `problems/panda_friction`.
//!
//!     cargo run --release --example friction_ladder [SEEDS]
//!
//! writes `ladder.md` to `results/panda_friction/` (50 seeds).

mod law;
mod table;
mod trial;

use crate::law::LAWS;
use crate::trial::Trial;
use rayon::prelude::*;
use std::error::Error;
use std::fs;
use std::path::Path;

/// Anything that goes wrong ends the program.
pub type Outcome<T> = Result<T, Box<dyn Error + Send + Sync>>;

/// Seeds of each truth where none are asked for.
const SEEDS: u64 = 50;

fn main() -> Outcome<()> {
    let asked = std::env::args().nth(1);
    let seeds = asked.map_or(Ok(SEEDS), |s| s.parse())?;
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let problem = root.join("problems/panda_friction/problem.toml");
    let folder = std::env::temp_dir().join(format!("exid-ladder-{}", std::process::id()));
    fs::create_dir_all(&folder)?;
    let runs: Vec<(usize, u64)> = (0..LAWS.len())
        .flat_map(|truth| (0..seeds).map(move |seed| (truth, seed)))
        .collect();
    let trials: Vec<Trial> = runs
        .into_par_iter()
        .map(|(truth, seed)| trial::run(&problem, &folder, (truth, seed)))
        .collect::<Outcome<_>>()?;
    fs::remove_dir_all(&folder)?;
    let page = table::page(&trials, seeds);
    print!("{page}");
    let results = root.join("results/panda_friction");
    fs::create_dir_all(&results)?;
    fs::write(results.join("ladder.md"), page)?;
    Ok(())
}
