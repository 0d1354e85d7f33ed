//! The whole of `exid diagnose` on a seven-joint arm: every hypothesis on every joint, six periods of 12 s at 200 Hz
//! to fit and as many held out. Nothing, a gear that loses torque, a gear that twists, a gear with play, an excess of dry
//! friction at low speed in every joint, or the losses of six gears and a delay are left out of the declared model; with nothing
//! left out also twice as many periods, to see how the time grows with samples.

mod common;

use common::{exid, folder_with_arm};
use criterion::{Criterion, criterion_group, criterion_main};
use std::fs;
use std::ops::RangeInclusive;
use tempfile::TempDir;

const JOINTS: usize = 7;

/// An effect that is left out of the declared model.
struct LeftOut {
    id: &'static str,
    /// Joints, by their numbers.
    joints: RangeInclusive<usize>,
    /// Its parameters there.
    values: &'static [(&'static str, f64)],
}

const LOSS: LeftOut = LeftOut {
    id: "transmission_efficiency",
    joints: 4..=4,
    values: &[("R", 0.85)],
};

const TWIST: LeftOut = LeftOut {
    id: "joint_elasticity",
    joints: 2..=2,
    values: &[("K", 8000.0), ("D", 8.0)],
};

const PLAY: LeftOut = LeftOut {
    id: "backlash",
    joints: 4..=4,
    values: &[("gap", 0.004)],
};

const EXCESS: LeftOut = LeftOut {
    id: "stribeck_friction",
    joints: 1..=JOINTS,
    values: &[("Fs", 1.0), ("vs", 0.1)],
};

const LOSSES: LeftOut = LeftOut {
    joints: 1..=6,
    ..LOSS
};

const DELAY: LeftOut = LeftOut {
    id: "time_delay",
    joints: 1..=JOINTS,
    values: &[("delay", 0.006)],
};

/// `[drive.effects_of]` with what is left out.
fn effects_of(left_out: &[LeftOut]) -> String {
    let of = |joint: usize| {
        let own = left_out.iter().filter(|one| one.joints.contains(&joint));
        let own: String = own.map(|one| format!(", \"{}\"", one.id)).collect();
        format!("joint{joint} = [\"coulomb_friction\", \"viscous_friction\"{own}]\n")
    };
    (1..=JOINTS).map(of).collect()
}

/// `[simulate.values]` of what is left out.
fn values_of(left_out: &[LeftOut]) -> String {
    let of = |one: &LeftOut| -> String {
        let at = |joint: usize| -> String {
            let line = |(name, value): &(&str, f64)| {
                format!("\"joint{joint}.{}.{name}\" = {value:?}\n", one.id)
            };
            one.values.iter().map(line).collect()
        };
        one.joints.clone().map(at).collect()
    };
    left_out.iter().map(of).collect()
}

/// The arm; `tables` follow.
fn problem(effects: &str, tables: &str) -> String {
    let friction: String = (1..=JOINTS)
        .map(|j| format!("\"joint{j}.coulomb_friction.w\" = 0.01\n"))
        .collect();
    format!(
        "name = \"seven_joints\"\n[robot]\nmdh = \"panda_like.mdh.toml\"\n[drive]\n\
         effects = [\"coulomb_friction\", \"viscous_friction\"]\n\
         rotor_inertia = [0.6, 0.6, 0.5, 0.5, 0.2, 0.2, 0.15]\n[drive.values]\n{friction}\
         [drive.effects_of]\n{effects}\n[recordings]\nsignal = \"torque\"\nrate = 200.0\nperiod = 12.0\n{tables}"
    )
}

/// What is recorded.
fn truth(left_out: &[LeftOut], periods: usize) -> String {
    let values = values_of(left_out);
    let friction: String = (1..=JOINTS)
        .map(|j| format!("\"joint{j}.Fc\" = 1.{j}\n\"joint{j}.Fv\" = 1.{j}\n"))
        .collect();
    let simulate = format!(
        "train = [\"train.csv\"]\n[simulate]\ntrajectory = \"random\"\nperiods = {periods}\n\
         noise = [0.3, 0.3, 0.3, 0.3, 0.1, 0.1, 0.1]\n[simulate.values]\n{friction}{values}\n"
    );
    problem(&effects_of(left_out), &simulate)
}

/// A folder with recordings and the declared model.
fn recorded(left_out: &[LeftOut], periods: usize) -> TempDir {
    let folder = folder_with_arm();
    let at = folder.path();
    fs::write(at.join("truth.toml"), truth(left_out, periods)).expect("a problem file");
    let files = "train = [\"1/train.csv\"]\nvalidation = [\"2/train.csv\"]\n";
    fs::write(at.join("declared.toml"), problem("", files)).expect("a problem file");
    for seed in ["1", "2"] {
        exid(
            at,
            &["simulate", "truth.toml", "--seed", seed, "--out", seed],
        );
    }
    folder
}

fn diagnosis(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("diagnosis");
    group.sample_size(10);
    let mut measure = |name: &str, left_out: &[LeftOut], periods: usize| {
        let folder = recorded(left_out, periods);
        let diagnose = || exid(folder.path(), &["diagnose", "declared.toml"]);
        group.bench_function(name, |bencher| bencher.iter(diagnose));
    };
    measure("nothing", &[], 6);
    measure("nothing, 12 periods", &[], 12);
    measure(LOSS.id, &[LOSS], 6);
    measure(TWIST.id, &[TWIST], 6);
    measure(PLAY.id, &[PLAY], 6);
    measure("stribeck_friction of seven joints", &[EXCESS], 6);
    measure(
        "transmission_efficiency of six joints and time_delay",
        &[LOSSES, DELAY],
        6,
    );
    group.finish();
}

criterion_group!(benches, diagnosis);
criterion_main!(benches);
