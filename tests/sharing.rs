//! Joints with motors of one type: common parameters have shorter intervals that cover the truth, motors that differ refuse
//! to have them in common, and every verb takes `[[drive.shared]]` for what it is. Robots, motions and noise are drawn anew
//! for every seed.

mod common;

use common::derivatives::{Columns, Sines};
use exid::chain::effect::{find, ids};
use exid::chain::model::{Model, ModelSettings, Signal};
use exid::chain::sharing::Sharing as Common;
use exid::diagnose::task as diagnose;
use exid::estimate::fit::Fitted;
use exid::estimate::task as fit;
use exid::outcome::sharing::Sharing;
use exid::problem::solution::Control;
use exid::problem_file::ProblemFile;
use exid::robot::random::{generator, symmetric, tree};
use exid::simulate::{self, write_csv};
use rayon::prelude::*;
use std::fmt::Write;
use std::fs::{self, File};
use tempfile::TempDir;

const JOINTS: usize = 5;
/// Robots of each kind.
const ROBOTS: u64 = 120;
/// Chance that a true sharing is refused, by the library's own statement.
const LEVEL: f64 = exid::estimate::sharing::SIGNIFICANCE;

/// A robot whose last three joints have motors of one type, or motors whose friction differs by a share.
struct Robot {
    folder: TempDir,
    seed: u64,
    /// Fc, Fv of every joint.
    friction: [[f64; 2]; JOINTS],
}

impl Robot {
    fn drawn(seed: u64, spread: f64) -> Self {
        let mut rng = generator(seed);
        let mut links = String::new();
        let mut joints = String::new();
        for j in 0..JOINTS {
            let scale = 0.6_f64.powi(j as i32);
            let mass = 6.0 * scale * (1.0 + symmetric(&mut rng, 0.3));
            let length = 0.3 + symmetric(&mut rng, 0.1);
            let moment = mass * length * length / 12.0 + 0.005;
            let (x, y) = (0.5 * length, symmetric(&mut rng, 0.03));
            let parent = if j == 0 {
                "base".to_string()
            } else {
                format!("link{j}")
            };
            let axis = ["0 0 1", "0 1 0", "1 0 0"][(j + seed as usize) % 3];
            let n = j + 1;
            write!(
                links,
                "<link name=\"link{n}\"><inertial><origin xyz=\"{x} {y} 0.01\"/><mass value=\"{mass}\"/>\
                 <inertia ixx=\"{moment}\" iyy=\"{moment}\" izz=\"{moment}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>"
            )
            .unwrap();
            write!(
                joints,
                "<joint name=\"j{n}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"link{n}\"/>\
                 <origin xyz=\"{} 0 0.05\"/><axis xyz=\"{axis}\"/>\
                 <limit lower=\"-2\" upper=\"2\" velocity=\"3\" effort=\"300\"/></joint>",
                if j == 0 { 0.0 } else { length }
            )
            .unwrap();
        }
        let folder = tempfile::tempdir().unwrap();
        let text = format!("<robot name=\"arm\"><link name=\"base\"/>{links}{joints}</robot>");
        fs::write(folder.path().join("arm.urdf"), text).unwrap();
        let mut friction = [[6.0, 8.0], [5.0, 6.0], [1.5, 2.0], [1.5, 2.0], [1.5, 2.0]];
        for (of_joint, sign) in friction[2..].iter_mut().zip([-1.0, 0.0, 1.0]) {
            of_joint.iter_mut().for_each(|x| *x *= 1.0 + sign * spread);
        }
        Self {
            folder,
            seed,
            friction,
        }
    }

    /// The problem with further tables under `[drive]` and further truth.
    fn problem(&self, drive: &str, truth: &str) -> String {
        let mut values = String::new();
        for (j, [dry, viscous]) in self.friction.iter().enumerate() {
            let n = j + 1;
            write!(
                values,
                "\"j{n}.Fc\" = {dry}\n\"j{n}.Fv\" = {viscous}\n\"j{n}.coulomb_friction.w\" = 0.02\n"
            )
            .unwrap();
        }
        format!(
            "name = \"arm\"\n[robot]\nurdf = \"arm.urdf\"\ninertials = \"estimate\"\n[drive]\n\
             effects = [\"coulomb_friction\", \"viscous_friction\"]\n{drive}\n\
             [recordings]\ntrain = [\"train.csv\"]\nvalidation = [\"validation.csv\"]\nsignal = \"torque\"\n\
             rate = 100.0\nperiod = 8.0\n[simulate]\ntrajectory = \"random\"\nmode = \"inverse\"\nperiods = 4\n\
             noise = [1.0, 1.0, 0.4, 0.4, 0.4]\n[simulate.values]\n{values}{truth}"
        )
    }

