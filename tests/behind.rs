//! What lies behind what: friction on the link's side of an elastic gear with play, and a slider behind a hardening spring, by the
//! shipped laws. Recovered where they are simulated, named by a diagnosis, and held against a real damper whose friction lies behind its linkage.

mod common;

use common::derivatives::{Columns, Sines};
use exid::chain::effect::ids;
use exid::diagnose::task as diagnose;
use exid::estimate::task as fit;
use exid::outcome::finding::Finding;
use exid::problem::solution::Control;
use exid::problem_file::ProblemFile;
use exid::setup;
use exid::setup::model_spec::ModelSpec;
use exid::simulate::{self, write_csv};
use std::fs::{self, File};
use std::path::Path;
use tempfile::TempDir;

struct Arm(TempDir);

/// Values of the truth at the elbow.
type Values<'a> = &'a [(&'a str, f64)];

const GEAR: Values<'static> = &[
    ("joint_elasticity.K", 200.0),
    ("joint_elasticity.D", 1.0),
    ("coulomb_friction.Fc", 0.6),
    ("viscous_friction.Fv", 0.4),
    ("rotor_inertia.Jm", 0.2),
];
const LINK: Values<'static> = &[("link_friction.Fc", 1.2), ("link_friction.Fv", 0.8)];
const PLAY: Values<'static> = &[("backlash.gap", 0.01)];

impl Arm {
    fn new() -> Self {
        let arm = Self(tempfile::tempdir().unwrap());
        fs::write(arm.0.path().join("arm.urdf"), common::arm::URDF).unwrap();
        arm
    }

    fn read(&self, elbow: &[&str], truth: &[Values<'_>]) -> ProblemFile {
        self.knowing(&[], elbow, truth)
    }

    /// The problem with known values, effects of the elbow and values of the truth.
    fn knowing(&self, known: Values<'_>, elbow: &[&str], truth: &[Values<'_>]) -> ProblemFile {
        let of_elbow = |(name, value): &(&str, f64)| format!("\"elbow.{name}\" = {value:?}\n");
        let values: String = truth.iter().copied().flatten().map(of_elbow).collect();
        let known: String = known.iter().map(of_elbow).collect();
        let laws = [Path::new(env!("CARGO_MANIFEST_DIR")).join("laws/link_friction.toml")];
        let text = format!(
            "name = \"arm\"\nlaws = {laws:?}\n[robot]\nurdf = \"arm.urdf\"\ninertials = \"known\"\n[drive]\n\
             torque_constant = [12.0, 8.0]\neffects = [\"coulomb_friction\", \"viscous_friction\", \"rotor_inertia\"]\n\
             [drive.effects_of]\nelbow = {elbow:?}\n[drive.values]\n{known}[recordings]\ntrain = [\"train.csv\"]\nvalidation = [\"validation.csv\"]\n\
             signal = \"current\"\nrate = 400.0\nperiod = 4.0\n[design]\nperiod = 4.0\n[simulate]\ntrajectory = \"random\"\n\
             mode = \"inverse\"\nperiods = 3\nnoise = [0.02, 0.02]\nencoder_counts = 524288\n[simulate.values]\n\
             \"shoulder.Fc\" = 3.0\n\"shoulder.Fv\" = 2.0\n\"shoulder.Jm\" = 0.5\n{values}"
        );
        let path = self.0.path().join("problem.toml");
        ProblemFile::parse(&path, &text, &[], &ids()).unwrap()
    }

    fn simulate(&self, truth: &[Values<'_>], seed: u64) {
        let problem = self.read(MOTOR, truth);
        let made = simulate::run(&problem, seed, &Control::default()).unwrap();
        for recording in &made.recordings {
            let file = File::create(self.0.path().join(&recording.name)).unwrap();
            write_csv(file, recording).unwrap();
        }
    }
}

const MOTOR: &[&str] = &["coulomb_friction", "viscous_friction", "rotor_inertia"];

fn with<'a>(more: &[&'a str]) -> Vec<&'a str> {
    MOTOR.iter().chain(more).copied().collect()
}

#[test]
fn recovers_known_friction_behind_a_spring_and_behind_play() {
    let (sizes, frictions) = GEAR.split_at(2);
    // The spring is looked for from nothing; with play beside it the gear is known.
    let all = [GEAR, LINK].concat();
    let behind_play = [frictions, LINK].concat();
    let gear = [sizes, PLAY].concat();
    let cases: [(&[&str], Values<'_>, Values<'_>); 2] = [
        (&["joint_elasticity", "link_friction"], &[], &all),
        (
            &["joint_elasticity", "link_friction", "backlash"],
            &gear,
            &behind_play,
        ),
    ];
    for (more, known, sought) in cases {
        let arm = Arm::new();
        arm.simulate(&[sought, known], 11);
        let problem = arm.knowing(known, &with(more), &[]);
        let run = fit::run(&problem, &Control::default(), |_| ()).unwrap();
        for (name, value) in sought {
            let found = run.fitted.estimate.find(&format!("elbow.{name}")).unwrap();
            let (estimate, deviation) = (found.value.unwrap(), found.std_dev.unwrap());
            println!("{name} {value}: {estimate:.4} ± {deviation:.4}");
            assert!(deviation <= 0.1 * value, "{name}: {estimate} ± {deviation}");
            let error = (estimate - value).abs();
            // Four deviations for a dozen numbers, and what differentiation of positions leaves: 3 %.
            assert!(
                error <= 4.0 * deviation + 0.03 * value,
                "{name}: {estimate} ± {deviation} for {value}"
            );
        }
    }
}

