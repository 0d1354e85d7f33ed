//! What a law costs that is written as a formula: effects of the vocabulary beside their versions in
//! `laws/vocabulary/own_versions.toml`, fitted to the same recordings of two joints in turn.
//!
//! `cargo run --release --example own_laws` prints for every effect the seconds of both fits, each the least of nine, and their
//! quotient.

#[path = "../tests/common/own_versions.rs"]
mod own_versions;

use exid::chain::effect::ids;
use exid::estimate::task;
use exid::problem::solution::Control;
use exid::problem_file::ProblemFile;
use exid::simulate::{self, write_csv};
use std::error::Error;
use std::fs::{self, File};
use std::path::Path;
use std::time::Instant;

/// Fits of either kind.
const TIMES: usize = 9;

const ARM: &str = r#"<robot name="arm"><link name="base"/>
<link name="upper"><inertial><origin xyz="0.2 0.01 0"/><mass value="4"/>
<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.06" iyz="0" izz="0.06"/></inertial></link>
<link name="fore"><inertial><origin xyz="0.15 0 0.02"/><mass value="2"/>
<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" velocity="4" effort="100"/></joint>
<joint name="elbow" type="revolute"><origin xyz="0.4 0 0"/><parent link="upper"/><child link="fore"/><axis xyz="0 1 0"/>
<limit lower="-2.5" upper="2.5" velocity="4" effort="50"/></joint></robot>"#;

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let laws = fs::read_to_string(root.join("laws/vocabulary/own_versions.toml"))?;
    println!("{:<28} {:>9} {:>9} {:>7}", "effect", "ours", "own", "times");
    for (id, truth) in own_versions::TRUTHS {
        let folder = tempfile::tempdir()?;
        fs::write(folder.path().join("arm.urdf"), ARM)?;
        let read = |effect: &str, laws: &str| {
            let text = problem(&Elbow { effect, id, truth }, laws);
            ProblemFile::parse(&folder.path().join("arm.toml"), &text, &[], &ids())
        };
        let control = Control::default();
        let made = simulate::run(&read("", "")?, 5, &control)?;
        for recording in &made.recordings {
            write_csv(
                File::create(folder.path().join(&recording.name))?,
                recording,
            )?;
        }
        let both = [read(id, "")?, read(&format!("own_{id}"), &laws)?];
        let mut least = [f64::INFINITY; 2];
        for _ in 0..TIMES {
            for (problem, least) in both.iter().zip(&mut least) {
                let started = Instant::now();
                task::run(problem, &control, |_| ())?;
                *least = least.min(started.elapsed().as_secs_f64());
            }
        }
        let [ours, own] = least;
        println!("{id:<28} {ours:>9.4} {own:>9.4} {:>7.2}", own / ours);
    }
    Ok(())
}

/// The second joint: an effect that is fitted, the one that is the truth, and its values.
struct Elbow<'a> {
    effect: &'a str,
    id: &'a str,
    truth: &'a [(&'a str, f64)],
}

fn problem(elbow: &Elbow<'_>, laws: &str) -> String {
    let mut effects = vec!["coulomb_friction", "viscous_friction"];
    if elbow.truth.is_empty() && !elbow.effect.is_empty() {
        effects.retain(|other| *other != elbow.id);
    }
    if !elbow.effect.is_empty() {
        effects.push(elbow.effect);
    }
    let values = elbow.truth.iter();
    let values = values.map(|(name, value)| format!("\"elbow.{}.{name}\" = {value:?}\n", elbow.id));
    format!(
        "name = \"arm\"\n[robot]\nurdf = \"arm.urdf\"\ninertials = \"known\"\n[drive]\ntorque_constant = [12.0, 8.0]\n\
         effects = [\"coulomb_friction\", \"viscous_friction\"]\n[drive.effects_of]\nelbow = {effects:?}\n[recordings]\n\
         train = [\"train.csv\"]\nvalidation = [\"validation.csv\"]\nsignal = \"current\"\nrate = 200.0\n[design]\n\
         period = 4.0\n{laws}\n[simulate]\ntrajectory = \"random\"\nmode = \"inverse\"\nperiods = 5\nnoise = [0.02, 0.02]\n\
         encoder_counts = 524288\n[simulate.values]\n\"shoulder.Fc\" = 3.0\n\"shoulder.Fv\" = 2.0\n\"elbow.Fc\" = 1.2\n\
         \"elbow.Fv\" = 0.8\n{}",
        values.collect::<String>()
    )
}