    fn read(&self, drive: &str, truth: &str) -> ProblemFile {
        let path = self.folder.path().join("problem.toml");
        ProblemFile::parse(&path, &self.problem(drive, truth), &[], &ids()).unwrap()
    }

    fn simulate(&self, drive: &str, truth: &str) {
        let problem = self.read(drive, truth);
        let made = simulate::run(&problem, self.seed, &Control::default()).unwrap();
        for recording in &made.recordings {
            let file = File::create(self.folder.path().join(&recording.name)).unwrap();
            write_csv(file, recording).unwrap();
        }
    }

    fn fit(&self, drive: &str) -> Fitted {
        let problem = self.read(drive, "");
        let run = fit::run(&problem, &Control::default(), |_| ());
        run.unwrap_or_else(|error| panic!("seed {}: {error}", self.seed))
            .fitted
    }
}

const SHARED: &str = "[[drive.shared]]\njoints = [\"j3\", \"j4\", \"j5\"]\n\
                      effects = [\"coulomb_friction\", \"viscous_friction\"]\n";
const ASKED: &str = "[[drive.shared]]\njoints = [\"j3\", \"j4\", \"j5\"]\n";

/// Fits of robots whose motors differ by a share, every joint's friction in common.
fn fits(first: u64, spread: f64) -> Vec<(Robot, Fitted)> {
    let of = |k: u64| {
        let robot = Robot::drawn(first + k, spread);
        robot.simulate("", "");
        let fitted = robot.fit(SHARED);
        (robot, fitted)
    };
    (0..ROBOTS).into_par_iter().map(of).collect()
}

fn answer<'a>(fitted: &'a Fitted, effect: &str) -> &'a Sharing {
    let mut all = fitted.fit.sharing.iter();
    all.find(|answer| answer.effect == effect).unwrap()
}

/// Three standard deviations of a share of so many draws.
fn chance(share: f64, draws: usize) -> f64 {
    3.0 * (share * (1.0 - share) / draws as f64).sqrt()
}

#[test]
fn common_parameters_have_shorter_intervals_that_cover_the_truth() {
    let fits = fits(31_000, 0.0);
    let (mut covered, mut intervals, mut refused, mut tests) = (0, 0, 0, 0);
    let mut ratios = Vec::new();
    for (robot, fitted) in &fits {
        for (effect, parameter, truth) in [
            ("coulomb_friction", "Fc", robot.friction[2][0]),
            ("viscous_friction", "Fv", robot.friction[2][1]),
        ] {
            let found = fitted
                .estimate
                .find(&format!("j3.{effect}.{parameter}"))
                .unwrap();
            assert_eq!(found.shared_by, ["j3", "j4", "j5"]);
            // Reported once, and found by the name of any of the joints.
            let other = fitted
                .estimate
                .find(&format!("j5.{effect}.{parameter}"))
                .unwrap();
            assert_eq!(found, other);
            let [low, high] = found.ci95.unwrap();
            covered += usize::from((low..=high).contains(&truth));
            intervals += 1;
            let answer = answer(fitted, effect);
            assert!(answer.in_model, "seed {}", robot.seed);
            refused += usize::from(answer.refused);
            tests += 1;
            let shared = answer
                .parameters
                .iter()
                .find(|p| p.name.ends_with(parameter))
                .unwrap();
            let single: Vec<f64> = shared
                .separate
                .iter()
                .map(|own| own.std_dev.unwrap())
                .collect();
            let mean = single.iter().sum::<f64>() / single.len() as f64;
            ratios.push(mean / shared.std_dev.unwrap());
        }
    }
    ratios.sort_by(f64::total_cmp);
    let (median, least) = (ratios[ratios.len() / 2], ratios[0]);
    let coverage = covered as f64 / intervals as f64;
    println!(
        "{intervals} intervals cover {:.1} %, {median:.2} times shorter (least {least:.2}); {refused} of {tests} refused",
        100.0 * coverage
    );
    assert!(
        (coverage - 0.95).abs() <= chance(0.95, intervals),
        "{coverage}"
    );
    assert!(median >= 1.5, "{median}");
    // Two tests share the level of a run.
    let most = 0.5 * LEVEL + chance(0.5 * LEVEL, tests);
    assert!(
        refused as f64 / tests as f64 <= most,
        "{refused} of {tests}"
    );
}

