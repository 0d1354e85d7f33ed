//! Fits of effects of the vocabulary and of the same laws as a user writes them, `laws/vocabulary/own_versions.toml`: the whole of
//! `exid fit` on a seven-joint arm with the effect in five joints, six periods of 12 s at 200 Hz.

#[path = "../tests/common/own_versions.rs"]
mod own_versions;

mod common;

use common::{exid, folder_with_arm};
use criterion::{Criterion, criterion_group, criterion_main};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// Joints with the effect: those whose range has zero in its middle, where places of the truths are passed.
const JOINTS: [usize; 5] = [1, 2, 3, 5, 7];

/// What is declared beside the effect.
const FRICTION: [&str; 2] = ["coulomb_friction", "viscous_friction"];

/// The arm with friction, of which `id` is a part or beside which it is; `written` is what takes its place.
fn problem(id: &str, written: &str, tables: &str) -> String {
    let mut effects = FRICTION.to_vec();
    effects.retain(|one| *one != id);
    effects.push(written);
    let of = |j: usize| format!("joint{j} = {effects:?}\n");
    let effects_of: String = JOINTS.map(of).concat();
    let laws = Path::new(env!("CARGO_MANIFEST_DIR")).join("laws/vocabulary/own_versions.toml");
    format!(
        "name = \"seven_joints\"\nlaws = [{laws:?}]\n[robot]\nmdh = \"panda_like.mdh.toml\"\n[drive]\n\
         effects = {FRICTION:?}\nrotor_inertia = [0.6, 0.6, 0.5, 0.5, 0.2, 0.2, 0.15]\n[drive.effects_of]\n{effects_of}\
         [recordings]\nsignal = \"torque\"\nrate = 200.0\nperiod = 12.0\n{tables}"
    )
}

/// A folder with a recording of the arm with an effect, and the problem files `vocabulary.toml` and `own.toml`.
fn recorded(id: &str, truth: &[(&str, f64)]) -> TempDir {
    let folder = folder_with_arm();
    let at = folder.path();
    let friction: String = (1..=7)
        .map(|j| format!("\"joint{j}.Fc\" = 1.0\n\"joint{j}.Fv\" = 1.0\n"))
        .collect();
    let of = |j: usize| -> String {
        let line = |(name, value): &(&str, f64)| format!("\"joint{j}.{id}.{name}\" = {value:?}\n");
        truth.iter().map(line).collect()
    };
    let values = friction + &JOINTS.map(of).concat();
    let simulate = format!(
        "train = [\"train.csv\"]\n[simulate]\ntrajectory = \"random\"\nperiods = 6\nnoise = [0.3, 0.3, 0.3, 0.3, 0.1, 0.1, 0.1]\n[simulate.values]\n{values}"
    );
    let own = format!("own_{id}");
    let recordings = "train = [\"made/train.csv\"]\n";
    for (name, written, tables) in [
        ("truth.toml", id, simulate.as_str()),
        ("vocabulary.toml", id, recordings),
        ("own.toml", own.as_str(), recordings),
    ] {
        fs::write(at.join(name), problem(id, written, tables)).expect("a problem file");
    }
    exid(
        at,
        &["simulate", "truth.toml", "--seed", "1", "--out", "made"],
    );
    folder
}

fn own_laws(criterion: &mut Criterion) {
    for (id, truth) in own_versions::TRUTHS {
        let folder = recorded(id, truth);
        let mut group = criterion.benchmark_group(*id);
        group.sample_size(10);
        for of in ["vocabulary", "own"] {
            let file = format!("{of}.toml");
            let fit = || exid(folder.path(), &["fit", &file]);
            group.bench_function(of, |bencher| bencher.iter(fit));
        }
        group.finish();
    }
}

criterion_group!(benches, own_laws);
criterion_main!(benches);
