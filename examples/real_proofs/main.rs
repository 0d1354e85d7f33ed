//! Diagnosis of recordings of real robots from which one effect is concealed by leaving it out of the declared model.
//!
//! | recording | left out |
//! |---|---|
//! | UR10e, without load | friction that grows with the load |
//! | UR10e, with a load, links known from the runs without | the load |
//! | TX40, positions and torques joint by joint | the coupling of the wrist |
//! | EMPS | the dependence of friction on the direction of motion |
//! | EMPS | all friction |
//!
//! The recordings are public and do not ship; they are looked for in the folder `EXID_DATA` (default `../shared`).
//!
//!     cargo run --release --example real_proofs
//!
//! prints the page and writes it to `results/real_proofs/README.md`.

mod page;
mod recordings;

use exid::chain::effect;
use exid::diagnose::task::{self, DiagnoseRun};
use exid::estimate;
use exid::outcome::folder::ResultFolder;
use exid::outcome::provenance::Provenance;
use exid::outcome::provenance::VERSION;
use exid::outcome::run::Run;
use exid::outcome::{Outcome, Part, RESULT_FILE};
use exid::problem::solution::Control;
use exid::problem_file::ProblemFile;
use std::error::Error;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Anything that goes wrong ends the program.
pub type Done<T> = Result<T, Box<dyn Error>>;

/// One proof: what is left out, and what was found by hand.
pub struct Proof {
    pub name: &'static str,
    pub left_out: &'static str,
    pub problem: &'static str,
    pub by_hand: &'static str,
}

const PROOFS: [Proof; 5] = [
    Proof {
        name: "UR10e without load",
        left_out: "friction that grows with the load",
        problem: include_str!("ur10e.toml"),
        by_hand: "friction that grows with the transmitted load on joints 2 and 3, 0.06 to 0.08 N·m per N·m; \
                  held-out error 0.59 to 0.74 and 0.55 to 0.67 of that without",
    },
    Proof {
        name: "UR10e with a load",
        left_out: "the load",
        problem: include_str!("ur10e_load.toml"),
        by_hand: "3.09 kg with the declared torque constants; ignoring the load leaves 24.9 and 13.3 N·m on joints 2 and 3",
    },
    Proof {
        name: "TX40",
        left_out: "the coupling of the wrist",
        problem: include_str!("tx40.toml"),
        by_hand: "motor 6 turns with joint 5 plus joint 6",
    },
    Proof {
        name: "EMPS",
        left_out: "the dependence of friction on the direction",
        problem: include_str!("emps.toml"),
        by_hand: "viscous friction that depends on the direction: 1.722 to 0.857 N, fitted on the first half and tested on the second",
    },
    Proof {
        name: "EMPS",
        left_out: "all friction",
        problem: include_str!("emps_frictionless.toml"),
        by_hand: "Coulomb and viscous friction: 1.722 N; with the direction 0.857 N",
    },
];

fn main() -> Done<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let shared = std::env::var_os("EXID_DATA").map_or(PathBuf::from("../shared"), PathBuf::from);
    let data = root.join(shared).join("data");
    let data = data.canonicalize().map_err(|_| {
        format!(
            "no recordings in {}: set EXID_DATA to the folder that holds data/",
            data.display()
        )
    })?;
    let folder = std::env::temp_dir().join(format!("exid-proofs-{}", std::process::id()));
    fs::create_dir_all(&folder)?;
    let done = prove_all(&data, &folder);
    fs::remove_dir_all(&folder)?;
    let page = page::page(&done?);
    print!("{page}");
    let results = root.join("results/real_proofs");
    fs::create_dir_all(&results)?;
    fs::write(results.join("README.md"), page)?;
    Ok(())
}

fn prove_all(data: &Path, folder: &Path) -> Done<Vec<(&'static Proof, DiagnoseRun)>> {
    recordings::write(data, folder)?;
    fs::write(folder.join("robot.urdf"), include_str!("emps.urdf"))?;
    fit_links(data, folder)?;
    let prove = |proof: &'static Proof| {
        let problem = opened(proof.problem, data, &folder.join("problem.toml"))?;
        let run = task::run(&problem, &Control::default(), &|_| ())?;
        Ok((proof, run))
    };
    PROOFS.iter().map(prove).collect()
}

/// A problem with the folder of the recordings filled in.
fn opened(problem: &str, data: &Path, file: &Path) -> Done<ProblemFile> {
    let problem = problem.replace("{data}", &data.to_string_lossy());
    fs::write(file, problem)?;
    Ok(ProblemFile::read(file, &[], &effect::ids())?)
}

/// The links of the UR10e from its runs without load, as a result that other problems read.
fn fit_links(data: &Path, folder: &Path) -> Done<()> {
    let file = folder.join("problem.toml");
    let problem = opened(include_str!("ur10e_links.toml"), data, &file)?;
    let run = estimate::task::run(&problem, &Control::default(), |_| ())?;
    let outcome = Outcome {
        name: problem.name.value.clone(),
        run: Run {
            version: VERSION.to_string(),
            seed: 0,
            problem: problem.json.clone(),
            inputs: Vec::new(),
            wall_s: 0.0,
            provenance: Provenance::default(),
        },
        mistakes: Vec::new(),
        estimate: run.fitted.estimate,
        part: Part::Fit(run.fitted.fit),
    };
    let results = ResultFolder::prepare(&folder.join("links"))?;
    let json = outcome.to_json()?;
    results.write(RESULT_FILE, |out| out.write_all(json.as_bytes()))?;
    results.commit()?;
    Ok(())
}