#[test]
fn motors_that_differ_refuse_to_have_parameters_in_common() {
    let fits = fits(47_000, 0.15);
    let refused = fits.iter().filter(|(_, fitted)| {
        let mut answers = fitted.fit.sharing.iter();
        answers.any(|answer| answer.refused)
    });
    let refused = refused.count();
    println!("{refused} of {ROBOTS} refused");
    assert!(
        refused as f64 >= 0.95 * ROBOTS as f64,
        "{refused} of {ROBOTS}"
    );
    let sentence = &answer(&fits[0].1, "viscous_friction").sentence;
    assert!(sentence.contains("drive.shared"), "{sentence}");
}

#[test]
fn joints_of_one_type_are_asked_and_what_they_may_share_is_proposed() {
    let robot = Robot::drawn(5, 0.0);
    robot.simulate("", "");
    let (asked, shared) = (robot.fit(ASKED), robot.fit(SHARED));
    for effect in ["coulomb_friction", "viscous_friction"] {
        let (asked, shared) = (answer(&asked, effect), answer(&shared, effect));
        assert!(!asked.in_model && !asked.refused, "{}", asked.sentence);
        assert!(
            asked.sentence.contains("[[drive.shared]]"),
            "{}",
            asked.sentence
        );
        // Both tests are of the model in which every joint has its own.
        let statistics = [asked, shared].map(|answer| answer.statistic.unwrap());
        assert!(
            (statistics[0] - statistics[1]).abs() <= 1e-3 * (1.0 + statistics[0]),
            "{statistics:?}"
        );
        for (a, b) in asked.parameters.iter().zip(&shared.parameters) {
            let (a, b, deviation) = (a.value.unwrap(), b.value.unwrap(), b.std_dev.unwrap());
            assert!(
                (a - b).abs() <= 0.05 * deviation,
                "{a} and {b} ± {deviation}"
            );
        }
    }
    // Every joint has its own where nothing is shared.
    assert_ne!(
        asked.estimate.find("j3.viscous_friction.Fv").unwrap().value,
        asked.estimate.find("j4.viscous_friction.Fv").unwrap().value
    );
}

#[test]
fn a_diagnosis_says_that_joints_have_a_finding_in_common() {
    let robot = Robot::drawn(6, 0.0);
    let found = "effects_of = { j3 = [\"coulomb_friction\", \"viscous_friction\", \"stribeck_friction\"], \
                 j4 = [\"coulomb_friction\", \"viscous_friction\", \"stribeck_friction\"], \
                 j5 = [\"coulomb_friction\", \"viscous_friction\", \"stribeck_friction\"] }\n";
    let truth = "\"j3.stribeck_friction.Fs\" = 1.2\n\"j3.stribeck_friction.vs\" = 0.2\n";
    // What is given of one joint holds for those that share it.
    let shared =
        "[[drive.shared]]\njoints = [\"j3\", \"j4\", \"j5\"]\neffects = [\"stribeck_friction\"]\n";
    robot.simulate(&format!("{found}{shared}"), truth);
    let run = diagnose::run(&robot.read(ASKED, ""), &Control::default(), &|_| ()).unwrap();
    let mut joints: Vec<&String> = run
        .diagnosis
        .findings
        .iter()
        .flat_map(|f| &f.joints)
        .collect();
    joints.sort();
    assert_eq!(joints, ["j3", "j4", "j5"], "{}", run.diagnosis.summary);
    let answers = &run.diagnosis.fit.as_ref().unwrap().sharing;
    let stribeck = answers
        .iter()
        .find(|answer| answer.effect == "stribeck_friction")
        .unwrap();
    assert!(
        !stribeck.refused && !stribeck.in_model,
        "{}",
        stribeck.sentence
    );
    assert_eq!(stribeck.joints, ["j3", "j4", "j5"]);
    let size = stribeck
        .parameters
        .iter()
        .find(|p| p.name.ends_with("Fs"))
        .unwrap();
    let (value, deviation) = (size.value.unwrap(), size.std_dev.unwrap());
    assert!(
        (value - 1.2).abs() <= 4.0 * deviation,
        "{value} ± {deviation}"
    );
    let single: Vec<f64> = size
        .separate
        .iter()
        .map(|own| own.std_dev.unwrap())
        .collect();
    assert!(
        single.iter().all(|own| *own > deviation),
        "{single:?}, {deviation}"
    );
}