#[test]
fn a_diagnosis_names_friction_behind_the_spring() {
    for seed in [11, 12] {
        let arm = Arm::new();
        arm.simulate(&[GEAR, LINK], seed);
        let declared = with(&["joint_elasticity"]);
        let run = diagnose::run(&arm.read(&declared, &[]), &Control::default(), &|_| ()).unwrap();
        let findings = &run.diagnosis.findings;
        let is_named = |f: &Finding| f.effect == "link_friction" && f.joints == ["elbow"];
        assert!(
            findings.first().is_some_and(is_named),
            "{}",
            run.diagnosis.summary
        );
        assert_eq!(findings.len(), 1, "{}", run.diagnosis.summary);
    }
}

#[test]
fn invariant_columns_through_a_link_that_sticks_are_derivatives() {
    let arm = Arm::new();
    for play in [&[][..], &["backlash"][..]] {
        let effects = with(&[&["joint_elasticity", "link_friction"], play].concat());
        let problem = arm.read(&effects, &[]);
        let robot = setup::robot::open(&problem).unwrap();
        let model = ModelSpec::without_prior(&problem, &robot)
            .unwrap()
            .build()
            .unwrap()
            .model;
        let mut values = model.generic_values();
        for (name, value) in [GEAR, LINK, PLAY].into_iter().flatten() {
            if let Ok(at) = model.find(&format!("elbow.{name}")) {
                values[at] = *value;
            }
        }
        values[model.find("elbow.coulomb_friction.w").unwrap()] = 0.05;
        let columns: Vec<usize> = (0..model.parameters().len())
            .filter(|&p| model.parameters()[p].name.starts_with("elbow."))
            .collect();
        let motion = Sines {
            amplitude: 0.5,
            rates: &[5.0, 7.0],
            samples: 400,
            rate_hz: 400.0,
        };
        let own = Columns {
            model: &model,
            values: &values,
            parameters: &columns,
            step: 1e-6,
            least: 1e-3,
            tolerance: 1e-3,
        };
        own.assert_derivatives_along(&motion);
    }
}

/// The damper of the public recordings: fitted on sines, held out on earthquakes.
fn damper(folder: &Path, (data, held_out): (&Path, &[&str]), effects: &str) -> ProblemFile {
    let data = data.join("data/damper");
    let file = |name: &&str| data.join(name).display().to_string();
    let laws = Path::new(env!("CARGO_MANIFEST_DIR")).join("laws");
    let laws =
        ["slider_behind_spring.toml", "dahl.toml", "hose_windup.toml"].map(|file| laws.join(file));
    let sines = [
        "sine_0.25hz_38mm.csv",
        "sine_0.5hz_25mm.csv",
        "sine_1hz_13mm.csv",
    ];
    let held_out: Vec<String> = held_out.iter().map(file).collect();
    let text = format!(
        "name = \"damper\"\nlaws = {laws:?}\n[robot]\nurdf = {:?}\ninertials = \"known\"\n[drive]\neffects = [{effects}]\n\
         [recordings]\ntrain = {:?}\nvalidation = {held_out:?}\nsignal = \"torque\"\n[fit]\nestimator = \"wls\"\n",
        file(&"rig.urdf"),
        sines.each_ref().map(file),
    );
    ProblemFile::parse(&folder.join("problem.toml"), &text, &[], &ids()).unwrap()
}

/// RMS error of raw forces on the two earthquakes, N, of a slider behind a spring that was fitted by hand.
const BY_HAND: [(&str, f64); 2] = [("imperial_valley.csv", 1580.0), ("kocaeli.csv", 1910.0)];

#[test]
fn a_real_damper_is_forecast_at_least_as_well_as_by_hand() {
    let Some(data) = common::data_dir() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    for (name, by_hand) in BY_HAND {
        let problem = damper(folder.path(), (&data, &[name]), "\"slider_behind_spring\"");
        let run = fit::run(&problem, &Control::default(), |_| ()).unwrap();
        let error = run.fitted.estimate.joints[0].rmse_validation_raw.unwrap();
        println!("{name}: {error:.0} N, by hand {by_hand} N");
        assert!(error <= by_hand, "{name}: {error}");
    }
}