#[test]
fn values_and_bounds_of_one_joint_hold_for_all_that_share() {
    let robot = Robot::drawn(7, 0.0);
    robot.simulate("", "");
    let known = format!("values = {{ \"j5.viscous_friction.Fv\" = 2.0 }}\n{SHARED}");
    let fitted = robot.fit(&known);
    let viscous = fitted.estimate.find("j3.viscous_friction.Fv").unwrap();
    assert_eq!((viscous.value, viscous.std_dev), (Some(2.0), None));
    assert_eq!(viscous.shared_by, ["j3", "j4", "j5"]);
}

#[test]
fn what_cannot_be_shared_is_refused_with_a_remedy() {
    let robot = Robot::drawn(8, 0.0);
    robot.simulate("", "");
    let table = |rest: &str| format!("[[drive.shared]]\n{rest}\n");
    let twice = table("joints = [\"j4\", \"j5\"]\neffects = [\"viscous_friction\"]");
    for (drive, expected) in [
        (table("joints = [\"j4\", \"elbow\"]"), "elbow"),
        (
            table("joints = [\"j4\", \"j5\"]\neffects = [\"base_tilt\"]"),
            "base_tilt",
        ),
        (
            table(
                "joints = [\"j4\", \"j5\"]\neffects = [\"viscous_friction\"]\nseparate = [\"torque_ripple.pase\"]",
            ),
            "torque_ripple.pase",
        ),
        (format!("{twice}{twice}"), "shared twice"),
        (
            format!("values = {{ \"j4.Fv\" = 1.0, \"j5.Fv\" = 2.0 }}\n{twice}"),
            "two values",
        ),
    ] {
        let problem = robot.read(&drive, "");
        let error = fit::run(&problem, &Control::default(), |_| ()).unwrap_err();
        let message = error.to_string();
        assert!(message.contains(expected), "{message}");
    }
    let one = robot.problem(&table("joints = [\"j4\"]"), "");
    let path = robot.folder.path().join("problem.toml");
    assert!(ProblemFile::parse(&path, &one, &[], &ids()).is_err());
}

/// Derivatives with respect to common parameters are those by differences, through losses, springs and laws.
#[test]
fn invariant_columns_of_common_parameters_are_derivatives() {
    const COUNT: usize = 3;
    let effects = [
        "coulomb_friction",
        "viscous_friction",
        "stribeck_friction",
        "joint_elasticity",
        "load_dependent_friction",
    ];
    let effects: Vec<_> = effects.iter().map(|id| find(id).unwrap()).collect();
    let shared = effects.iter().map(|effect| Common {
        effect,
        joints: vec![0, 2],
        separate: vec!["vs".to_string()],
    });
    let model = Model::new(ModelSettings {
        shared: shared.collect(),
        effects: vec![effects.clone(); COUNT],
        ..ModelSettings::bodies(tree(&mut generator(3), COUNT), Signal::Torque)
    })
    .unwrap();
    let mut values = model.generic_values();
    let is_shape =
        |p: &usize| model.parameters()[*p].is_free() && !model.parameters()[*p].role.is_inertial();
    let columns: Vec<usize> = (0..model.parameters().len()).filter(is_shape).collect();
    // Eight parameters of three joints, of which two have all but vs in common.
    let per_joint: usize = effects.iter().map(|effect| effect.parameters.len()).sum();
    assert_eq!(columns.len(), 2 * per_joint + 1);
    for &p in &columns {
        values[p] = match values[p] {
            0.0 => 0.3,
            x => x,
        };
    }
    let rates: [f64; COUNT] = std::array::from_fn(|j| 3.0 + 0.7 * j as f64);
    let motion = Sines {
        amplitude: 1.0,
        rates: &rates,
        samples: 200,
        rate_hz: 100.0,
    };
    let own = Columns {
        model: &model,
        values: &values,
        parameters: &columns,
        step: 1e-5,
        least: 0.0,
        // Central differences of a function that is computed to eleven digits.
        tolerance: 1e-4,
    };
    own.assert_derivatives_along(&motion);
}
